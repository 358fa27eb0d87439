"""Commands that create the project's own files in `resources`, run from a checkout.

The wheel does not contain this package, and the program does not import it.
"""
