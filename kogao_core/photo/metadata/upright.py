"""EXIF and XMP blocks of a photo that was turned upright, changed in place.

Blocks are patched, not rebuilt: makers' notes hold offsets that don't survive a move.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from PIL.ExifTags import Base as Tag

PREFIX: Final = b"Exif\0\0"
_SHORT, _LONG = 3, 4
_XMP_ORIENTATION: Final = re.compile(rb"""(tiff:Orientation(?:=["']|>)\s*)([1-8])""")
_XMP_WIDTH, _XMP_HEIGHT = (
    re.compile(rb"""((?:tiff:Image%s|exif:Pixel%sDimension)(?:=["']|>)\s*)[0-9]+""" % names)
    for names in ((b"Width", b"X"), (b"Length", b"Y"))
)
_XMP_THUMBNAILS: Final = (b"xmp:Thumbnails>", b"xap:Thumbnails>")


@dataclass(frozen=True, slots=True)
class _Number:
    """Where a whole number of a directory entry lies."""

    at: int
    code: str


class _Tiff:
    """The TIFF structure inside an EXIF block, in a buffer that can be patched."""

    def __init__(self, block: bytes) -> None:
        self.data = bytearray(block.removeprefix(PREFIX))
        self._order = {b"II": "<", b"MM": ">"}[bytes(self.data[:2])]

    def read(self, number: _Number) -> int:
        value: int = struct.unpack_from(self._order + number.code, self.data, number.at)[0]
        return value

    def write(self, number: _Number, value: int) -> None:
        struct.pack_into(self._order + number.code, self.data, number.at, value)

    def main(self) -> int:
        """Return where the first directory starts."""
        return self.read(_Number(4, "I"))

    def next_link(self, start: int) -> _Number:
        """Return the pointer from a directory to the next one."""
        return _Number(start + 2 + 12 * self.read(_Number(start, "H")), "I")

    def numbers(self, start: int) -> dict[int, _Number]:
        """Return the single whole numbers of a directory by tag."""
        return dict(self._entries(start))

    def _entries(self, start: int) -> Iterator[tuple[int, _Number]]:
        for at in range(start + 2, self.next_link(start).at, 12):
            kind, count = self.read(_Number(at + 2, "H")), self.read(_Number(at + 4, "I"))
            if count == 1 and kind in (_SHORT, _LONG):
                yield self.read(_Number(at, "H")), _Number(at + 8, "H" if kind == _SHORT else "I")


def orientation(exif: bytes | None, xmp: bytes | None) -> int:
    """Return the orientation 1 to 8 that a file asks for; EXIF goes before XMP, 1 if neither."""
    if exif:
        try:
            tiff = _Tiff(exif)
            turn = tiff.numbers(tiff.main()).get(Tag.Orientation)
            if turn is not None:
                value = tiff.read(turn)
                return value if 1 <= value <= 8 else 1
        except (struct.error, KeyError):
            pass  # a damaged block can't ask for anything
    found = _XMP_ORIENTATION.search(xmp or b"")
    return int(found[2]) if found else 1


def upright_exif(exif: bytes, width: int, height: int) -> bytes:
    """Return an EXIF block for upright pixels of the size given, without its thumbnail.

    The thumbnail would show the face as it was. A block that can't be parsed is returned as is.
    """
    try:
        tiff = _Tiff(exif)
        main = tiff.main()
        numbers = tiff.numbers(main)
        if Tag.ExifOffset in numbers:
            numbers |= tiff.numbers(tiff.read(numbers[Tag.ExifOffset]))
        for tag, value in (
            (Tag.Orientation, 1),
            (Tag.ExifImageWidth, width),
            (Tag.ExifImageHeight, height),
        ):
            if tag in numbers:
                tiff.write(numbers[tag], value)
        _drop_thumbnail(tiff, main)
    except (struct.error, KeyError):
        return exif
    return PREFIX + bytes(tiff.data)


def _drop_thumbnail(tiff: _Tiff, main: int) -> None:
    link = tiff.next_link(main)
    second = tiff.read(link)
    if not second:
        return
    numbers = tiff.numbers(second)
    tiff.write(link, 0)
    if Tag.JpegIFOffset not in numbers or Tag.JpegIFByteCount not in numbers:
        return
    start = tiff.read(numbers[Tag.JpegIFOffset])
    end = min(start + tiff.read(numbers[Tag.JpegIFByteCount]), len(tiff.data))
    if end == len(tiff.data):
        del tiff.data[start:]
    else:
        tiff.data[start:end] = bytes(end - start)


def upright_xmp(xmp: bytes, width: int, height: int) -> bytes:
    """Return an XMP packet for upright pixels of the size given, without its thumbnails."""
    xmp = _XMP_ORIENTATION.sub(rb"\g<1>1", xmp)
    for pattern, value in ((_XMP_WIDTH, width), (_XMP_HEIGHT, height)):
        xmp = pattern.sub(rb"\g<1>%d" % value, xmp)
    for name in _XMP_THUMBNAILS:
        xmp = _without(xmp, b"<" + name, b"</" + name)
    return xmp


def _without(text: bytes, start: bytes, end: bytes) -> bytes:
    # In one pass: a hostile text may start a million times and never end.
    kept, at = [], 0
    while (first := text.find(start, at)) >= 0 and (last := text.find(end, first)) >= 0:
        kept.append(text[at:first])
        at = last + len(end)
    return b"".join([*kept, text[at:]])
