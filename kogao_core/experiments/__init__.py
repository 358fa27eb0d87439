"""Instruments built on the core: reproducible experiments, each one command."""
