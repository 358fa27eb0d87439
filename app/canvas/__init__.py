"""The picture and what lies over it, with the mouse and the keys that work on it."""
