"""Experiment reports: text, tables, files and HTML pages with charts."""
