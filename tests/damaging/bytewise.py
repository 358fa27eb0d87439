"""Damage that knows nothing of formats: flipped bits, nasty numbers, cuts, repeats, splices."""

from __future__ import annotations

import numpy as np

ENOUGH = 0.4  # chance that a change was the last: most files stay almost sound
# Values that sizes, counts and offsets are commonly mistaken with.
NASTY = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF)
_HEAD = 200  # bytes: headers decide most


def number(rng: np.random.Generator, size: int) -> bytes:
    """Return a nasty number of `size` bytes, in either order."""
    value = NASTY[rng.integers(len(NASTY))] % (1 << 8 * size)
    return value.to_bytes(size, "big" if rng.random() < 0.5 else "little")


def change(data: bytes, rng: np.random.Generator, other: bytes) -> bytes:
    """Return bytes with one change; `other` is a file that parts may come from."""
    changed = bytearray(data)
    reach = len(data) if rng.random() < 0.5 else min(len(data), _HEAD)
    at = int(rng.integers(max(1, reach)))
    some = int(rng.integers(1, 64))
    kind = rng.integers(7)
    if kind == 0:
        changed[at : at + 1] = bytes(byte ^ (1 << int(rng.integers(8))) for byte in data[at:][:1])
    elif kind == 1:
        size = int(rng.choice([1, 2, 4]))
        changed[at : at + size] = number(rng, size)
    elif kind == 2:
        del changed[at:]
    elif kind == 3:
        changed[at:at] = data[at : at + some]
    elif kind == 4:
        del changed[at : at + some]
    elif kind == 5:
        changed[at:at] = data[at : at + some] * int(rng.integers(2, 2000))
    else:
        start = int(rng.integers(max(1, len(other))))
        changed[at : at + 32] = other[start : start + 32]
    return bytes(changed)
