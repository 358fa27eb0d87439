"""Controllers turn the views' signals into states of the document, and its states into pictures."""
