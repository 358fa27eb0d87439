"""What can go wrong with a file; each message is one sentence with what to do next."""

from __future__ import annotations


class UnreadablePhoto(Exception):
    """The file can't be read as a photo."""


class CannotWrite(Exception):
    """The photo can't be written there."""


class RefusedOutput(CannotWrite):
    """The output asked for would lose something: an existing file, or part of the picture."""


class CannotDisclose(CannotWrite):
    """A disclosure can't be added to the photo."""


class MissingExtra(CannotDisclose):
    """It takes a library that isn't installed."""
