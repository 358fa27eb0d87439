"""Training of the committed Active Appearance Model: see ``__main__``."""
