"""What XMP says of a photo at a glance: who made it, its stars and label; the photo isn't read.

Stars that are set are written into a sidecar, never into the photo: decision 8.
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
_QUOTED: Final = re.compile(rb"""=\s*(?:"[^"]*"|'[^']*')$""")


@dataclass(frozen=True, slots=True)
class Rated:
    """What somebody thinks of a photo."""

    stars: int = 0  # 1 to `MOST_STARS`; 0 without any, `REJECTED`
    label: str = ""  # one of `LABELS`, or what another program calls its own


UNRATED: Final = Rated()


def is_ours(path: Path) -> bool:
    """Tell whether an edit record near a file's beginning or end says that this program made it."""
    return any(map(has_record, _ends(path)))


def has_record(data: bytes) -> bool:
    """Return whether XMP data hold an edit record of Kogao."""
    return _OURS.search(data) is not None


def rating_of(photo: Path) -> Rated:
    """Return stars and label of a photo: of its sidecar, or else near its beginning or end."""
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
    """Write stars, a label, or both into a photo's sidecar; nothing else in it changes.

    Raises OSError, and ValueError where a sidecar is there that isn't XMP.
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
    """Return the XMP file beside a photo, by its whole name or its stem, if there is one."""
    places = (photo.with_name(f"{photo.name}.xmp"), photo.with_suffix(".xmp"))
    return next((one for one in places if one.is_file()), None)


def _ends(path: Path) -> tuple[bytes, bytes]:
    """Return a file's beginning and end; nothing of what is no file: a pipe would be waited for."""
    if not path.is_file():
        return b"", b""
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        left = os.fstat(file.fileno()).st_size - len(head)
        file.seek(-min(_TAIL_BYTES, left), os.SEEK_END)
        return head, file.read()


def _first(name: str, read: list[tuple[bytes, bytes]]) -> str | None:
    """Return what is said first of a property; None where nothing is."""
    for part in (part for ends in read for part in ends):
        if found := _FOUND[name].search(part):
            text = next((one for one in found.groups() if one is not None), b"")
            return html.unescape(text.decode("utf-8", "replace"))
    return None


def _changed(packet: bytes, new: Mapping[str, str]) -> bytes:
    """Return a packet with other values of properties. Raises BadXmp."""
    there = xmp.parts(packet)
    top = next((one.span for one in there if one.path == xmp.DESCRIPTION[:1]), None)
    if top is None:
        raise xmp.BadXmp(Text("it holds no rdf:RDF"))
    paths = {(*xmp.DESCRIPTION, f"{_NAMESPACE} {name}"): name for name in new}
    known = {one.span: paths[one.path] for one in there if one.path in paths}
    edits = {span: _written(packet, span, new[name]) for span, name in known.items()}
    added = {name: value for name, value in new.items() if name not in known.values()}
    if added:
        values = " ".join(f'xmp:{name}="{html.escape(value)}"' for name, value in added.items())
        attributes = f'xmlns:rdf="{xmp.RDF}" rdf:about="" xmlns:xmp="{_NAMESPACE}" {values}'
        start, end, content = xmp.appended(packet, top, f"<rdf:Description {attributes}/>\n")
        edits[start, end] = content
    return xmp.replaced(packet, edits)


def _written(packet: bytes, span: xmp.Span, value: str) -> bytes:
    """Return an attribute or element with another value."""
    start, end = span
    old = packet[start:end]
    if not old.startswith(b"<"):
        return _QUOTED.sub(b"", old) + b'="' + html.escape(value).encode() + b'"'
    name = xmp.tag_name(packet, start)
    return b"<" + name + b">" + html.escape(value).encode() + b"</" + name + b">"
