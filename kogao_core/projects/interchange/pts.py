"""iBUG's ``.pts``: version, number of points, and the points in braces.

Rows that begin with # don't count.

They count pixels from 1, as Matlab does: the centre of the first pixel is 1, 1 there and 0, 0 here.
y runs down.
"""

from __future__ import annotations

import re
from typing import Final

from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.projects.interchange.points import PointSet, coordinates, count_in, number, text_of

FIRST_PIXEL: Final = 1.0
_WHOLE: Final = re.compile(
    r"\s*version:\s*1(?:\.0)?\s+n_points:\s*(\S{1,40})\s*\{([^{}]*)\}\s*", re.ASCII
)


def parse(data: bytes) -> PointSet:
    """Read a file of any number of points.

    Result: px, with pixel centres at whole numbers. Raises BadFile.
    """
    lines = [line for line in text_of(data).splitlines() if not line.lstrip().startswith("#")]
    found = _WHOLE.fullmatch("\n".join(lines))
    if found is None:
        raise BadFile(Text("the file must be 'version: 1', 'n_points: N' and the points in braces"))
    count = count_in(found[1], "points")
    rows = [row.split() for row in found[2].splitlines() if row.strip()]
    if len(rows) != count:
        raise BadFile(
            Text("the file says {count} points and has {found}", count=count, found=len(rows))
        )
    return PointSet(coordinates(rows) - FIRST_PIXEL)


def text(points: PointSet) -> str:
    """Write a file; lines between points are left out, the format has none.

    Result: the file, which counts from 1.
    """
    rows = [f"{number(x)} {number(y)}" for x, y in (points.points + FIRST_PIXEL).tolist()]
    head = ["version: 1", f"n_points: {len(rows)}"]
    return "\n".join([*head, "{", *rows, "}"]) + "\n"
