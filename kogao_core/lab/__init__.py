"""The laboratory: the paper's experiments, rival methods and a blind study.

It may use every room; none uses it, and everything else works where this folder isn't. Its door
is `installed.has_laboratory`.
"""
