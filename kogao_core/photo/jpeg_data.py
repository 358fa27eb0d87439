"""The compressed data of a JPEG file: what they cost to decode, and whether they are all there."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final

from PIL import Image as Pillow
from PIL import ImageChops

from kogao_core.language import Text
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.segments import START_OF_SCAN, segments

# Usual files have at most 18. Each takes about 1.2 ns a pixel, and may be a dozen bytes.
MOST_SCANS: Final = 64
_MOST_MARKERS: Final = 16 * MOST_SCANS  # tables and remarks between them
_MARKER: Final = re.compile(rb"\xff[\x01-\xcf\xd8-\xfe]")  # restarts belong to the data
_END: Final = b"\xff\xd9"
_END_CODE: Final = 0xD9
_CHUNK_BYTES: Final = 1 << 16
_BLOCK_PX: Final = 8
# The fewest bits that Huffman codes spend on a block: its mean, and in sequential files its end.
_LEAST_BITS: Final = {0xC0: 2, 0xC1: 2, 0xC2: 1}
_ANYTHING: Final = b"\xaa" * 1000  # unlike the zeros that decoders fill in


def check(file: IO[bytes], path: Path) -> None:
    """Check an open JPEG file before it is decoded.

    Raises
    ------
    UnreadablePhoto
        If it has so many scans that it is made to take long.
    ValueError
        If its data can't hold as many pixels as it claims.
    """
    frame = next((body for code, body in segments(file) if code in _LEAST_BITS), None)
    for _ in segments(file):
        pass  # the file is then at its first scan
    start = file.tell()
    data_bytes = os.fstat(file.fileno()).st_size - start
    if frame is not None and 8 * data_bytes < _LEAST_BITS[frame[1]] * _blocks(frame):
        raise ValueError(Text("fewer data than blocks"))
    codes = _codes(file, start)
    scans = sum(code == START_OF_SCAN for _, code in zip(range(_MOST_MARKERS), codes, strict=False))
    if scans > MOST_SCANS or next(codes, None) is not None:
        raise UnreadablePhoto(
            Text(
                "{path} is a JPEG in more than {most_scans} scans, which would take "
                "very long; save it as an ordinary JPEG or as PNG first",
                path=path,
                most_scans=MOST_SCANS,
            )
        )


def _blocks(frame: bytes) -> int:
    """Return how many blocks the segment of a frame announces."""
    height, width = (int.from_bytes(frame[at : at + 2], "big") for at in (5, 7))
    parts = [divmod(factors, 16) for factors in frame[11::3][: frame[9]]]
    most_across, most_down = (max((part[axis] for part in parts), default=1) for axis in (0, 1))
    return sum(
        (width * across // max(1, most_across) // _BLOCK_PX)
        * (height * down // max(1, most_down) // _BLOCK_PX)
        for across, down in parts
    )


def _codes(file: IO[bytes], at: int) -> Iterator[int]:
    """Yield the codes of markers from a place in the file up to the end of the picture."""
    while True:
        file.seek(at)
        chunk = file.read(_CHUNK_BYTES)
        found = _MARKER.search(chunk)
        if found is None:
            if len(chunk) < _CHUNK_BYTES:
                return
            at += len(chunk) - 1
            continue
        code = chunk[found.start() + 1]
        if code == _END_CODE:
            return
        yield code
        at += found.end()
        file.seek(at)
        at += int.from_bytes(file.read(2), "big")


def without_end(data: bytes) -> Pillow.Image | None:
    """Return the picture of a JPEG file that lacks nothing but its end marker, else None.

    Decoders fill in what is missing from whatever follows: where that makes no difference, nothing
    is missing.
    """
    try:
        if not _is_whole(data, small=True):  # most that end early do so by far
            return None
        return _decoded(data + _END) if _is_whole(data, small=False) else None
    except OSError:
        return None


def _is_whole(data: bytes, *, small: bool) -> bool:
    first, second = (_decoded(data + more + _END, small=small) for more in (b"", _ANYTHING))
    return ImageChops.difference(first, second).getbbox() is None


def _decoded(data: bytes, *, small: bool = False) -> Pillow.Image:
    image = Pillow.open(io.BytesIO(data), formats=["JPEG"])
    if small:
        image.draft(None, (1, 1))  # an eighth of the width and height
    image.load()
    return image
