"""Rotate stored pictures upright, and update sizes and positions in EXIF and XMP.

EXIF blocks are patched, not rebuilt: makers' notes contain offsets. Numbers in XMP keep their
decimals. Unsupported positions are removed (`references`).
"""

from __future__ import annotations

import io
import os
import re
import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Final

import numpy as np
from PIL.ExifTags import Base as Tag

from kogao_core.base.geometry import Image
from kogao_core.photo.metadata import xmp
from kogao_core.photo.metadata.directories import FIRST, Directories, Numbers

PREFIX: Final = b"Exif\0\0"
_KINDS: Final = (3, 4, 5)  # of TIFF: short and long numbers, fractions
# Pairs of tags that swap if the sides swap (first, EXIF and interoperability directory).
_SIDES: Final[tuple[tuple[int, int], ...]] = (
    (Tag.ImageWidth, Tag.ImageLength),
    (Tag.XResolution, Tag.YResolution),
    (Tag.FocalPlaneXResolution, Tag.FocalPlaneYResolution),
    (Tag.RelatedImageWidth, Tag.RelatedImageLength),
)
_SUBJECTS: Final = (0x9214, Tag.SubjectLocation)  # SubjectArea, SubjectLocation
_DAMAGED: Final = (struct.error, KeyError)
_ADOBE: Final = "http://ns.adobe.com/"
_EXIF, _TIFF = f"{_ADOBE}exif/1.0/ ", f"{_ADOBE}tiff/1.0/ "
_AREA, _SIZE = f"{_ADOBE}xmp/sType/Area# ", f"{_ADOBE}xap/1.0/sType/Dimensions# "
_REGION: Final = "http://ns.microsoft.com/photo/1.2/t/Region# Rectangle"
_XMP_SUBJECTS: Final = (f"{_EXIF}SubjectArea", f"{_EXIF}SubjectLocation")
_DIMENSIONS: Final = (f"{_SIZE}w", f"{_SIZE}h")
_CENTRE: Final = (f"{_AREA}x", f"{_AREA}y")
_XMP_SIDES: Final = (
    _DIMENSIONS,
    (f"{_AREA}w", f"{_AREA}h"),
    (f"{_TIFF}XResolution", f"{_TIFF}YResolution"),
    (f"{_EXIF}FocalPlaneXResolution", f"{_EXIF}FocalPlaneYResolution"),
)
_RDF_ITEM: Final = f"{xmp.RDF} li"
_PART: Final = re.compile(rb"[^,\s]+")
_NUMBER: Final = re.compile(rb"-?\d{1,9}(\.\d{1,20})?")
_ORIENTATION: Final = re.compile(rb"""(tiff:Orientation(?:=["']|>)\s*)([1-8])""")
_SIZES: Final = [
    re.compile(rb"""((?:tiff:Image%s|exif:Pixel%sDimension)(?:=["']|>)\s*)[0-9]+""" % names)
    for names in ((b"Width", b"X"), (b"Length", b"Y"))
]
_Structure = dict[str, xmp.Span]
_Changes = Iterator[tuple[xmp.Span, bytes]]
_ONE: Final = Decimal(1)
_TURNS: Final[dict[int, Callable[[Image], Image]]] = {
    1: lambda stored: stored,
    2: np.fliplr,
    3: lambda stored: np.rot90(stored, 2),
    4: np.flipud,
    5: lambda stored: stored.swapaxes(0, 1),
    6: lambda stored: np.rot90(stored, -1),
    7: lambda stored: np.rot90(stored, 2).swapaxes(0, 1),
    8: np.rot90,
}
_BACK: Final = {6: 8, 8: 6}  # all others undo themselves


@dataclass(frozen=True, slots=True)
class Turn:
    """Rotation of a stored picture to upright."""

    orientation: int  # EXIF orientation, 1 to 8; 1 keeps the stored orientation
    # Size of the result, px.
    width: int
    height: int

    @property
    def swaps_sides(self) -> bool:
        """Whether rows become columns."""
        return self.orientation >= 5

    def place(self, at: Sequence[Any], ends: Sequence[Any]) -> tuple[Any, Any]:
        """Map a position (x, y) of the stored to the upright picture, which ends at `ends`."""
        x, y = self.sides(at)
        return (
            ends[0] - x if self.orientation in (2, 3, 6, 7) else x,
            ends[1] - y if self.orientation in (3, 4, 7, 8) else y,
        )

    def sides(self, of: Sequence[Any]) -> tuple[Any, Any]:
        """Map lengths along (x, y) of the stored picture to those of the upright picture."""
        return (of[1], of[0]) if self.swaps_sides else (of[0], of[1])


