"""The data of a JPEG's scan as bits: cut, found again, and joined."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

_MARKER: Final = re.compile(rb"\xff[^\0]")  # or a byte that fills up before one
_END: Final = b"\xff\xd9"
_TRIES: Final = 4  # where bits repeat themselves, they tell no place


class Bits(NamedTuple):
    """Bits without what is stuffed between them."""

    # The first bit is the highest of the first byte; zeros fill up the last.
    data: npt.NDArray[np.uint8]
    length: int  # how many they are


NOTHING: Final = Bits(np.zeros(0, np.uint8), 0)


def bits_of(data: bytes | memoryview) -> Bits:
    """Return the data of a scan, neither stuffed nor filled up; their last bit is taken for a 0."""
    plain = np.frombuffer(bytearray(data).replace(b"\xff\0", b"\xff"), np.uint8)
    last = int(plain[-1])
    ones = (last ^ (last + 1)).bit_length() - 1
    plain[-1] = last & (last + 1)
    return Bits(plain, 8 * len(plain) - ones)


def only_scan(file: memoryview) -> Bits | None:
    """Return the data of the one scan of a file, None where there are more, or restarts in it."""
    start = 2 + int.from_bytes(file[2:4], "big")
    marker = _MARKER.search(file, start)
    if marker is None or marker[0] != _END or marker.start() == start:
        return None
    return bits_of(file[start : marker.start()])


def part(bits: Bits, first: int, end: int) -> Bits:
    """Return the bits from `first` up to `end`."""
    start, shift = divmod(first, 8)
    size = -(-(end - first) // 8)
    found = bits.data[start : start + size + 1]
    span = np.zeros(size + 1, np.uint8)
    span[: len(found)] = found
    data = np.asarray(span[:-1] << shift | span[1:] >> (8 - shift), np.uint8)
    data[-1:] &= 0xFF << (first - end) % 8 & 0xFF
    return Bits(data, end - first)


def place(bits: Bits, wanted: Bits) -> int | None:
    """Return the one place in `bits` where others begin, None where there is none or more."""
    data, places = bits.data.tobytes(), []
    for shift in range(8):  # of the wanted ones, up to the first that begins a byte of `data`
        whole = part(wanted, shift, wanted.length - (wanted.length - shift) % 8).data.tobytes()
        at = -1
        for _ in range(_TRIES):
            at = data.find(whole, at + 1)
            if at < 0:
                break
            first = 8 * at - shift
            if is_at(bits, first, wanted):
                places.append(first)
        else:
            return None
    return places[0] if len(places) == 1 else None


def is_at(bits: Bits, first: int, wanted: Bits) -> bool:
    """Tell whether others lie there in `bits`."""
    return first >= 0 and np.array_equal(part(bits, first, first + wanted.length).data, wanted.data)


def joined(scans: Sequence[Bits]) -> bytes:
    """Return the data of a scan, filled up with ones, and the marker of its end."""
    count = sum(bits for _, bits in scans)
    whole, at = np.zeros(-(-count // 8) + 1, np.uint8), 0
    for data, bits in scans:
        start, shift = divmod(at, 8)
        whole[start : start + len(data)] |= data >> shift
        whole[start + 1 : start + 1 + len(data)] |= data << (8 - shift)
        at += bits
    whole[at // 8] |= 0xFF >> (at % 8)
    return whole[: -(-at // 8)].tobytes().replace(b"\xff", b"\xff\0") + _END
