"""Reusable widgets, independent of features."""
