"""Walk TIFF directories: positions and numbers of their entries, to read or patch."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import IO, Final

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
    """TIFF structure in an open file. Damaged structures raise KeyError or struct.error."""

    def __init__(self, file: IO[bytes]) -> None:
        file.seek(0)
        self.file, self._order = file, {b"II": "<", b"MM": ">"}[file.read(2)]

    def read(self, numbers: Numbers) -> tuple[int, ...]:
        self.file.seek(numbers.at)
        return struct.unpack(self._order + numbers.code, self.file.read(numbers.end - numbers.at))

    def write(self, numbers: Numbers, *values: int) -> None:
        """Write `values` over the numbers at `numbers.at`. Raises struct.error after the end."""
        new = struct.pack(self._order + numbers.code, *values)
        self.read(numbers)
        self.file.seek(numbers.at)
        self.file.write(new)

    def link(self, start: int) -> Numbers:
        return Numbers(start + 2 + 12 * self.read(Numbers(start, 3))[0])

    def entries(self, start: int) -> Iterator[tuple[int, Numbers]]:
        """Yield tag and numbers of each entry of a directory."""
        for at in range(start + 2, self.link(start).at, 12):
            (tag, kind), (count,) = self.read(Numbers(at, 3, 2)), self.read(Numbers(at + 4))
            numbers = Numbers(at + 8, kind, count)
            if numbers.end > at + 12:
                numbers = Numbers(self.read(Numbers(at + 8))[0], kind, count)
            yield tag, numbers
