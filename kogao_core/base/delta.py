"""A file as what differs from another one: runs of the other one's bits, and bytes of its own.

Whatever stays of a JPEG stays bit for bit, but a change moves all that follows by some bits: so the
other one's bits are looked for at any bit. The zeros that JPEG puts behind bytes of ones are taken
out of both files before.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

_JPEG: Final = b"\xff\xd8"
_ONES: Final = 0xFF
_HEAD: Final = struct.Struct("<4sIII")  # name, runs, lengths in bytes: of packed marks, of runs
_NAME: Final = b"KGD1"
_WORD: Final = 8  # bytes by which a run is found
_SHORTEST: Final = 24  # bytes of a run: what says where it lies takes a third of them
_ODD: Final = np.uint64(0x9E3779B97F4A7C15)
_ONE_OF: Final = np.uint64(60)  # one of 2**(64 - 60) words is remembered
_PIECE: Final = 1 << 20
_STEP: Final = 1 << 12

Bytes = npt.NDArray[np.uint8]


def difference(old: bytes, new: bytes) -> bytes:
    """Return from what `applied` makes the bytes of `old`, given those of `new`."""
    is_jpeg = old.startswith(_JPEG) and new.startswith(_JPEG)
    wanted, marks = _plain(old) if is_jpeg else (_array(old), None)
    known = _plain(new)[0] if is_jpeg else _array(new)
    runs, own, end = [], [], 0
    for start, stop, bit in _found(wanted, known, range(8 if is_jpeg else 1)):
        runs.append((start - end, stop - start, bit))
        own.append(wanted[end:start])
        end = stop
    own.append(wanted[end:])
    packed = zlib.compress(b"" if marks is None else np.packbits(marks).tobytes(), 9)
    table = zlib.compress(np.array(runs, "<u8").tobytes(), 9)
    head = _HEAD.pack(_NAME, len(runs), len(packed), len(table))
    return b"".join([head, packed, table, *(one.tobytes() for one in own)])


def applied(delta: bytes, new: bytes) -> bytes:
    """Return the file that `difference` was given first. Raises ValueError where it can't be."""
    try:
        return _applied(delta, new)
    except (struct.error, zlib.error, IndexError) as error:
        raise ValueError(str(error)) from error


def _applied(delta: bytes, new: bytes) -> bytes:
    name, count, marks_bytes, table_bytes = _HEAD.unpack_from(delta)
    if name != _NAME:
        raise ValueError(name)
    ends = np.cumsum([_HEAD.size, marks_bytes, table_bytes])
    marks, table = (zlib.decompress(delta[a:b]) for a, b in pairwise(ends))
    runs = np.frombuffer(table, "<u8").reshape(count, 3)
    known = _plain(new)[0] if marks else _array(new)
    own, at, parts = _array(delta)[ends[2] :], 0, []
    for ahead, length, bit in runs.tolist():
        parts += [own[at : at + ahead], _bits(known, bit, length)]
        at += ahead
    wanted = np.concatenate([*parts, own[at:]])
    return _stuffed(wanted, marks) if marks else wanted.tobytes()


def _array(data: bytes) -> Bytes:
    return np.frombuffer(data, np.uint8)


def _plain(data: bytes) -> tuple[Bytes, npt.NDArray[np.bool_]]:
    """Return bytes without the zeros behind ones, and behind which ones there was such a zero."""
    whole = _array(data)
    ones = np.flatnonzero(whole == _ONES)
    followed = np.append(whole, 1)[ones + 1] == 0
    return np.delete(whole, ones[followed] + 1), followed


def _stuffed(plain: Bytes, marks: bytes) -> bytes:
    ones = np.flatnonzero(plain == _ONES)
    followed = np.unpackbits(_array(marks), count=len(ones)).astype(bool)
    return np.insert(plain, ones[followed] + 1, 0).tobytes()


def _bits(known: Bytes, bit: int, length: int) -> Bytes:
    """Return so many bytes from a bit on."""
    start, shift = divmod(bit, 8)
    first = known[start : start + length]
    if not shift:
        return first
    second = known[start + 1 : start + 1 + length]
    both = (first[: len(second)] << shift) | (second >> (8 - shift))
    return both.astype(np.uint8, copy=False)


def _found(wanted: Bytes, known: Bytes, shifts: range) -> Iterator[tuple[int, int, int]]:
    """Yield start and end of each run of wanted bytes, and the bit from which they are known."""
    words, bits = _anchors(known, shifts)
    sought, starts = _anchors(wanted, range(1))
    order = np.argsort(starts)
    sought, starts = sought[order], starts[order] // 8
    places = np.minimum(np.searchsorted(words, sought), max(0, len(words) - 1))
    hits = words[places] == sought if len(words) else np.zeros(len(sought), bool)
    starts, bits = starts[hits], bits[places[hits]] if len(words) else bits
    end, bit, k = 0, 0, -1  # the first bytes of both
    while True:
        start = end if k < 0 else int(starts[k])
        back = 0 if k < 0 else _alike(wanted, known, start, bit, end)
        stop = start + _run(wanted, known, start, bit)
        if stop - start + back >= _SHORTEST:
            yield start - back, stop, bit - 8 * back
            end = stop
        k = max(k + 1, int(np.searchsorted(starts, end)))
        if k >= len(starts):
            return
        bit = int(bits[k])


def _run(wanted: Bytes, known: Bytes, start: int, bit: int) -> int:
    """Return how many bytes are the same from there on."""
    length, step = 0, _STEP
    while True:
        want = wanted[start + length : start + length + step]
        have = _bits(known, bit + 8 * length, len(want))
        differs = np.flatnonzero(want[: len(have)] != have)
        if len(differs):
            return length + int(differs[0])
        length += len(have)
        if len(have) < step:
            return length
        step *= 2


def _alike(wanted: Bytes, known: Bytes, start: int, bit: int, least: int) -> int:
    """Return how many bytes before are the same, back to a least one."""
    length, step = 0, _STEP
    while True:
        step = min(step, start - length - least, bit // 8 - length)
        if step <= 0:
            return length
        want = wanted[start - length - step : start - length]
        have = _bits(known, bit - 8 * (length + step), step)
        differs = np.flatnonzero(want != have)
        if len(differs):
            return length + step - 1 - int(differs[-1])
        length += step
        step *= 2


def _anchors(data: Bytes, shifts: range) -> tuple[npt.NDArray[np.uint64], npt.NDArray[np.int64]]:
    """Return words that a file holds once, by their hash some of all, and the bits they start at.

    Of a few that are the same none counts: what repeats itself, such as a plain sky, leads astray.
    """
    words, bits = [np.empty(0, np.uint64)], [np.empty(0, np.int64)]
    for top in range(0, len(data), _PIECE):
        piece = data[top : top + _PIECE + _WORD]
        for shift in shifts:
            shifted = _bits(piece, shift, len(piece))
            for k in range(_WORD):
                there = shifted[k : k + (len(shifted) - k) // _WORD * _WORD].view("<u8")
                some = np.flatnonzero((there * _ODD) >> _ONE_OF == 0)
                words.append(there[some])
                bits.append((top + k + some * _WORD) * 8 + shift)
    found, first, count = np.unique(np.concatenate(words), return_index=True, return_counts=True)
    alone = count == 1
    return found[alone], np.concatenate(bits)[first[alone]]
