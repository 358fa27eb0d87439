"""Four kinds of files with points, read with suspicion: .tem, .pts, tables (.csv) and JSON.

What follows is true of all but where a format says otherwise: px of the upright photo, pixel
centres at whole numbers from 0, x to the right, y down.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final

import numpy as np

from kogao_core.base import strict
from kogao_core.base.geometry import Array, frozen
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile, Node
from kogao_core.base.wording import shown
from kogao_core.faces.face import OUTLINE_POINTS, Face
from kogao_core.warp.limits import MOST_LANDMARKS

MOST_BYTES: Final = 8 * 2**20
EYES, MOUTH = 4, 2
OWN_NAMES: Final = tuple(
    f"{part}-{number}"
    for part, count in (("outline", OUTLINE_POINTS), ("eye", EYES), ("mouth", MOUTH))
    for number in range(1, count + 1)
)
_MOST_POINTS: Final = 10_000
_MOST_FACES: Final = 1000
# Ends of lines: a thousand faces of 189 points, from Windows.
_MOST_LINES: Final = 400_000
_LONGEST_LINE: Final = 100_000
_LINE_ENDS: Final = re.compile("[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]")
# Farther from the photo's corner nothing is a landmark of it, px.
_FARTHEST_PX: Final = 1e6


@dataclass(frozen=True, slots=True)
class Line:
    """Points joined by a line, by number; a closed one returns to its first."""

    points: tuple[int, ...]
    closed: bool = False


@dataclass(frozen=True, eq=False)
class PointSet:
    """The points of one face."""

    points: Array  # (N, 2)
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
    start = 0
    ends = [*islice((end.start() for end in _LINE_ENDS.finditer(text)), _MOST_LINES + 1), len(text)]
    for end in ends:
        if len(ends) > _MOST_LINES + 1 or end - start > _LONGEST_LINE:
            raise BadFile(Text("the file has too many lines, or too long ones, for landmarks"))
        start = end
    return text


def _count_in(text: str, what: str) -> int:
    """Read how many points or lines there are. Raises BadFile."""
    if not (text.isascii() and text.isdecimal() and len(text) < 9 and int(text) <= _MOST_POINTS):
        raise BadFile(Text("{text} can't be the number of {what}", text=shown(text), what=what))
    return int(text)


def _coordinates(rows: Sequence[Sequence[str]]) -> Array:
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
        if not all(math.isfinite(value) and abs(value) <= _FARTHEST_PX for value in (x, y)):
            raise BadFile(
                Text("point {number} lies nowhere: {x:g}, {y:g}", number=number, x=x, y=y)
            )
        found[number - 1] = x, y
    return found


# WebMorph and PsychoMorph templates: the number of points, a line of x and y for each, the number
# of lines, and for each of them three rows: 1 if it is closed, how many points it has, and their
# numbers from 0. Blank rows and rows that begin with # don't count.


def parse_tem(data: bytes) -> PointSet:
    """Read a template of any number of points, and the lines between them. Raises BadFile."""
    stripped = [row.strip() for row in text_of(data).splitlines()]
    rows = [row for row in stripped if row and not row.startswith("#")]
    if not rows:
        raise BadFile(Text("the file is empty"))
    count = _count_in(rows[0], "points")
    if len(rows) <= count:
        raise _other_count(count, len(rows) - 1)
    points = _coordinates([row.split() for row in rows[1 : count + 1]])
    return PointSet(points, _lines(rows[count + 1 :], count))


def _other_count(said: int, found: int) -> BadFile:
    return BadFile(Text("the file says {count} points and has {found}", count=said, found=found))


def _lines(rows: list[str], points: int) -> tuple[Line, ...]:
    if not rows:
        return ()
    count = _count_in(rows[0], "lines")
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
    found = tuple(_count_in(text, Text("a point")) for text in numbers.split())
    if closed not in ("0", "1") or len(found) != _count_in(count, Text("a line's points")):
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


def tem_text(points: PointSet) -> str:
    """Write a template, to a thousandth of a px."""
    rows = [str(len(points.points))]
    rows += [f"{x:.3f}\t{y:.3f}" for x, y in points.points.tolist()]
    rows.append(str(len(points.lines)))
    for line in points.lines:
        rows += [str(int(line.closed)), str(len(line.points)), " ".join(map(str, line.points))]
    return "\n".join(rows) + "\n"


# iBUG's points: version, number of points, and the points in braces. Rows that begin with # don't
# count. Pixels are counted from 1, as Matlab does: the centre of the first one is 1, 1.
_FIRST_PIXEL: Final = 1.0
_PTS: Final = re.compile(
    r"\s*version:\s*1(?:\.0)?\s+n_points:\s*(\S{1,40})\s*\{([^{}]*)\}\s*", re.ASCII
)


def parse_pts(data: bytes) -> PointSet:
    """Read iBUG's points, of any number. Raises BadFile."""
    lines = [line for line in text_of(data).splitlines() if not line.lstrip().startswith("#")]
    found = _PTS.fullmatch("\n".join(lines))
    if found is None:
        raise BadFile(Text("the file must be 'version: 1', 'n_points: N' and the points in braces"))
    count = _count_in(found[1], "points")
    rows = [row.split() for row in found[2].splitlines() if row.strip()]
    if len(rows) != count:
        raise _other_count(count, len(rows))
    return PointSet(_coordinates(rows) - _FIRST_PIXEL)


