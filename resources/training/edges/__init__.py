"""How the network that finds the outline's edge is made: see ``__main__``."""
