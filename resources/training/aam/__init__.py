"""How the committed model is made: see ``__main__``."""
