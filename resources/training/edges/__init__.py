"""Training of the network for the outline's edge: see ``__main__``."""
