"""From a state of the document to pixels on the screen."""
