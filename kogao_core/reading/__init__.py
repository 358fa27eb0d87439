"""Read a retouch: measure how an edited copy moved each face, and express it in settings.

It may use all packages up to `pipeline`.
"""
