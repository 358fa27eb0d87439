"""The paper alone: numpy and rectangles, nothing of the additions. Start with `walk`.

Seo, Chen and Aoki (2011): a lattice (2.1), landmarks to targets (3.2), its size (3.3), the reduced
domain (4). Names and numbers of equations are those of the paper.
"""
