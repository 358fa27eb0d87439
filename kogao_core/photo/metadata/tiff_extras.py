"""Extras of a TIFF file, and the end of its data."""

from __future__ import annotations

import os
import struct
from collections.abc import Container, Iterator
from typing import IO, Final

from PIL import ExifTags
from PIL import Image as Pillow
from PIL.ExifTags import Base as Tag

from kogao_core.base.language import Text
from kogao_core.photo.metadata import kinds, tiff
from kogao_core.photo.metadata.kinds import Extra

_LAYERS, CREDENTIALS = 37724, 52545
_NAMED: Final = {
    _LAYERS: Extra(kinds.LAYERS),
    CREDENTIALS: Extra(kinds.CREDENTIALS),
    Tag.SubIFDs: Extra(kinds.FURTHER),
}
# Colour channels by photometric interpretation; default 1.
_COLOURS: Final = {5: 4, **dict.fromkeys((2, 6, 8, 9, 10), 3)}
# Sizes of TIFF's types, by number; 13 is a directory.
_SIZES: Final = dict(enumerate((1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4), start=1))
_POINTERS: Final = {Tag.SubIFDs, Tag.ExifOffset, Tag.GPSInfo, Tag.ExifInteroperabilityOffset}
_PLACES: Final = {273: 279, 324: 325, 513: 514}
_MOST_DIRECTORIES: Final = 1000


def found(read: tiff.TiffTags, channels: int, kept: Container[int]) -> Iterator[Extra]:
    """Yield the extras of the first directory, in tag order. `kept`: rare tags that stay."""
    tags = read.tags
    if tags.get_ifd(ExifTags.IFD.IFD1):
        yield Extra(kinds.FURTHER)
    colours = _COLOURS.get(read.first(Tag.PhotometricInterpretation, 1), 1)
    if (more := read.samples - colours - (channels in (2, 4))) > 0:
        yield Extra(kinds.CHANNELS, Text.counted(more, "{n} extra channel", "{n} extra channels"))
    for tag in tags:
        if tag in _NAMED:
            yield _NAMED[tag]
    rare = [tag for tag in tags if tiff.is_rare(tag)]
    for kind, is_kept in ((kinds.TIFF_TAGS, True), (kinds.UNKNOWN, False)):
        if some := [str(tag) for tag in rare if (tag in kept) == is_kept]:
            yield Extra(kind, Text("TIFF tags {tags}", tags=" ".join(some)))


def has_maker_note(tags: Pillow.Exif) -> bool:
    """Return True if the EXIF directory has a maker's note."""
    return Tag.MakerNote in tags.get_ifd(Tag.ExifOffset)


def end(file: IO[bytes]) -> int:
    """Return the end offset of the last part that a directory of the file refers to."""
    whole = file.seek(0, os.SEEK_END)
    order = ">" if _bytes_at(file, 0, 2) == b"MM" else "<"
    last, seen = 8, set[int]()
    waiting = [struct.unpack(order + "I", _bytes_at(file, 4, 4))[0]]
    while waiting and len(seen) < _MOST_DIRECTORIES:
        start = waiting.pop()
        if start in seen or not 0 < start < whole - 2:
            continue
        seen.add(start)
        (count,) = struct.unpack(order + "H", _bytes_at(file, start, 2))
        last = max(last, start + 2 + 12 * count + 4)
        numbers: dict[int, tuple[int, ...]] = {}
        entries = _bytes_at(file, start + 2, 12 * count)
        for at in range(start + 2, min(start + 2 + 12 * count, whole - 16), 12):
            tag, kind, size, value = struct.unpack_from(order + "HHII", entries, at - start - 2)
            length = _SIZES.get(kind, 1) * size
            place = at + 8 if length <= 4 else value
            if place + length > whole:
                continue
            last = max(last, place + length)
            if kind in (3, 4, 13):
                letter = "H" if kind == 3 else "I"
                stored = _bytes_at(file, place, length)
                numbers[tag] = struct.unpack(f"{order}{size}{letter}", stored)
                waiting += numbers[tag] if tag in _POINTERS or kind == 13 else ()
        for places, lengths in _PLACES.items():
            pairs = zip(numbers.get(places, ()), numbers.get(lengths, ()), strict=False)
            last = max(last, *(at + length for at, length in pairs), 0)
        after = start + 2 + 12 * count
        if after + 4 <= whole:
            waiting.append(struct.unpack(order + "I", _bytes_at(file, after, 4))[0])
    return min(last, whole)


def _bytes_at(file: IO[bytes], at: int, count: int) -> bytes:
    file.seek(at)
    return file.read(count)
