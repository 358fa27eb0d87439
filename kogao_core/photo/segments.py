"""The segments of a JPEG file ahead of its first scan."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from typing import IO, Final

START_OF_SCAN: Final = 0xDA
APP_OR_COMMENT: Final = {*range(0xE0, 0xF0), 0xFE}
_JFIF, _CREDENTIALS, _PHOTOSHOP, _ADOBE = 0xE0, 0xEB, 0xED, 0xEE
_PHOTOSHOP_HEAD: Final = b"Photoshop 3.0\0"
# Blocks with a way of their own, and an index of pictures that don't come along.
_ELSEWHERE: Final = (b"Exif\0", b"http://ns.adobe.com/xap/1.0/\0", b"ICC_PROFILE\0", b"MPF\0")
_PICTURE: Final = b"\xff\xd8\xff"
_MOST_BYTES: Final = 65533


def segments(file: IO[bytes]) -> Iterator[tuple[int, bytes]]:
    """Yield marker code and bytes of each segment of a file, up to the first scan.

    The file is then at the scan. A damaged file ends early.
    """
    file.seek(2)
    while True:
        head = file.read(4)
        while len(head) == 4 and head[:2] == b"\xff\xff":  # fill bytes
            head = head[1:] + file.read(1)
        if len(head) < 4 or head[0] != 0xFF or head[1] == START_OF_SCAN:
            file.seek(-len(head), os.SEEK_CUR)
            return
        size = int.from_bytes(head[2:], "big")
        body = file.read(max(0, size - 2))
        if size < 2 or len(body) < size - 2:
            return
        yield head[1], head + body


def carried(file: IO[bytes]) -> tuple[bytes, ...]:
    """Return segments that a changed photo keeps as they are.

    These are comments, the rest of a long XMP, and what makers and programs add. Those that hold a
    picture would show the photo as it was.
    """
    return tuple(
        segment
        for code, segment in segments(file)
        if code in APP_OR_COMMENT - {_JFIF, _CREDENTIALS, _PHOTOSHOP, _ADOBE}
        and not segment[4:].startswith(_ELSEWHERE)
        and _PICTURE not in segment
    )


def has_credentials(file: IO[bytes]) -> bool:
    """Tell whether there are content credentials (C2PA), which no changed photo fulfils."""
    return any(code == _CREDENTIALS and b"c2pa" in segment for code, segment in segments(file))


def photoshop(file: IO[bytes]) -> bytes | None:
    """Return the Photoshop resources, which may be spread over segments."""
    start = 4 + len(_PHOTOSHOP_HEAD)
    return (
        b"".join(
            segment[start:]
            for code, segment in segments(file)
            if code == _PHOTOSHOP and segment[4:start] == _PHOTOSHOP_HEAD
        )
        or None
    )


def photoshop_segments(resources: bytes) -> tuple[bytes, ...]:
    """Return segments that hold Photoshop resources."""
    room = _MOST_BYTES - len(_PHOTOSHOP_HEAD)
    parts = (resources[at : at + room] for at in range(0, len(resources), room))
    bodies = (_PHOTOSHOP_HEAD + part for part in parts)
    return tuple(
        bytes([0xFF, _PHOTOSHOP]) + (len(body) + 2).to_bytes(2, "big") + body for body in bodies
    )


def inserted(jpeg: bytes, more: tuple[bytes, ...]) -> bytes:
    """Return a JPEG file with more segments behind its own metadata."""
    with io.BytesIO(jpeg) as file:
        heads = [segment for code, segment in segments(file) if code in APP_OR_COMMENT]
    at = 2 + sum(map(len, heads))  # an encoder writes them first
    return jpeg[:at] + b"".join(more) + jpeg[at:]
