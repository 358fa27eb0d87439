"""WebP: lossless if the source is lossless."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from typing import IO, Final

from kogao_core.base.atomic import Chunks
from kogao_core.base.geometry import Image
from kogao_core.photo.formats.base import BLOCKS, Content, FileFormat
from kogao_core.photo.jpeg import segments
from kogao_core.photo.metadata import kinds, trailers
from kogao_core.photo.metadata.kinds import Extra, Kind
from kogao_core.photo.model import Photo

_QUALITY: Final = 95
_EFFORT: Final = 50  # of lossless WebP: a quarter of the time of 95, and 0.1 % longer
_PLAIN: Final = (b"VP8 ", b"VP8L", b"VP8X", b"ALPH", b"ICCP", b"EXIF", b"XMP ")
_KNOWN: Final = {b"C2PA": kinds.CREDENTIALS, b"ANIM": kinds.FURTHER, b"ANMF": kinds.FURTHER}
_HEAD_BYTES: Final = 8
_ALPHA: Final = 0x10  # flag of the alpha channel


def is_lossless(file: IO[bytes]) -> bool:
    """Return True if an open file is a lossless WebP file."""
    file.seek(_HEAD_BYTES)
    if file.read(4) != b"WEBP":
        return False
    names = (name for name, _ in _chunks(file) if name in (b"VP8 ", b"VP8L"))
    return next(names, b"") == b"VP8L"


def carried(file: IO[bytes]) -> tuple[bytes, ...]:
    """Return unknown chunks that a changed photo keeps, as RFC 9649 requires."""
    return tuple(chunk for name, chunk in _chunks(file) if _kind(name, chunk) is kinds.RIFF_CHUNKS)


def _kind(name: bytes, chunk: bytes) -> Kind | None:
    """Return the kind of a chunk. None: the picture, or metadata that is written separately."""
    if name in _PLAIN:
        return None
    shows = segments.holds_picture(chunk)
    return _KNOWN.get(name, kinds.UNKNOWN if shows else kinds.RIFF_CHUNKS)


def _chunks(file: IO[bytes]) -> Iterator[tuple[bytes, bytes]]:
    """Yield name and bytes of each chunk, up to the end given in the header.

    The bytes of pixels and known metadata are empty. A damaged file ends early.
    """
    file.seek(0)
    end = _end(file.read(12))
    while file.tell() < end and len(head := file.read(_HEAD_BYTES)) == _HEAD_BYTES:
        name, size = struct.unpack("<4sI", head)
        if name in _PLAIN or name in _KNOWN:
            yield name, b""
            file.seek(size + size % 2, os.SEEK_CUR)
        elif len(body := file.read(size + size % 2)) == size + size % 2:
            yield name, head + body


def _end(head: bytes) -> int:
    """Return the end offset of a file, from the first bytes."""
    size = int.from_bytes(head[4:8], "little")
    return _HEAD_BYTES + size + size % 2


def _encode(content: Content) -> Chunks:
    del content.blocks["dpi"]  # WebP can store neither resolution nor Photoshop resources
    lossless = content.is_lossless and not content.quality
    quality = _EFFORT if lossless else content.quality or _QUALITY
    webp = content.saved("WEBP", quality=quality, lossless=lossless, exact=True, method=4)
    return [_with_chunks(webp, content.pixels, content.carried) if content.carried else webp]


def _with_chunks(webp: bytes, pixels: Image, more: tuple[bytes, ...]) -> bytes:
    """Append chunks to a WebP file; insert a VP8X header if missing."""
    chunks = webp[12:]
    if not chunks.startswith(b"VP8X"):
        height, width = pixels.shape[:2]
        sides = b"".join((side - 1).to_bytes(3, "little") for side in (width, height))
        has_alpha = _ALPHA if pixels.shape[2] == 4 else 0
        chunks = struct.pack("<4sII", b"VP8X", 10, has_alpha) + sides + chunks
    body = b"".join([b"WEBP", chunks, *more])
    return struct.pack("<4sI", b"RIFF", len(body)) + body


def _inside(_: Photo, file: IO[bytes]) -> Iterator[Extra]:
    found = ((_kind(*one), one[0].decode("latin-1").strip()) for one in _chunks(file))
    return kinds.grouped("WebP", found)


def _behind(file: IO[bytes]) -> Iterator[Extra]:
    data = file.read()
    return trailers.found(data, _end(data))


WEBP: Final = FileFormat(
    name="WEBP",
    title="WebP",
    suffixes=(".webp",),
    is_lossless=False,
    encode=_encode,
    layouts={"uint8": (3, 4)},
    longest_side_px=16383,
    kept=BLOCKS | {kinds.RIFF_CHUNKS},
    inside=_inside,
    behind=_behind,
)
