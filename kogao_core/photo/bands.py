"""The data of a JPEG's scan, written in bands of rows and joined bit by bit.

A band and the library's copy of it stay within the processor's cache, and bands are written side
by side.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.photo.segments import segments
from kogao_core.threads import default_threads, share_out

_BAND_BYTES: Final = 1 << 21  # of coefficients
_FRAMES: Final = (0xC0, 0xC1)
_HEIGHT_AT: Final = slice(5, 7)
_LAST: Final = 63  # of a block's coefficients; where it is 0, the block ends with a code of its own

Plane = npt.NDArray[np.int16]
Factors = Sequence[tuple[int, int]]
Bits = tuple[npt.NDArray[np.uint8], int]
_NOTHING: Final[Bits] = np.zeros(0, np.uint8), 0


def cuts(planes: Sequence[Plane], factors: Factors) -> list[int]:
    """Return the rows of minimum coded units at which bands begin, and where the last one ends.

    Only where the last block before ends with the usual code for that, whose last bit is 0, can it
    be told from the ones that fill the last byte.

    Parameters
    ----------
    planes : sequence of arrays of shape (rows, columns, 64)
        The blocks of each component.
    factors : sequence of tuple of int
        Blocks per minimum coded unit (down, along) of each component.
    """
    rows = -(-planes[0].shape[0] // factors[0][0])
    least = rows * _BAND_BYTES // sum(plane.nbytes for plane in planes)
    ends = planes[-1][:, -1, _LAST] == 0
    at = [0]
    if ends[-1]:
        down = factors[-1][0]
        for row in range(1, rows):
            if row - at[-1] >= least and ends[row * down - 1]:
                at.append(row)
    return [*at, rows]


def written(
    planes: Sequence[Plane],
    factors: Factors,
    at: Sequence[int],
    write: Callable[[list[Plane], int, int], bytes],
) -> bytes:
    """Return a whole file, made of bands.

    Parameters
    ----------
    planes, factors : sequences
        See `cuts`. The blocks are others while this works, and the same again afterwards.
    at : sequence of int
        What `cuts` returned: two bands or more.
    write : callable
        Given a band's blocks and the rows of units where it begins and ends, in any thread; returns
        it as a file with the usual Huffman codes.
    """
    parts = [
        [plane[first * down : end * down] for plane, (down, _) in zip(planes, factors, strict=True)]
        for first, end in pairwise(at)
    ]
    # A file begins with a mean of 0, where all bands but the first go on from another's last block.
    means = [[0] * len(planes), *([int(one[-1, -1, 0]) for one in band] for band in parts[:-1])]
    heads, scans = [b""] * len(parts), [_NOTHING] * len(parts)

    def encode(band: int) -> None:
        for part, mean in zip(parts[band], means[band], strict=True):
            part[..., 0] -= mean
        try:
            heads[band], data = _halves(write(parts[band], *at[band : band + 2]))
        finally:
            for part, mean in zip(parts[band], means[band], strict=True):
                part[..., 0] += mean
        scans[band] = _bits(data)

    share_out(range(len(parts)), lambda: encode, default_threads())
    return heads[0] + _joined(scans)


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


def _bits(data: bytes) -> Bits:
    """Return the data of a scan, neither stuffed nor filled up, and how many bits they are."""
    plain = np.frombuffer(bytearray(data).replace(b"\xff\0", b"\xff"), np.uint8)
    last = int(plain[-1])
    ones = (last ^ (last + 1)).bit_length() - 1
    plain[-1] = last & (last + 1)
    return plain, 8 * len(plain) - ones


def _joined(scans: Sequence[Bits]) -> bytes:
    """Return the data of a scan, filled up with ones, and the marker of its end."""
    count = sum(bits for _, bits in scans)
    whole, at = np.zeros(-(-count // 8) + 1, np.uint8), 0
    for data, bits in scans:
        start, shift = divmod(at, 8)
        whole[start : start + len(data)] |= data >> shift
        whole[start + 1 : start + 1 + len(data)] |= data << (8 - shift)
        at += bits
    whole[at // 8] |= 0xFF >> (at % 8)
    return whole[: -(-at // 8)].tobytes().replace(b"\xff", b"\xff\0") + b"\xff\xd9"
