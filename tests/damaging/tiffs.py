"""Damage to the entries of TIFF directories, where they lie: in TIFF, DNG and EXIF alike."""

from __future__ import annotations

import struct

import numpy as np

from damaging import bytewise

_BELOW = (330, 34665, 34853, 40965)  # tags that point to further directories
_MOST_ENTRIES = 1000
_TAG, _KIND, _COUNT, _VALUE = (0, 2), (2, 2), (4, 4), (8, 4)


def change(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a file with one field of an entry changed, or the place of a directory."""
    order = "<" if data[:2] == b"II" else ">"
    entries, links = [], [4]
    try:
        _walk(data, order, int(struct.unpack_from(order + "I", data, 4)[0]), entries, links)
    except struct.error:
        return bytewise.change(data, rng, data)
    changed = bytearray(data)
    if not entries or rng.random() < 0.1:
        at = int(rng.choice(links))
        to = int(rng.choice([*links, 0, len(data), len(data) - 1, 8]))
        struct.pack_into(order + "I", changed, at, to)
        return bytes(changed)
    at = int(rng.choice(entries))
    other = int(rng.choice(entries))
    start, size = (_TAG, _KIND, _COUNT, _VALUE)[rng.choice(4, p=[0.15, 0.15, 0.3, 0.4])]
    place = slice(at + start, at + start + size)
    if rng.random() < 0.3:
        changed[place] = data[other + start : other + start + size]
    elif rng.random() < 0.5:
        value = int(rng.integers(14)) if start == 2 else int(rng.integers(1 << 17))
        changed[place] = value.to_bytes(4, "little")[:size][:: 1 if order == "<" else -1]
    else:
        changed[place] = bytewise.number(rng, size)
    return bytes(changed)


def _walk(data: bytes, order: str, at: int, entries: list[int], links: list[int]) -> None:
    while at and len(entries) + len(links) < _MOST_ENTRIES:  # some point to themselves
        (count,) = struct.unpack_from(order + "H", data, at)
        for entry in range(at + 2, at + 2 + 12 * count, 12):
            tag, _, _, value = struct.unpack_from(order + "HHII", data, entry)
            entries.append(entry)
            if tag in _BELOW:
                links.append(entry + 8)
                _walk(data, order, value, entries, links)
        links.append(at + 2 + 12 * count)
        (at,) = struct.unpack_from(order + "I", data, links[-1])
