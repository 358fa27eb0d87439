"""JPEG files block by block: what nothing changed is written as it was read."""
