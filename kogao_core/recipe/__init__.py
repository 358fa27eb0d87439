"""Settings, recipes (all settings of a user as one value) and presets (recipes with names).

Imports only `base`.
"""
