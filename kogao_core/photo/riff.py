"""The chunks of a WebP file."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from typing import IO, Final

from kogao_core.language import Text
from kogao_core.photo import kinds
from kogao_core.photo.kinds import Extra

_PLAIN: Final = (b"VP8 ", b"VP8L", b"VP8X", b"ALPH", b"ICCP", b"EXIF", b"XMP ")
_KNOWN: Final = {
    b"C2PA": kinds.CREDENTIALS,
    b"ANIM": kinds.FURTHER,
    b"ANMF": kinds.FURTHER,
}
_HEAD_BYTES: Final = 8


def _chunks(file: IO[bytes]) -> Iterator[tuple[bytes, int]]:
    """Yield name and size of each chunk, up to the end that the file's header gives."""
    file.seek(0)
    end = riff_end(file.read(12))
    while file.tell() < end and len(head := file.read(_HEAD_BYTES)) == _HEAD_BYTES:
        name, size = struct.unpack("<4sI", head)
        at = file.tell()
        yield name, size
        file.seek(at + size + size % 2, os.SEEK_SET)


def is_lossless(file: IO[bytes]) -> bool:
    """Tell whether an open file is a WebP file that loses nothing."""
    file.seek(_HEAD_BYTES)
    if file.read(4) != b"WEBP":
        return False
    names = (name for name, _ in _chunks(file) if name in (b"VP8 ", b"VP8L"))
    return next(names, b"") == b"VP8L"


def riff_end(head: bytes) -> int:
    """Return where a WebP file ends, by its first bytes."""
    size = int.from_bytes(head[4:8], "little")
    return _HEAD_BYTES + size + size % 2


def found(file: IO[bytes]) -> Iterator[Extra]:
    """Yield what there is, in the order of the file."""
    unknown = []
    for name, _ in _chunks(file):
        if name in _KNOWN:
            yield Extra(_KNOWN[name])
        elif name not in _PLAIN:
            unknown.append(name.decode("latin-1").strip())
    if unknown:
        yield Extra(
            kinds.RIFF_CHUNKS, Text("WebP chunks {names}", names=" ".join(dict.fromkeys(unknown)))
        )
