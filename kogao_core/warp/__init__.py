"""Sections 2, 3.3 and 4 of the paper: lattice, fit, field, guard, domain and resampling.

It may use `base`, `recipe` and `faces`, and knows nothing of files.
"""
