"""Numbered points as files hold them, read with suspicion."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array, frozen
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.base.wording import shown

MOST_BYTES: Final = 8 * 2**20
MOST_POINTS: Final = 10_000
# Ends of lines: a thousand faces of 189 points, from Windows.
_MOST_LINES: Final = 400_000
_LONGEST_LINE: Final = 100_000
_LINE_ENDS: Final = re.compile("[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]")
# Farther from the photo's corner nothing is a landmark of it, px.
FARTHEST_PX: Final = 1e6


@dataclass(frozen=True, slots=True)
class Line:
    """Points joined by a line, by number; a closed one returns to its first."""

    points: tuple[int, ...]
    closed: bool = False


@dataclass(frozen=True, eq=False)
class PointSet:
    """The points of one face."""

    points: Array  # (N, 2): px of the upright photo, pixel centres at whole numbers from 0, y down
    lines: tuple[Line, ...] = ()  # how a template joins them; kept for those who draw them

    def __post_init__(self) -> None:
        """Freeze the points."""
        object.__setattr__(self, "points", frozen(self.points, (None, 2)))


def text_of(data: bytes) -> str:
    """Return a file's text. Result: without a byte order mark. Raises BadFile."""
    if len(data) > MOST_BYTES:
        raise BadFile(
            Text(
                "the file has more than {most_bytes} bytes, too many for landmarks",
                most_bytes=MOST_BYTES,
            )
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise BadFile(Text("the file is no text"))
    _check_lines(text)
    return text


def _check_lines(text: str) -> None:
    start = 0
    ends = [*islice((end.start() for end in _LINE_ENDS.finditer(text)), _MOST_LINES + 1), len(text)]
    for end in ends:
        if len(ends) > _MOST_LINES + 1 or end - start > _LONGEST_LINE:
            raise BadFile(Text("the file has too many lines, or too long ones, for landmarks"))
        start = end


def count_in(text: str, what: str) -> int:
    """Read how many points or lines there are. Raises BadFile."""
    if not (text.isascii() and text.isdecimal() and len(text) < 9 and int(text) <= MOST_POINTS):
        raise BadFile(Text("{text} can't be the number of {what}", text=shown(text), what=what))
    return int(text)


def coordinates(rows: Sequence[Sequence[str]]) -> Array:
    """Read a row of two numbers for each point, shape (N, 2), px. Raises BadFile."""
    found = np.empty((len(rows), 2))
    for number, row in enumerate(rows, start=1):
        try:
            x, y = (float(value) for value in row)
        except ValueError:
            text = shown(" ".join(row))
            raise BadFile(
                Text("point {number} must be two numbers, got {text}", number=number, text=text)
            ) from None
        if not all(math.isfinite(value) and abs(value) <= FARTHEST_PX for value in (x, y)):
            raise BadFile(
                Text("point {number} lies nowhere: {x:g}, {y:g}", number=number, x=x, y=y)
            )
        found[number - 1] = x, y
    return found


def number(value: float) -> str:
    """Write a coordinate, to a thousandth of a px. Result: with three decimals."""
    return f"{value:.3f}"
