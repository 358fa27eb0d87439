"""Panels round the canvas: each emits what the user wants and shows what it is told."""
