"""The canvas: photo, overlays, and mouse and key input."""
