"""Photo formats: one module and one `FileFormat` each.

To add a format, write a module and add a line to `ALL`.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.photo.formats.avif import AVIF
from kogao_core.photo.formats.base import FileFormat
from kogao_core.photo.formats.heif import HEIF
from kogao_core.photo.formats.jpeg import JPEG
from kogao_core.photo.formats.png import PNG
from kogao_core.photo.formats.raw import RAW
from kogao_core.photo.formats.tiff import TIFF
from kogao_core.photo.formats.webp import WEBP

# In the order of sentences and documents.
ALL: Final = (JPEG, PNG, TIFF, WEBP, AVIF, HEIF, RAW)
WRITTEN: Final = tuple(form for form in ALL if form.encode is not None)
BY_NAME: Final = {form.name: form for form in ALL}
# By the endings of names.
FORMATS: Final[dict[str, str]] = {suffix: form.name for form in WRITTEN for suffix in form.suffixes}


def suffix_of(path: str | os.PathLike[str]) -> str:
    """Return the suffix of a file name in lower case; spaces at the end of the name are no part."""
    return Path(path).suffix.strip().lower()


READABLE: Final[dict[str, str]] = {suffix: form.name for form in ALL for suffix in form.suffixes}
READ_ONLY: Final[dict[str, str]] = {
    suffix: name for suffix, name in READABLE.items() if suffix not in FORMATS
}


def of(path: str | os.PathLike[str]) -> FileFormat:
    """Return the format of an output path; the extension must be in `FORMATS`."""
    return BY_NAME[FORMATS[Path(path).suffix.lower()]]


def either(words: list[str]) -> Text:
    """Return words as a choice: a, b or c."""
    if len(words) < 2:
        return Text.joined("", words)
    return Text("{some} or {last}", some=Text.joined(", ", words[:-1]), last=words[-1])


def exact_endings(pixels: Image, without: FileFormat) -> str:
    """Return the extensions of other lossless formats for these pixels, as a choice."""
    lossless = (form for form in WRITTEN if form.is_lossless and form is not without)
    return either([one.suffixes[0] for one in lossless if pixels.dtype.name in one.layouts])
