"""The chunks of a PNG file beside its pixels."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from typing import IO, Final

IHDR_END: Final = 33
_OVERHEAD: Final = 12
_SIGNATURE_BYTES: Final = 8
_COLOUR: Final = (b"gAMA", b"cHRM", b"sRGB", b"cICP", b"mDCV", b"cLLI")
_TEXT: Final = (b"tEXt", b"zTXt", b"iTXt")
# Texts that hold blocks with a way of their own.
_ELSEWHERE: Final = (b"XML:com.adobe.xmp\0", b"Raw profile type ")
_CREDENTIALS: Final = b"caBX"
_MOST_BYTES: Final = 1 << 24


def chunks(file: IO[bytes]) -> Iterator[tuple[bytes, bytes]]:
    """Yield name and bytes of each sound chunk but those of pixels; a damaged file ends early."""
    file.seek(_SIGNATURE_BYTES)
    while len(head := file.read(8)) == 8:
        size, name = int.from_bytes(head[:4], "big"), head[4:]
        if name == b"IDAT" or size > _MOST_BYTES:
            file.seek(size + 4, os.SEEK_CUR)
            continue
        body = file.read(size + 4)
        if len(body) < size + 4:
            return
        if zlib.crc32(name + body[:-4]) == int.from_bytes(body[-4:], "big"):
            yield name, head + body


def carried(file: IO[bytes]) -> tuple[bytes, ...]:
    """Return chunks that a changed photo keeps as they are: texts and what colours mean."""
    found = list(chunks(file))
    profiled = any(name == b"iCCP" for name, _ in found)
    return tuple(
        chunk
        for name, chunk in found
        if (name in _TEXT and not chunk[8:].startswith(_ELSEWHERE))
        or (name in _COLOUR and not (profiled and name == b"sRGB"))
    )


def has_credentials(file: IO[bytes]) -> bool:
    """Tell whether there are content credentials (C2PA), which no changed photo fulfils."""
    return any(name == _CREDENTIALS for name, _ in chunks(file))


def before_pixels(png: bytes) -> bytes:
    """Return the chunks between the header and the pixels of a file that an encoder wrote."""
    end = IHDR_END
    while png[end + 4 : end + 8] != b"IDAT":
        end += _OVERHEAD + int.from_bytes(png[end : end + 4], "big")
    return png[IHDR_END:end]


def inserted(png: bytes, more: bytes) -> bytes:
    """Return a PNG file with more chunks behind its header."""
    return png[:IHDR_END] + more + png[IHDR_END:]
