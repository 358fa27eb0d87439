"""Extras of a TIFF file, and the end of its data."""

from __future__ import annotations

import os
import struct
from collections.abc import Container, Iterator
from contextlib import suppress
from typing import IO, Final

from PIL import ExifTags
from PIL import Image as Pillow
from PIL.ExifTags import Base as Tag

from kogao_core.base.language import Text
from kogao_core.photo.metadata import kinds, tiff
from kogao_core.photo.metadata.directories import FIRST, Directories, Numbers
from kogao_core.photo.metadata.kinds import Extra

_LAYERS, CREDENTIALS = 37724, 52545
_NAMED: Final = {
    _LAYERS: Extra(kinds.LAYERS),
    CREDENTIALS: Extra(kinds.CREDENTIALS),
    Tag.SubIFDs: Extra(kinds.FURTHER),
}
# Colour channels by photometric interpretation; default 1.
_COLOURS: Final = {5: 4, **dict.fromkeys((2, 6, 8, 9, 10), 3)}
_DIRECTORY: Final = 13  # TIFF's type
_POINTERS: Final = {Tag.SubIFDs, Tag.ExifOffset, Tag.GPSInfo, Tag.ExifInteroperabilityOffset}
_PLACES: Final = ((273, 279), (324, 325), (513, 514))  # offsets and lengths
_MOST_DIRECTORIES: Final = 1000


def found(
    read: tiff.TiffTags, channels: int, kept: Container[int], *, only_thumbnails: bool
) -> Iterator[Extra]:
    """Yield the extras of the first directory, in tag order. `kept`: rare tags that stay.

    `only_thumbnails`: all other directories hold thumbnails, which show the face as it was.
    """
    tags = read.tags
    if tags.get_ifd(ExifTags.IFD.IFD1) and not only_thumbnails:
        yield Extra(kinds.FURTHER)
    colours = _COLOURS.get(read[Tag.PhotometricInterpretation], 1)
    if (more := read[Tag.SamplesPerPixel] - colours - (channels in (2, 4))) > 0:
        yield Extra(kinds.CHANNELS, Text.counted(more, "{n} extra channel", "{n} extra channels"))
    for tag in tags:
        if tag in _NAMED:
            yield _NAMED[tag]
    rare = [tag for tag in tags if tiff.is_rare(tag)]
    for kind, is_kept in ((kinds.TIFF_TAGS, True), (kinds.UNKNOWN, False)):
        if some := [str(tag) for tag in rare if (tag in kept) == is_kept]:
            yield Extra(kind, Text("TIFF tags {tags}", tags=" ".join(some)))


def has_only_thumbnails(file: IO[bytes]) -> bool:
    """Return True if all directories after the first hold thumbnails, as GIMP 3.0 writes them."""
    with suppress(KeyError, struct.error):
        directories = Directories(file)
        (start,) = directories.read(FIRST)
        for _ in range(_MOST_DIRECTORIES):
            (start,) = directories.read(directories.link(start))
            if not start:
                return True
            kind = dict(directories.entries(start)).get(Tag.NewSubfileType)
            if kind is None or not directories.read(kind)[0] & 1:
                return False
    return False


def has_maker_note(tags: Pillow.Exif) -> bool:
    """Return True if the EXIF directory has a maker's note."""
    return Tag.MakerNote in tags.get_ifd(Tag.ExifOffset)


def end(file: IO[bytes]) -> int:
    """Return the end offset of the last part that a directory of a file refers to."""
    whole = file.seek(0, os.SEEK_END)
    directories, ends, seen = Directories(file), [8], set[int]()
    waiting = [*directories.read(FIRST)]
    while waiting and len(seen) < _MOST_DIRECTORIES:
        start = waiting.pop()
        if start in seen or not 0 < start < whole - 2:
            continue
        seen.add(start)
        found = dict[int, Numbers]()
        with suppress(struct.error):  # a directory that the file cuts off
            entries = directories.entries(start)
            found.update(one for one in entries if one[1].end <= whole)
            waiting += directories.read(directories.link(start))
        ends += [directories.link(start).end, *(one.end for one in found.values())]
        links = (one for tag, one in found.items() if tag in _POINTERS or one.kind == _DIRECTORY)
        waiting += [at for one in links for at in directories.read(one)]
        for tags in _PLACES:
            if found.keys() >= set(tags):
                parts = (directories.read(found[tag]) for tag in tags)
                ends += map(sum, zip(*parts, strict=False))
    return min(max(ends), whole)
