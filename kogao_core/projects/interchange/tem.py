"""WebMorph and PsychoMorph templates (``.tem``): numbered points, and the lines that join them.

Text: the number of points, a line of x and y for each, the number of lines, and for each of them
three rows: 1 if it is closed, how many points it has, and their numbers from 0. Blank rows and rows
that begin with # don't count. x runs to the right and y down from the top left corner, so no height
is needed; whole numbers are taken to be pixel centres.
"""

from __future__ import annotations

from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.projects.interchange.points import (
    Line,
    PointSet,
    coordinates,
    count_in,
    number,
    text_of,
)


def parse(data: bytes) -> PointSet:
    r"""Read a template of any number of points.

    Result: px, and the lines between points where there are some. Raises BadFile.
    """
    stripped = [row.strip() for row in text_of(data).splitlines()]
    rows = [row for row in stripped if row and not row.startswith("#")]
    if not rows:
        raise BadFile(Text("the file is empty"))
    count = count_in(rows[0], "points")
    if len(rows) <= count:
        raise BadFile(
            Text("the file says {count} points and has {found}", count=count, found=len(rows) - 1)
        )
    points = coordinates([row.split() for row in rows[1 : count + 1]])
    return PointSet(points, _lines(rows[count + 1 :], count))


def _lines(rows: list[str], points: int) -> tuple[Line, ...]:
    if not rows:
        return ()
    count = count_in(rows[0], "lines")
    if len(rows) != 1 + 3 * count:
        raise BadFile(
            Text(
                "the file says {count} lines, which take {rows} rows, and has others",
                count=count,
                rows=3 * count,
            )
        )
    return tuple(_line(rows[k : k + 3], points) for k in range(1, len(rows), 3))


def _line(rows: list[str], points: int) -> Line:
    closed, count, numbers = rows
    found = tuple(count_in(text, Text("a point")) for text in numbers.split())
    if closed not in ("0", "1") or len(found) != count_in(count, Text("a line's points")):
        raise BadFile(Text("a line must be 0 or 1, the number of its points, and the points"))
    if any(point >= points for point in found):
        raise BadFile(
            Text(
                "a line joins point {found}, and the points end at {points}",
                found=max(found),
                points=points - 1,
            )
        )
    return Line(found, closed == "1")


def text(points: PointSet) -> str:
    """Write a template. Result: the file."""
    rows = [str(len(points.points))]
    rows += [f"{number(x)}\t{number(y)}" for x, y in points.points.tolist()]
    rows.append(str(len(points.lines)))
    for line in points.lines:
        rows += [str(int(line.closed)), str(len(line.points)), " ".join(map(str, line.points))]
    return "\n".join(rows) + "\n"
