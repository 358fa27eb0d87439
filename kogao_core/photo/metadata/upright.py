"""How a stored picture becomes upright, and EXIF blocks whose numbers follow it, changed in place.

Blocks are patched, not rebuilt: makers' notes hold offsets that don't survive a move.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

from PIL.ExifTags import Base as Tag

PREFIX: Final = b"Exif\0\0"
_CODES: Final = {3: "H", 4: "I", 5: "Q"}  # of types; a rational is moved as a whole
# Pairs of the first, the EXIF and the interoperability directory that change places with the sides.
_SIDES: Final[tuple[tuple[int, int], ...]] = (
    (Tag.ImageWidth, Tag.ImageLength),
    (Tag.XResolution, Tag.YResolution),
    (Tag.FocalPlaneXResolution, Tag.FocalPlaneYResolution),
    (Tag.RelatedImageWidth, Tag.RelatedImageLength),
)
_SUBJECTS: Final = (0x9214, Tag.SubjectLocation)  # the first is its area
_FURTHER: Final = (Tag.ExifOffset, Tag.ExifInteroperabilityOffset)
_ORIENTATION: Final = re.compile(rb"""tiff:Orientation(?:=["']|>)\s*([1-8])""")
_DAMAGED: Final = (struct.error, KeyError)


@dataclass(frozen=True, slots=True)
class Turn:
    """How a picture as it is stored becomes upright."""

    orientation: int  # EXIF's, 1 to 8; at 1 it stays as it lies, whatever its file says
    # Of the result, px.
    width: int
    height: int

    @property
    def swaps_sides(self) -> bool:
        """Whether rows become columns."""
        return self.orientation >= 5

    @property
    def is_mirrored(self) -> bool:
        """Whether writing would be seen in a mirror."""
        return self.orientation in (2, 4, 5, 7)

    def place(self, at: Sequence[Any], ends: Sequence[Any]) -> tuple[Any, Any]:
        """Return a place (x, y) of the stored picture in the upright one, which ends at `ends`."""
        x, y = self.sides(at)
        return (
            ends[0] - x if self.orientation in (2, 3, 6, 7) else x,
            ends[1] - y if self.orientation in (3, 4, 7, 8) else y,
        )

    def sides(self, of: Sequence[Any]) -> tuple[Any, Any]:
        """Return what goes along x and y of the stored picture, along those of the upright one."""
        return (of[1], of[0]) if self.swaps_sides else (of[0], of[1])


@dataclass(frozen=True, slots=True)
class _Numbers:
    """Where whole or rational numbers of a directory entry lie."""

    at: int
    code: str


class _Tiff:
    """The TIFF structure inside an EXIF block, in a buffer that can be patched."""

    def __init__(self, block: bytes) -> None:
        self.data = bytearray(block.removeprefix(PREFIX))
        self._order = {b"II": "<", b"MM": ">"}[bytes(self.data[:2])]

    def all(self, numbers: _Numbers) -> tuple[int, ...]:
        return struct.unpack_from(self._order + numbers.code, self.data, numbers.at)

    def read(self, numbers: _Numbers) -> int:
        return self.all(numbers)[0]

    def write(self, numbers: _Numbers, *values: int) -> None:
        struct.pack_into(self._order + numbers.code, self.data, numbers.at, *values)

    def main(self) -> int:
        """Return where the first directory starts."""
        return self.read(_Numbers(4, "I"))

    def next_link(self, start: int) -> _Numbers:
        """Return the pointer from a directory to the next one."""
        return _Numbers(start + 2 + 12 * self.read(_Numbers(start, "H")), "I")

    def entries(self, start: int) -> dict[int, _Numbers]:
        """Return the numbers of a directory by tag; of the long lists none."""
        found = {}
        for at in range(start + 2, self.next_link(start).at, 12):
            (tag, kind), count = self.all(_Numbers(at, "2H")), self.read(_Numbers(at + 4, "I"))
            if kind in _CODES and 1 <= count <= 4:
                code = f"{count}{_CODES[kind]}"
                inline = struct.calcsize(f"={code}") <= 4
                found[tag] = _Numbers(at + 8 if inline else self.read(_Numbers(at + 8, "I")), code)
        return found


def orientation(exif: bytes | None, xmp: bytes | None) -> int:
    """Return the orientation 1 to 8 that a file asks for; EXIF goes before XMP, 1 if neither."""
    if exif:
        with suppress(*_DAMAGED):  # a damaged block can't ask for anything
            tiff = _Tiff(exif)
            turn = tiff.entries(tiff.main()).get(Tag.Orientation)
            if turn is not None:
                value = tiff.read(turn)
                return value if 1 <= value <= 8 else 1
    found = _ORIENTATION.search(xmp or b"")
    return int(found[1]) if found else 1


def turned_exif(exif: bytes, turn: Turn, small: Callable[[bytes], bytes]) -> bytes:
    """Return an EXIF block for a picture that was turned, with a thumbnail of its own.

    The old one would show the face as it was: `small` returns one that is no longer in its place,
    or nothing. What can't be parsed stays as it is.
    """
    try:
        tiff = _Tiff(exif)
        main = start = tiff.main()
    except _DAMAGED:
        return exif
    with suppress(*_DAMAGED):
        for further in (*_FURTHER, None):
            numbers = tiff.entries(start)
            _turn(tiff, numbers, turn)
            if further not in numbers:
                break
            start = tiff.read(numbers[further])
    with suppress(*_DAMAGED):
        _replace_thumbnail(tiff, main, turn, small)
    return PREFIX + bytes(tiff.data)


def _turn(tiff: _Tiff, numbers: dict[int, _Numbers], turn: Turn) -> None:
    """Turn what a directory counts in the picture's axes."""
    sizes = ((Tag.ExifImageWidth, turn.width), (Tag.ExifImageHeight, turn.height))
    upright = ((Tag.Orientation, 1),) if turn.orientation != 1 else ()
    for tag, value in (*upright, *sizes):
        if tag in numbers:
            tiff.write(numbers[tag], value)
    for pair in _SIDES:
        if turn.swaps_sides and set(pair) <= numbers.keys():
            first, second = (numbers[tag] for tag in pair)
            one, other = tiff.read(first), tiff.read(second)
            tiff.write(first, other)
            tiff.write(second, one)
    for tag in _SUBJECTS:
        values = tiff.all(numbers[tag]) if tag in numbers else ()
        if len(values) >= 2:
            at = turn.place(values, (turn.width - 1, turn.height - 1))
            size = turn.sides(values[2:]) if len(values) == 4 else values[2:]
            tiff.write(numbers[tag], *(max(0, number) for number in at), *size)


def _replace_thumbnail(tiff: _Tiff, main: int, turn: Turn, small: Callable[[bytes], bytes]) -> None:
    link = tiff.next_link(main)
    second = tiff.read(link)
    if not second:
        return
    numbers = tiff.entries(second)
    tiff.write(link, 0)
    if Tag.JpegIFOffset not in numbers or Tag.JpegIFByteCount not in numbers:
        return
    start = tiff.read(numbers[Tag.JpegIFOffset])
    end = min(start + tiff.read(numbers[Tag.JpegIFByteCount]), len(tiff.data))
    fresh = small(bytes(tiff.data[start:end]))
    if fresh:
        _turn(tiff, numbers, turn)
        tiff.write(numbers[Tag.JpegIFByteCount], len(fresh))
        tiff.write(link, second)
    # Nothing else in the block moves.
    at_end = end == len(tiff.data)
    tiff.data[start:end] = fresh if at_end else fresh.ljust(end - start, b"\0")
