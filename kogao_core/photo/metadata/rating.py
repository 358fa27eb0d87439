"""Ratings, labels and Kogao's edit record in XMP, read without decoding the photo.

Ratings are written to a sidecar, not to the photo (decision 8).
"""

from __future__ import annotations

import html
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from kogao_core.base.atomic import atomic_write
from kogao_core.base.language import Text
from kogao_core.base.wording import printable
from kogao_core.photo.metadata import xmp

MOST_STARS: Final = 5
REJECTED: Final = -1
LABELS: Final = ("Red", "Yellow", "Green", "Blue", "Purple")
"""As most programs call them; `Rated.label` may be any text."""
_HEAD_BYTES: Final = 1 << 18
_TAIL_BYTES: Final = 1 << 16
_OURS: Final = re.compile(rb"""stEvt:softwareAgent(?:\s*=\s*["']|>)Kogao """)
_NAMESPACE: Final = "http://ns.adobe.com/xap/1.0/"
_RATING, _LABEL = "Rating", "Label"
_VALUE: Final = rb"""(?:xmp|xap):%s(?:\s*=\s*(?:"([^"<]*)"|'([^'<]*)')|\s*>([^<]*)<|\s*/>)"""
_FOUND: Final = {name: re.compile(_VALUE % name.encode()) for name in (_RATING, _LABEL)}


@dataclass(frozen=True, slots=True)
class Rated:
    """Rating and label of a photo."""

    stars: int = 0  # 1 to `MOST_STARS`; 0 without any, `REJECTED`
    label: str = ""  # one of `LABELS`, or the label of another program


UNRATED: Final = Rated()


def is_ours(path: Path) -> bool:
    """Return True if the start or the end of a file holds Kogao's edit record."""
    return any(map(has_record, _ends(path)))


def has_record(data: bytes) -> bool:
    """Return whether XMP data hold an edit record of Kogao."""
    return _OURS.search(data) is not None


def rating_of(photo: Path) -> Rated:
    """Return rating and label of a photo, from the sidecar or the start or end of the photo."""
    read = [_ends(photo)]
    sidecar = _sidecar(photo)
    if sidecar is not None:
        read.insert(0, _ends(sidecar))
    stars, label = (_first(name, read) for name in (_RATING, _LABEL))
    try:
        number = round(float(stars or "0"))
    except (ValueError, OverflowError):
        number = 0
    return Rated(max(REJECTED, min(number, MOST_STARS)), (label or "").strip())


def rate(photo: Path, stars: int | None = None, label: str | None = None) -> None:
    """Write a rating, a label or both to the photo's sidecar. Other sidecar data stay.

    Raises OSError; ValueError if the sidecar is not XMP.
    """
    new = {} if stars is None else {_RATING: str(stars)}
    new |= {} if label is None else {_LABEL: label}
    sidecar = _sidecar(photo)
    packet = xmp.EMPTY if sidecar is None else sidecar.read_bytes()
    file = sidecar or photo.with_name(f"{photo.name}.xmp")
    try:
        atomic_write(_changed(packet, new), file)
    except xmp.BadXmp as error:
        name = printable(file.name)
        raise ValueError(Text("{name} isn't XMP ({reason})", name=name, reason=error)) from None


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


def _first(name: str, read: list[tuple[bytes, bytes]]) -> str | None:
    """Return the first value of a property, or None."""
    for part in (part for ends in read for part in ends):
        if found := _FOUND[name].search(part):
            text = next((one for one in found.groups() if one is not None), b"")
            return html.unescape(text.decode("utf-8", "replace"))
    return None


def _changed(packet: bytes, new: Mapping[str, str]) -> bytes:
    """Set properties of a packet. Return the packet. Raises BadXmp."""
    there, edits = xmp.parts(packet), dict[xmp.Span, bytes]()
    texts = {name: html.escape(value) for name, value in new.items()}
    paths = {(*xmp.DESCRIPTION, f"{_NAMESPACE} {name}"): name for name in new}
    known = {paths[one.path]: one for one in there if one.path in paths}
    for name, one in known.items():
        if (value := one.value(packet)) is not None:
            edits[value] = texts[name].encode()
        else:
            tag = xmp.tag_name(packet, one.span[0])
            edits[one.span] = b"<%b>%b</%b>" % (tag, texts[name].encode(), tag)
    if len(known) < len(new):
        values = " ".join(f'xmp:{name}="{texts[name]}"' for name in new if name not in known)
        attributes = f'rdf:about="" xmlns:xmp="{_NAMESPACE}" {values}/>'
        edits |= xmp.described(packet, there, attributes)
    return xmp.replaced(packet, edits)
