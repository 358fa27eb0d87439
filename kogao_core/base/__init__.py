"""Utilities for all packages: translation, atomic files, JSON, geometry, threads.

Modules here import no other package of Kogao.
"""
