"""Layers over the photo; each class declares one."""
