"""Sections 3.1 and 3.2 of the paper: feature points, zones, symmetry, centres and target points.

Imports only `base` and `recipe`; `landmarks/` finds the points.
"""
