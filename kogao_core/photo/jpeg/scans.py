"""Divide a sequential JPEG file into parts for several threads, and join the coded parts."""

from __future__ import annotations

import io
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from kogao_core.photo.jpeg.segments import segments

_FRAMES: Final = (0xC0, 0xC1)  # start of a sequential frame
_HEIGHT: Final = slice(5, 7)  # place of the picture's height in its segment
_END: Final = b"\xff\xd9"
_STUFFED: Final = b"\xff\x00"  # the byte 255 within a scan


def parts(is_closed: Sequence[bool], most: int) -> list[tuple[int, int]]:
    """Divide rows of minimum coded units into at most `most` parts: first row, and row after.

    A part must end with a closed row: one that ends with the code "end of block". This code ends
    with a zero, so the ones that fill the last byte can be told from the data.
    """
    rows = len(is_closed)
    ends = {rows * number // most for number in range(1, most + 1)}
    closed = sorted(end for end in ends if end and is_closed[end - 1])
    return list(pairwise([0, *closed])) if closed[-1:] == [rows] else [(0, rows)]


def joined(files: Sequence[bytes], heads: Sequence[bytes], height: int) -> bytes:
    """Join coded parts to one file, for a picture of `height` rows.

    All files except the first begin with rows that are left out: the rows of their file in `heads`.
    """
    header, data = _split(files[0], height)
    whole, count = _bits(data)
    for file, head in zip(files[1:], heads, strict=True):
        bits, length = _bits(_split(file)[1])
        kept = length - _bits(_split(head)[1])[1]
        whole, count = whole << kept | bits & (1 << kept) - 1, count + kept
    fill = -count % 8
    data = ((whole + 1 << fill) - 1).to_bytes((count + fill) // 8, "big")
    return header + data.replace(_STUFFED[:1], _STUFFED) + _END


def _split(file: bytes, height: int = 0) -> tuple[bytes, bytes]:
    """Return the header, with another picture height, and the data of the only scan."""
    header = file[:2]
    with io.BytesIO(file) as opened:
        for code, one in segments(opened):
            if code in _FRAMES:
                one = one[: _HEIGHT.start] + height.to_bytes(2, "big") + one[_HEIGHT.stop :]
            header += one
        scan = opened.read(4)
        header += scan + opened.read(int.from_bytes(scan[2:], "big") - 2)
        return header, opened.read()[: -len(_END)]


def _bits(data: bytes) -> tuple[int, int]:
    """Return the data of a scan as a number, and the count of its bits."""
    data = data.replace(_STUFFED, _STUFFED[:1])
    fill = (data[-1] ^ (data[-1] + 1)).bit_length() - 1  # ones at the end
    return int.from_bytes(data, "big") >> fill, 8 * len(data) - fill
