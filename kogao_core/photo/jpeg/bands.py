"""The data of a JPEG's scan, written in bands of rows and joined bit by bit.

A band and the library's copy of it stay within the processor's cache, and bands are written side
by side.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from kogao_core.base.threads import default_threads, share_out
from kogao_core.photo.jpeg import scan
from kogao_core.photo.jpeg.scan import NOTHING, Bits
from kogao_core.photo.jpeg.segments import segments

_BAND_BYTES: Final = 1 << 21  # of coefficients
_FRAMES: Final = (0xC0, 0xC1)
_HEIGHT_AT: Final = slice(5, 7)
_LAST: Final = 63  # of a block's coefficients; where it is 0, the block ends with a code of its own

Plane = npt.NDArray[np.int16]
Factors = Sequence[tuple[int, int]]
Write = Callable[[list[Plane], int, int], bytes]
Band = list[tuple[Plane, int]]


class Around(NamedTuple):
    """The data of a scan around some rows of minimum coded units."""

    # The rows that they lack, up to the one before `end`.
    first: int
    end: int
    # What precedes these rows, and what follows.
    before: Bits
    after: Bits


def rows_of(planes: Sequence[Plane], factors: Factors) -> int:
    """Return how many rows of minimum coded units there are."""
    return -(-len(planes[0]) // factors[0][0])


def cuts(
    planes: Sequence[Plane], factors: Factors, first: int = 0, end: int | None = None
) -> list[int]:
    """Return the rows of minimum coded units at which bands begin, and where the last one ends.

    Only where the last block before ends with the usual code for that, whose last bit is 0, can it
    be told from the ones that fill the last byte. `planes` (rows, columns, 64).
    """
    rows = rows_of(planes, factors)
    end = rows if end is None else end
    least = rows * _BAND_BYTES // _bytes(planes)
    at = [first]
    if has_end(planes, factors, end):
        for row in range(first + 1, end):
            if row - at[-1] >= least and has_end(planes, factors, row):
                at.append(row)
    return [*at, end]


def has_end(planes: Sequence[Plane], factors: Factors, row: int) -> bool:
    """Tell whether the last block before a row of units ends with a code of its own."""
    return bool(planes[-1][: row * factors[-1][0]][-1, -1, _LAST] == 0)


def _bytes(planes: Sequence[Plane]) -> int:
    return sum(plane.nbytes for plane in planes)


def is_much_around(planes: Sequence[Plane], factors: Factors, first: int, end: int) -> bool:
    """Tell whether to write what lies around some rows takes longer than to look for it."""
    rows = rows_of(planes, factors)
    return _bytes(planes) * (rows - (end - first)) > _BAND_BYTES * rows


def around(
    source: Bits, planes: Sequence[Plane], factors: Factors, first: int, end: int, write: Write
) -> Around | None:
    """Return the data around some rows, which serve a file where only these become others.

    Result: None where it can't be told where the data of these rows begin and end, as where the
    picture repeats itself or another encoder would have written other bits.
    """

    def encoded(row: int) -> Bits:
        return _encoded(_band(planes, factors, row, row + 1), row, row + 1, write)[1]

    rows, before, after = rows_of(planes, factors), NOTHING, NOTHING
    if first > 0:
        start = scan.place(source, encoded(first))
        if start is None:
            return None
        before = scan.part(source, 0, start)
    if end < rows:
        start, last = scan.place(source, encoded(end)), encoded(rows - 1)
        is_end = has_end(planes, factors, rows) and scan.is_at(
            source, source.length - last.length, last
        )
        if start is None or not is_end:
            return None
        after = scan.part(source, start, source.length)
    return Around(first, end, before, after)


def written(
    planes: Sequence[Plane],
    factors: Factors,
    at: Sequence[int],
    write: Write,
    rest: Around | None = None,
) -> bytes:
    """Return a whole file, made of bands."""
    ends = list(pairwise(at))
    parts = [_band(planes, factors, *one) for one in ends]
    heads, scans = [b""] * len(parts), [NOTHING] * len(parts)

    def encode(band: int) -> None:
        heads[band], scans[band] = _encoded(parts[band], *ends[band], write)

    share_out(range(len(parts)), lambda: encode, default_threads())
    if rest is not None:
        scans = [rest.before, *scans, rest.after]
    return heads[0] + scan.joined(scans)


def _band(planes: Sequence[Plane], factors: Factors, first: int, end: int) -> Band:
    """Return the blocks of a band, and what means are told from: those of the last block before."""
    return [
        (plane[first * down : end * down], int(plane[first * down - 1, -1, 0]) if first else 0)
        for plane, (down, _) in zip(planes, factors, strict=True)
    ]


def _encoded(band: Band, first: int, end: int, write: Write) -> tuple[bytes, Bits]:
    """Return a band as a file: all up to the data of its scan, and these."""
    # A file begins with a mean of 0, where all bands but the first go on from another's last block.
    for part, mean in band:
        part[..., 0] -= mean
    try:
        head, data = _halves(write([part for part, _ in band], first, end))
    finally:
        for part, mean in band:
            part[..., 0] += mean
    return head, scan.bits_of(data)


def with_height(file: bytes, height: int) -> bytes:
    """Return a JPEG file whose frame tells another height, px."""
    at = 2
    with io.BytesIO(file) as opened:
        for code, segment in segments(opened):
            if code in _FRAMES:
                place = slice(at + _HEIGHT_AT.start, at + _HEIGHT_AT.stop)
                return file[: place.start] + height.to_bytes(2, "big") + file[place.stop :]
            at += len(segment)
    raise ValueError("no frame")


def _halves(file: bytes) -> tuple[bytes, bytes]:
    """Return all up to the data of the scan, and the data."""
    with io.BytesIO(file) as opened:
        for _ in segments(opened):
            pass  # the file is then at its scan
        start = opened.tell()
    start += 2 + int.from_bytes(file[start + 2 : start + 4], "big")
    return file[:start], file[start:-2]
