"""Read ratings, labels, names of people and Kogao's edit record without decoding the photo.

See decision 8.
"""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

MOST_STARS: Final = 5
REJECTED: Final = -1
LABELS: Final = ("Red", "Yellow", "Green", "Blue", "Purple")
"""As most programs call them; `Rated.label` may be any text."""
_HEAD_BYTES: Final = 1 << 18
_TAIL_BYTES: Final = 1 << 16
_OURS: Final = re.compile(rb"""stEvt:softwareAgent(?:\s*=\s*["']|>)Kogao """)
_RATING, _LABEL, _PERSON = (
    "(?:xmp|xap):Rating",
    "(?:xmp|xap):Label",
    "(?:mwg-rs:|MPReg:PersonDisplay)Name",
)
_VALUE: Final = rb"""%s(?:\s*=\s*(?:"([^"<]*)"|'([^'<]*)')|\s*>([^<]*)<|\s*/>)"""
_FOUND: Final = {name: re.compile(_VALUE % name.encode()) for name in (_RATING, _LABEL, _PERSON)}


@dataclass(frozen=True, slots=True)
class Rated:
    """Rating and label of a photo, and names in it."""

    stars: int = 0  # 1 to `MOST_STARS`; 0 without any, `REJECTED`
    label: str = ""  # one of `LABELS`, or the label of another program
    people: frozenset[str] = frozenset()  # names of regions in the photo's metadata


UNRATED: Final = Rated()


def is_ours(path: Path) -> bool:
    """Return True if the start or the end of a file holds Kogao's edit record."""
    return any(map(has_record, _ends(path)))


def has_record(data: bytes) -> bool:
    """Return whether XMP data hold an edit record of Kogao."""
    return _OURS.search(data) is not None


def rating_of(photo: Path) -> Rated:
    """Return rating, label and names from the sidecar or the start or end of the photo.

    Names are of the photo only.
    """
    read = [_ends(photo)]
    people = frozenset(map(str.strip, _values(_PERSON, read))) - {""}  # of end tags
    sidecar = _sidecar(photo)
    if sidecar is not None:
        read.insert(0, _ends(sidecar))
    stars, label = (next(_values(name, read), "") for name in (_RATING, _LABEL))
    try:
        number = round(float(stars or "0"))
    except (ValueError, OverflowError):
        number = 0
    return Rated(max(REJECTED, min(number, MOST_STARS)), label.strip(), people)


def _sidecar(photo: Path) -> Path | None:
    """Return the existing XMP sidecar, NAME.EXT.xmp or NAME.xmp, or None."""
    places = (photo.with_name(f"{photo.name}.xmp"), photo.with_suffix(".xmp"))
    return next((one for one in places if one.is_file()), None)


def _ends(path: Path) -> tuple[bytes, bytes]:
    """Return the first and last bytes of a file; empty for pipes, which would block."""
    if not path.is_file():
        return b"", b""
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        left = os.fstat(file.fileno()).st_size - len(head)
        file.seek(-min(_TAIL_BYTES, left), os.SEEK_END)
        return head, file.read()


def _values(name: str, read: list[tuple[bytes, bytes]]) -> Iterator[str]:
    """Yield the values of a property."""
    for part in (part for ends in read for part in ends):
        for found in _FOUND[name].finditer(part):
            text = next((one for one in found.groups() if one is not None), b"")
            yield html.unescape(text.decode("utf-8", "replace"))
