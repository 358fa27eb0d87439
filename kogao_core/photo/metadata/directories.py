"""Walk TIFF directories in a buffer: positions and numbers of their entries, to read or patch."""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

# Letters of `struct` by TIFF type. A rational is one number of 8 bytes; 13 is a directory.
_LETTERS: Final = dict(enumerate("BBHIQBBHIQIQI", start=1))


@dataclass(frozen=True, slots=True)
class Numbers:
    """Position, type and count of consecutive numbers."""

    at: int
    kind: int = 4
    count: int = 1

    @property
    def code(self) -> str:
        """Format for `struct`, without the byte order."""
        return f"{self.count}{_LETTERS.get(self.kind, 'B')}"

    @property
    def end(self) -> int:
        """Offset after the last number."""
        return self.at + struct.calcsize(f"={self.code}")


FIRST: Final = Numbers(4)
"""The link to the first directory."""


class Directories:
    """A TIFF structure. Damaged structures raise KeyError or struct.error."""

    def __init__(self, data: bytearray | mmap.mmap) -> None:
        self.data = data
        self._order = {b"II": "<", b"MM": ">"}[bytes(data[:2])]

    def read(self, numbers: Numbers) -> tuple[int, ...]:
        """Return the numbers."""
        return struct.unpack_from(self._order + numbers.code, self.data, numbers.at)

    def write(self, numbers: Numbers, *values: int) -> None:
        """Replace the numbers."""
        struct.pack_into(self._order + numbers.code, self.data, numbers.at, *values)

    def link(self, start: int) -> Numbers:
        """Return the link from a directory to the next one."""
        return Numbers(start + 2 + 12 * self.read(Numbers(start, 3))[0])

    def entries(self, start: int) -> Iterator[tuple[int, Numbers]]:
        """Yield tag and numbers of each entry of a directory."""
        for at in range(start + 2, self.link(start).at, 12):
            tag, kind = self.read(Numbers(at, 3, 2))
            count, place = self.read(Numbers(at + 4, count=2))
            inline = Numbers(at + 8, kind, count)
            yield tag, inline if inline.end <= at + 12 else Numbers(place, kind, count)