def pts_text(points: PointSet) -> str:
    """Write iBUG's points, to a thousandth of a px; the format has no lines between them."""
    rows = [f"{x:.3f} {y:.3f}" for x, y in (points.points + _FIRST_PIXEL).tolist()]
    return "\n".join(["version: 1", f"n_points: {len(rows)}", "{", *rows, "}"]) + "\n"


def parse_csv(data: bytes) -> list[PointSet]:
    """Read a table with the columns x and y, and face where it holds several; others are left out.

    Columns may be parted by semicolons, and numbers then have a decimal comma. Rows may be in any
    order where a column point names them as `csv_text` does. Result: one for each face, in the
    order of their first rows. Raises BadFile.
    """
    try:
        text = text_of(data)
        sign = ";" if ";" in text.partition("\n")[0] else ","
        rows = [row for row in csv.reader(io.StringIO(text), delimiter=sign, strict=True) if row]
    except csv.Error as error:
        raise BadFile(Text("the file is no table ({error})", error=error)) from None
    header = [name.strip().lower() for name in rows[0]] if rows else []
    if header.count("x") != 1 or header.count("y") != 1:
        raise BadFile(Text("the file's first row must name the columns x and y"))
    if any(len(row) != len(header) for row in rows[1:]):
        raise BadFile(
            Text("every row must have {count} columns, like the first", count=len(header))
        )
    face, point, x, y = (
        header.index(name) if name in header else -1 for name in ("face", "point", "x", "y")
    )
    faces: dict[str, list[tuple[str, list[str]]]] = {}
    for row in rows[1:]:
        pair = [row[x], row[y]] if sign == "," else [row[k].replace(",", ".") for k in (x, y)]
        name = row[point].strip() if point >= 0 else ""
        faces.setdefault(row[face].strip() if face >= 0 else "", []).append((name, pair))
    if not faces or len(faces) > _MOST_FACES:
        raise BadFile(Text("the file holds {count} faces", count=len(faces)))
    return [PointSet(_coordinates(_in_order(points))) for points in faces.values()]


def _in_order(named: list[tuple[str, list[str]]]) -> list[list[str]]:
    """Return pairs in the order that their names tell, if these are ours; else as they are."""
    by_name = dict(named)
    for names in (OWN_NAMES, _numbered(len(named))):
        if len(by_name) == len(named) and by_name.keys() == set(names):
            return [by_name[name] for name in names]
    return [pair for _, pair in named]


def _numbered(count: int) -> list[str]:
    """Return the names of points that have none of their own: how many precede each."""
    return [str(k) for k in range(count)]


def csv_text(faces: Sequence[Array]) -> str:
    """Write a table: a row for each point of each face, shape (N, 2), with its name."""
    rows: list[tuple[object, ...]] = [("face", "point", "x", "y")]
    for index, points in enumerate(faces, start=1):
        names = OWN_NAMES if len(points) == len(OWN_NAMES) else _numbered(len(points))
        places = zip(names, points.tolist(), strict=True)
        rows += [(index, name, f"{x:.3f}", f"{y:.3f}") for name, (x, y) in places]
    with io.StringIO(newline="") as out:
        csv.writer(out, lineterminator="\n").writerows(rows)
        return out.getvalue()


def parse_faces(data: bytes) -> list[Face]:
    """Read what `faces_text` or ``kogao-cli detect --json`` wrote, at least one. Raises BadFile."""
    top = strict.parse(data, MOST_BYTES)
    _check_ours(top.value)
    faces = top.field("faces").items(_MOST_FACES)
    if not faces:
        raise BadFile(Text("the file holds no face"))
    if sum(face.count("outline") for face in faces) > MOST_LANDMARKS:
        raise BadFile(
            Text(
                "the file's faces have more than {most_landmarks} landmarks together",
                most_landmarks=MOST_LANDMARKS,
            )
        )
    return [_face(face) for face in faces]


def _check_ours(found: object) -> None:
    """Say what a file of another program, or of another kind, is taken for."""
    if not isinstance(found, dict) or not found or "faces" in found:
        return
    if "unit_px" in found:
        raise BadFile(
            Text("it is a project; open it in the editor, or use it by kogao-cli warp --project")
        )
    raise BadFile(
        Text(
            "it holds {fields} in place of the faces that kogao-cli detect --json writes; write "
            "the points of other programs, such as LabelMe, as a .csv file with columns x and y",
            fields=shown(", ".join(list(found)[:4])),
        )
    )


def _face(node: Node) -> Face:
    outline, eyes, mouth = (_points(node.field(name)) for name in ("outline", "eyes", "mouth"))
    try:
        return Face(outline, eyes, mouth)
    except ValueError as error:
        node.refuse(Text("is no face: {error}", error=error))


def _points(node: Node) -> Array:
    rows = [row.items(2) for row in node.items(_MOST_POINTS)]
    if any(len(row) != 2 for row in rows):
        node.refuse(Text("must be pairs of numbers"))
    pairs = [[value.number(-_FARTHEST_PX, _FARTHEST_PX) for value in row] for row in rows]
    return np.array(pairs).reshape(-1, 2)


def faces_text(faces: Sequence[Face]) -> str:
    """Write faces to the last bit. Result: JSON."""
    return json.dumps({"faces": [face.to_dict() for face in faces]}, indent=1) + "\n"