def _directories(block: bytes) -> Directories:
    return Directories(io.BytesIO(block.removeprefix(PREFIX)))


def _numbers(tiff: Directories, start: int) -> dict[int, Numbers]:
    """Return the numbers of a directory by tag; lists of more than 4 are skipped."""
    return {
        tag: one for tag, one in tiff.entries(start) if one.kind in _KINDS and 1 <= one.count <= 4
    }


def orientation(exif: bytes | None, xmp: bytes | None) -> int:
    """Return the orientation 1 to 8 from EXIF, else from XMP, else 1."""
    if exif:
        with suppress(*_DAMAGED):  # a damaged block can't ask for anything
            tiff = _directories(exif)
            turn = _numbers(tiff, *tiff.read(FIRST)).get(Tag.Orientation)
            if turn is not None:
                value, *_ = tiff.read(turn)
                return value if 1 <= value <= 8 else 1
    found = _ORIENTATION.search(xmp or b"")
    return int(found[2]) if found else 1


def turned_exif(exif: bytes, turn: Turn, small: Callable[[bytes], bytes]) -> bytes:
    """Update an EXIF block for a rotated picture, with a new thumbnail. Return the block.

    `small` returns a new thumbnail, not longer than the old one, or b"". Damaged data stay
    unchanged.
    """
    try:
        tiff = _directories(exif)
        (main,) = tiff.read(FIRST)
    except _DAMAGED:
        return exif
    with suppress(*_DAMAGED):
        start = main
        for further in (Tag.ExifOffset, Tag.ExifInteroperabilityOffset, None):
            numbers = _numbers(tiff, start)
            _turn(tiff, numbers, turn)
            if further not in numbers:
                break
            start, *_ = tiff.read(numbers[further])
    with suppress(*_DAMAGED):
        _replace_thumbnail(tiff, main, turn, small)
    tiff.file.seek(0)
    return PREFIX + tiff.file.read()


def _turn(tiff: Directories, numbers: dict[int, Numbers], turn: Turn) -> None:
    """Update the sizes and positions of a directory."""
    sizes = ((Tag.ExifImageWidth, turn.width), (Tag.ExifImageHeight, turn.height))
    upright = ((Tag.Orientation, 1),) if turn.orientation != 1 else ()
    for tag, value in (*upright, *sizes):
        if tag in numbers:
            tiff.write(numbers[tag], value)
    for pair in _SIDES:
        if turn.swaps_sides and set(pair) <= numbers.keys():
            first, second = (numbers[tag] for tag in pair)
            one, other = tiff.read(first), tiff.read(second)
            tiff.write(first, *other)
            tiff.write(second, *one)
    for tag in _SUBJECTS:
        values = tiff.read(numbers[tag]) if tag in numbers else ()
        if len(values) >= 2:
            at = turn.place(values, (turn.width - 1, turn.height - 1))
            size = turn.sides(values[2:]) if len(values) == 4 else values[2:]
            tiff.write(numbers[tag], *(max(0, number) for number in at), *size)


def _replace_thumbnail(
    tiff: Directories, main: int, turn: Turn, small: Callable[[bytes], bytes]
) -> None:
    link = tiff.link(main)
    (second,) = tiff.read(link)
    if not second:
        return
    numbers = _numbers(tiff, second)
    tiff.write(link, 0)
    if Tag.JpegIFOffset not in numbers or Tag.JpegIFByteCount not in numbers:
        return
    start, length = (tiff.read(numbers[tag])[0] for tag in (Tag.JpegIFOffset, Tag.JpegIFByteCount))
    whole = tiff.file.seek(0, os.SEEK_END)
    tiff.file.seek(start)
    old = tiff.file.read(length)
    fresh = small(old)
    if fresh:
        _turn(tiff, numbers, turn)
        tiff.write(numbers[Tag.JpegIFByteCount], len(fresh))
        tiff.write(link, second)
    # All other data of the block keep their offsets.
    at_end = start + length >= whole
    tiff.file.seek(start)
    tiff.file.write(fresh if at_end else fresh.ljust(len(old), b"\0"))
    if at_end:
        tiff.file.truncate()


def turned_xmp(packet: bytes, turn: Turn) -> bytes:
    """Update an XMP packet for a rotated picture, without thumbnails. Return the packet.

    Updated: face regions (MWG and Microsoft), EXIF subject, resolutions and sizes. In a damaged
    packet, only values found by text search are updated.
    """
    for pattern, size in zip(_SIZES, (turn.width, turn.height), strict=True):
        packet = pattern.sub(rb"\g<1>%d" % size, packet)
    for name in (b"xmp:Thumbnails>", b"xap:Thumbnails>"):
        packet = _without(packet, b"<" + name, b"</" + name)
    if turn.orientation == 1:
        return packet
    packet = oriented_xmp(packet)
    return xmp.replaced(packet, _new(packet, turn))


