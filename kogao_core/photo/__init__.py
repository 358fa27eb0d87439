"""Photographs in and out: pixels at full depth, upright, with the metadata they came with."""

from kogao_core.photo.errors import CannotWrite, RefusedOutput, UnreadablePhoto
from kogao_core.photo.model import FORMATS, Format, Photo
from kogao_core.photo.reading import MAX_MEGAPIXELS, read
from kogao_core.photo.writing import check_holds, check_output, write

__all__ = [
    "FORMATS",
    "MAX_MEGAPIXELS",
    "CannotWrite",
    "Format",
    "Photo",
    "RefusedOutput",
    "UnreadablePhoto",
    "check_holds",
    "check_output",
    "read",
    "write",
]
