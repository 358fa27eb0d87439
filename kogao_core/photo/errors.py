"""Exceptions for reading and writing photos. Each message ends with a remedy for the user."""

from __future__ import annotations

from kogao_core.base.language import TextError


class UnreadablePhoto(TextError):
    """The file can't be read as a photo."""


class CannotWrite(TextError):
    """The photo can't be written to the output path."""


class RefusedOutput(CannotWrite):
    """The output would overwrite a file or lose part of the picture."""


class CannotDisclose(CannotWrite):
    """A disclosure can't be added to the photo."""
