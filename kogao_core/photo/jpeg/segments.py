"""The segments of a JPEG file, and where its picture ends."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterator
from typing import IO, Final

START_OF_SCAN: Final = 0xDA
APP_OR_COMMENT: Final = {*range(0xE0, 0xF0), 0xFE}
SOI: Final = b"\xff\xd8\xff"
_JFIF, _PHOTOSHOP, _ADOBE = 0xE0, 0xED, 0xEE
PHOTOSHOP_HEAD: Final = b"Photoshop 3.0\0"
_PROFILE_HEAD: Final = b"ICC_PROFILE\0"
_MOST_BYTES: Final = 65533
_JFIF_AT: Final = 11  # what its segment says, in a file where it comes first
_END: Final = 0xD9
# Within a scan: neither stuffed bytes, fill bytes nor restarts.
_MARKER: Final = re.compile(rb"\xff[^\x00\xff\xd0-\xd7]")


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


def end_of_picture(data: bytes, start: int) -> tuple[int, int]:
    """Return where a picture ends, and the bytes of APPn and comments behind its first scan."""
    at, late, in_scans = start, 0, False
    while (marker := _MARKER.search(data, at)) is not None:
        at, code = marker.end(), data[marker.end() - 1]
        if code == _END:
            return at, late
        size = int.from_bytes(data[at : at + 2], "big")
        late += size + 2 if in_scans and code in APP_OR_COMMENT else 0
        in_scans |= code == START_OF_SCAN
        at += size
    return len(data), late


def profiles(file: IO[bytes]) -> tuple[list[bytes], bool]:
    """Return the whole colour profiles, each from its series, and whether a part is left over."""
    series: list[dict[int, bytes]] = []
    totals: list[int] = []
    start = 4 + len(_PROFILE_HEAD)
    for _, segment in segments(file):
        if segment[1] != 0xE2 or segment[4:start] != _PROFILE_HEAD or len(segment) < start + 2:
            continue
        number, total = segment[start], segment[start + 1]
        if not series or number in series[-1] or total != totals[-1]:
            series.append({})
            totals.append(total)
        series[-1][number] = segment[start + 2 :]
    whole = [
        b"".join(parts[number] for number in sorted(parts))
        for parts, total in zip(series, totals, strict=True)
        if set(parts) == set(range(1, total + 1))
    ]
    return whole, len(whole) < len(series)


def photoshop(file: IO[bytes]) -> bytes | None:
    """Return the Photoshop resources, which may be spread over segments."""
    start = 4 + len(PHOTOSHOP_HEAD)
    return (
        b"".join(
            segment[start:]
            for code, segment in segments(file)
            if code == _PHOTOSHOP and segment[4:start] == PHOTOSHOP_HEAD
        )
        or None
    )


def photoshop_segments(resources: bytes) -> tuple[bytes, ...]:
    """Return segments that hold Photoshop resources."""
    room = _MOST_BYTES - len(PHOTOSHOP_HEAD)
    parts = (resources[at : at + room] for at in range(0, len(resources), room))
    return tuple(segment(_PHOTOSHOP, PHOTOSHOP_HEAD + part) for part in parts)


def segment(code: int, body: bytes) -> bytes:
    """Return a segment as a file holds it."""
    return bytes([0xFF, code]) + (len(body) + 2).to_bytes(2, "big") + body


def end_of_headers(jpeg: bytes) -> int:
    """Return where the metadata of a JPEG file end that has them first, as encoders write it."""
    with io.BytesIO(jpeg) as file:
        return 2 + sum(len(one) for code, one in segments(file) if code in APP_OR_COMMENT)


def inserted(jpeg: bytes, more: tuple[bytes, ...]) -> bytes:
    """Return a JPEG file with more segments behind its own metadata."""
    at = end_of_headers(jpeg)
    return jpeg[:at] + b"".join(more) + jpeg[at:]


def with_headers(jpeg: bytes, other: bytes) -> bytes:
    """Return a JPEG file with another's metadata in the place of its own.

    How colours are coded is its own: Adobe's segment.
    """

    def heads(data: bytes) -> Iterator[tuple[bool, bytes]]:
        with io.BytesIO(data) as file:
            for code, one in segments(file):
                if code in APP_OR_COMMENT:
                    yield code == _ADOBE and one[4:].startswith(b"Adobe"), one

    kept = [one for is_coding, one in heads(other) if not is_coding]
    own = [one for is_coding, one in heads(jpeg) if is_coding]
    return b"".join([jpeg[:2], *kept, *own, jpeg[end_of_headers(jpeg) :]])


def with_jfif(jpeg: bytes, header: bytes) -> bytes:
    """Return a JPEG file with another version, unit and density in its JFIF segment, if any."""
    if jpeg[2:4] != bytes([0xFF, _JFIF]) or jpeg[6:_JFIF_AT] != b"JFIF\0":
        return jpeg
    return jpeg[:_JFIF_AT] + header + jpeg[_JFIF_AT + len(header) :]
