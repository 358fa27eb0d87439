"""WebP, lossless where nothing was lost in the source."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from typing import IO, Final

from kogao_core.base.atomic import Pieces
from kogao_core.base.language import Text
from kogao_core.photo.formats.base import Content, FileFormat
from kogao_core.photo.metadata import kinds, trailers
from kogao_core.photo.metadata.kinds import Extra
from kogao_core.photo.model import Photo

_QUALITY: Final = 95
_EFFORT: Final = 50  # of lossless WebP: a quarter of the time of 95, and 0.1 % longer
_PLAIN: Final = (b"VP8 ", b"VP8L", b"VP8X", b"ALPH", b"ICCP", b"EXIF", b"XMP ")
_KNOWN: Final = {
    b"C2PA": kinds.CREDENTIALS,
    b"ANIM": kinds.FURTHER,
    b"ANMF": kinds.FURTHER,
}
_HEAD_BYTES: Final = 8


def is_lossless(file: IO[bytes]) -> bool:
    """Tell whether an open file is a WebP file that loses nothing."""
    file.seek(_HEAD_BYTES)
    if file.read(4) != b"WEBP":
        return False
    names = (name for name in _chunks(file) if name in (b"VP8 ", b"VP8L"))
    return next(names, b"") == b"VP8L"


def _chunks(file: IO[bytes]) -> Iterator[bytes]:
    """Yield the name of each chunk, up to the end that the file's header gives."""
    file.seek(0)
    end = _end(file.read(12))
    while file.tell() < end and len(head := file.read(_HEAD_BYTES)) == _HEAD_BYTES:
        name, size = struct.unpack("<4sI", head)
        yield name
        file.seek(size + size % 2, os.SEEK_CUR)


def _end(head: bytes) -> int:
    """Return where a file ends, by its first bytes."""
    size = int.from_bytes(head[4:8], "little")
    return _HEAD_BYTES + size + size % 2


def _encode(content: Content) -> Pieces:
    del content.blocks["dpi"]  # WebP has no place for it, nor for Photoshop's resources
    lossless = content.is_lossless and not content.quality
    quality = _EFFORT if lossless else content.quality or _QUALITY
    return [content.saved("WEBP", quality=quality, lossless=lossless, exact=True, method=4)]


def _inside(_: Photo, file: IO[bytes]) -> Iterator[Extra]:
    unknown = []
    for name in _chunks(file):
        if name in _KNOWN:
            yield Extra(_KNOWN[name])
        elif name not in _PLAIN:
            unknown.append(name.decode("latin-1").strip())
    if unknown:
        yield Extra(
            kinds.RIFF_CHUNKS, Text("WebP chunks {names}", names=" ".join(dict.fromkeys(unknown)))
        )


def _behind(file: IO[bytes]) -> Iterator[Extra]:
    data = file.read()
    return trailers.found(data, _end(data))


WEBP: Final = FileFormat(
    name="WEBP",
    title="WebP",
    mime="image/webp",
    suffixes=(".webp",),
    is_lossless=False,
    encode=_encode,
    layouts={"uint8": (3, 4)},
    longest_side_px=16383,
    kept=frozenset({kinds.EXIF, kinds.EXIF_TAGS, kinds.MAKER_NOTE, kinds.XMP, kinds.ICC}),
    moved=frozenset({kinds.MOVED_NOTE}),
    inside=_inside,
    behind=_behind,
)
