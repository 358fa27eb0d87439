"""The window and the canvas."""