def oriented_xmp(packet: bytes) -> bytes:
    """Set the orientation in an XMP packet, if any, to 1."""
    return _ORIENTATION.sub(rb"\g<1>1", packet)


def _without(text: bytes, start: bytes, end: bytes) -> bytes:
    # In one pass: a hostile text may start a million times and never end.
    kept, at = [], 0
    while (first := text.find(start, at)) >= 0 and (last := text.find(end, first)) >= 0:
        kept.append(text[at:first])
        at = last + len(end)
    return b"".join([*kept, text[at:]])


def _new(packet: bytes, turn: Turn) -> dict[xmp.Span, bytes]:
    # Spans of simple values by name: for each structure (by position), and for lists.
    by_place: dict[int, _Structure] = {}
    lists: dict[str, list[xmp.Span]] = {}
    for part in xmp.known_parts(packet):
        if len(part.path) <= len(xmp.DESCRIPTION) or (value := part.value(packet)) is None:
            continue
        if part.path[-1] == _RDF_ITEM:
            lists.setdefault(part.path[-3], []).append(value)
        else:
            by_place.setdefault(part.holder, {})[part.path[-1]] = value
    structures = list(by_place.values())
    new: dict[xmp.Span, bytes] = {}
    with suppress(ValueError):  # invalid sizes: assume the axes of the specification
        if _is_upright(packet, structures, turn):
            names = {*_DIMENSIONS, *_CENTRE}
            structures = [one for one in structures if not names & one.keys()]
    for one in structures:
        new.update(_turned(packet, one, turn))
    ends = Decimal(turn.width - 1), Decimal(turn.height - 1)
    for name in _XMP_SUBJECTS:
        spans = lists.get(name, [])
        new.update(_changed(packet, spans[:2], lambda at: turn.place(at, ends)))
        new.update(_changed(packet, spans[2:4], turn.sides))
    return new


def _is_upright(packet: bytes, structures: list[_Structure], turn: Turn) -> bool:
    """Return True if the regions apply to the upright picture, as some programs write."""
    for one in structures:
        if turn.swaps_sides and one.keys() >= set(_DIMENSIONS):
            width, height = (_number(packet, one[name]) for name in _DIMENSIONS)
            return width != height and (width > height) == (turn.width > turn.height)
    return False


def _turned(packet: bytes, structure: _Structure, turn: Turn) -> _Changes:
    for pair in _XMP_SIDES:
        if turn.swaps_sides and structure.keys() >= set(pair):
            spans = [structure[name] for name in pair]
            yield from zip(spans, [packet[slice(*span)] for span in spans[::-1]], strict=True)
    if structure.keys() >= set(_CENTRE):
        centre = [structure[name] for name in _CENTRE]
        yield from _changed(packet, centre, lambda at: turn.place(at, (_ONE, _ONE)))
    if _REGION in structure:
        parts = [part.span() for part in _PART.finditer(packet, *structure[_REGION])]
        yield from _changed(packet, parts, lambda of: _rectangle(of, turn))


def _rectangle(of: Sequence[Decimal], turn: Turn) -> tuple[Decimal, ...]:
    """Rotate a rectangle (left, top, width, height), in shares of the picture."""
    left, top, width, height = of
    corners = [turn.place(at, (_ONE, _ONE)) for at in ((left, top), (left + width, top + height))]
    x, y = (min(places) for places in zip(*corners, strict=True))
    return (x, y, *turn.sides((width, height)))


def _changed(
    packet: bytes, spans: list[xmp.Span], change: Callable[[list[Decimal]], Iterable[Decimal]]
) -> _Changes:
    """Yield spans of a packet with new numbers; nothing if a value is not a number."""
    with suppress(ValueError, IndexError):
        changed = change([_number(packet, span) for span in spans])
        yield from zip(spans, (str(one).encode() for one in changed), strict=True)


def _number(packet: bytes, span: xmp.Span) -> Decimal:
    text = packet[slice(*span)].strip()
    if _NUMBER.fullmatch(text) is None:
        raise ValueError(text)
    return Decimal(text.decode())


def turn_upright(stored: Image, orientation: int) -> Image:
    """Rotate stored pixels, shape (H, W) or (H, W, C), by the orientation 1 to 8."""
    return np.ascontiguousarray(_TURNS[orientation](stored))


def as_stored(upright: Image, orientation: int) -> Image:
    """Rotate upright pixels to the stored orientation; a view if possible."""
    return _TURNS[_BACK.get(orientation, orientation)](upright)
