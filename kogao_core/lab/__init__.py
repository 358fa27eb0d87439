"""The laboratory: the paper's experiments, rival methods and a blind study.

The laboratory may import every other package. No other package imports the laboratory;
`installed.has_laboratory` tells whether this optional folder exists.
"""
