"""What there is to set, every choice of a user as one value, and such values with names.

It may use `base`.
"""
