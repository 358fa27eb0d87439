"""Segments of a JPEG file, and the end of the picture."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterator
from typing import IO, Final

START_OF_SCAN: Final = 0xDA
APP_OR_COMMENT: Final = {*range(0xE0, 0xF0), 0xFE}
SOI: Final = b"\xff\xd8\xff"
_PICTURES: Final = (SOI, b"\x89PNG\r\n", b"WEBPVP8", b"ftyp")  # first bytes of picture files
_JFIF, _PHOTOSHOP, _ADOBE = 0xE0, 0xED, 0xEE
PHOTOSHOP_HEAD: Final = b"Photoshop 3.0\0"
_PROFILE_HEAD: Final = b"ICC_PROFILE\0"
PROFILE_AT: Final = 4 + len(_PROFILE_HEAD) + 2  # after the number of the part and the total
MOST_BYTES: Final = 65533
_JFIF_AT: Final = 11  # offset of the JFIF data if the JFIF segment is the first
END: Final = 0xD9
_MOST_STRAY: Final = 1 << 16  # bytes between segments
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
        if len(head) == 4 and (
            head[0] != 0xFF or head[1] == 0
        ):  # stray bytes, which all decoders skip
            start = file.seek(-4, os.SEEK_CUR)
            marker = _MARKER.search(file.read(_MOST_STRAY))
            file.seek(start + marker.start() if marker else start)
            head = file.read(4) if marker else b""
        if len(head) < 4 or head[1] == START_OF_SCAN:
            file.seek(-len(head), os.SEEK_CUR)
            return
        size = int.from_bytes(head[2:], "big")
        body = file.read(max(0, size - 2))
        if size < 2 or len(body) < size - 2:
            return
        yield head[1], head + body


def holds_picture(data: bytes) -> bool:
    """Return True if the data contain an embedded picture or video file."""
    return any(start in data for start in _PICTURES)


def end_of_picture(data: bytes, start: int) -> tuple[int, bool]:
    """Return the end offset of a picture, and whether metadata follow the first scan."""
    late = in_scans = False
    for code, at, end in markers(data, start):
        if code == END:
            return end, late
        late |= in_scans and code in APP_OR_COMMENT and at + 4 <= end <= len(data)
        in_scans |= code == START_OF_SCAN
    return len(data), late


def markers(data: bytes, start: int) -> Iterator[tuple[int, int, int]]:
    """Yield code, start and end of each marker segment, up to the end of a picture."""
    code, at = 0, start
    while code != END and (marker := _MARKER.search(data, at)) is not None:
        code, at = data[marker.end() - 1], marker.end()
        at += 0 if code == END else int.from_bytes(data[at : at + 2], "big")
        yield code, marker.start(), at


def profiles(file: IO[bytes]) -> tuple[list[list[bytes]], list[bytes]]:
    """Return the ordered segments of each complete colour profile, and all remaining segments."""
    series: list[dict[int, bytes]] = []
    for code, one in segments(file):
        if code != 0xE2 or one[4 : PROFILE_AT - 2] != _PROFILE_HEAD or len(one) < PROFILE_AT:
            continue
        number, total = one[PROFILE_AT - 2 : PROFILE_AT]
        if (
            not series
            or number in series[-1]
            or total != next(iter(series[-1].values()))[PROFILE_AT - 1]
        ):
            series.append({})
        series[-1][number] = one
    whole, rest = [], []
    for parts in series:
        ordered = [parts[number] for number in sorted(parts)]
        if sorted(parts) == list(range(1, ordered[0][PROFILE_AT - 1] + 1)):
            whole.append(ordered)
        else:
            rest += ordered
    return whole, rest


def short_jfif(file: IO[bytes]) -> bytes:
    """Return a JFIF segment without a version, which Pillow can't read, or b""."""
    short = (one for code, one in segments(file) if code == _JFIF and len(one) < _JFIF_AT)
    return next((one for one in short if one[4:8] == b"JFIF"), b"")


def photoshop(file: IO[bytes]) -> bytes | None:
    """Return the Photoshop resources, joined from all segments, or None."""
    start = 4 + len(PHOTOSHOP_HEAD)
    found = (one for code, one in segments(file) if code == _PHOTOSHOP)
    return b"".join(one[start:] for one in found if one[4:start] == PHOTOSHOP_HEAD) or None


def photoshop_segments(resources: bytes) -> tuple[bytes, ...]:
    """Split Photoshop resources into segments."""
    room = MOST_BYTES - len(PHOTOSHOP_HEAD)
    parts = (resources[at : at + room] for at in range(0, len(resources), room))
    return tuple(segment(_PHOTOSHOP, PHOTOSHOP_HEAD + part) for part in parts)


def segment(code: int, body: bytes) -> bytes:
    """Return a segment: marker, length and body."""
    return bytes([0xFF, code]) + (len(body) + 2).to_bytes(2, "big") + body


def end_of_headers(jpeg: bytes) -> int:
    """Return the end offset of the metadata. The metadata must come first in the file."""
    with io.BytesIO(jpeg) as file:
        return 2 + sum(len(one) for code, one in segments(file) if code in APP_OR_COMMENT)


def inserted(jpeg: bytes, more: tuple[bytes, ...]) -> bytes:
    """Insert segments after the metadata of a JPEG file."""
    at = end_of_headers(jpeg)
    return jpeg[:at] + b"".join(more) + jpeg[at:]


def with_headers(jpeg: bytes, other: bytes) -> bytes:
    """Replace the metadata of `jpeg` by the metadata of `other`.

    The Adobe segment of `jpeg` is preserved: it defines the colour coding.
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
    """Replace version, unit and density in the JFIF segment, if any."""
    if jpeg[2:4] != bytes([0xFF, _JFIF]) or jpeg[6:_JFIF_AT] != b"JFIF\0":
        return jpeg
    return jpeg[:_JFIF_AT] + header + jpeg[_JFIF_AT + len(header) :]
