"""Metadata and other data besides the pixels."""
