"""Parse and write the landmark formats: .pts, .csv and JSON.

Coordinates are px of the upright photo: pixel centres at whole numbers from 0, x to the right, y
down. Only .pts counts pixels from 1.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Sequence
from itertools import islice
from typing import Final

import numpy as np

from kogao_core.base import json_reader
from kogao_core.base.geometry import Array
from kogao_core.base.json_reader import BadFile, Node
from kogao_core.base.language import Text
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
# More lines than a thousand faces of 189 points need, with the line ends of Windows.
_MOST_LINES: Final = 400_000
_LONGEST_LINE: Final = 100_000
_LINE_ENDS: Final = re.compile("[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]")
# The largest coordinate of a landmark, px.
_FARTHEST_PX: Final = 1e6


def text_of(data: bytes) -> str:
    """Decode a file without its byte order mark. Raises BadFile."""
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


def _coordinates(rows: Sequence[Sequence[str]]) -> Array:
    """Parse rows of two numbers. Result: (N, 2), px. Raises BadFile."""
    points = np.empty((len(rows), 2))
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
                Text("point {number} is out of range: {x:g}, {y:g}", number=number, x=x, y=y)
            )
        points[number - 1] = x, y
    return points


# .pts: version, number of points, and the points in braces; rows that begin with # are comments.
# As in Matlab, the centre of the first pixel is 1, 1.
_FIRST_PIXEL: Final = 1.0
_PTS: Final = re.compile(
    r"\s*version:\s*1(?:\.0)?\s+n_points:\s*(\d{1,5})\s*\{([^{}]*)\}\s*", re.ASCII
)


def parse_pts(data: bytes) -> Array:
    """Parse a .pts file of any number of points. Result: (N, 2). Raises BadFile."""
    lines = [line for line in text_of(data).splitlines() if not line.lstrip().startswith("#")]
    match = _PTS.fullmatch("\n".join(lines))
    if match is None:
        raise BadFile(Text("the file must be 'version: 1', 'n_points: N' and the points in braces"))
    count = int(match[1])
    rows = [row.split() for row in match[2].splitlines() if row.strip()]
    if len(rows) != count:
        raise BadFile(
            Text("the file says {count} points and has {found}", count=count, found=len(rows))
        )
    return _coordinates(rows) - _FIRST_PIXEL


def pts_text(points: Array) -> str:
    """Return points (N, 2) as .pts, rounded to 0.001 px."""
    rows = [f"{x:.3f} {y:.3f}" for x, y in (points + _FIRST_PIXEL).tolist()]
    return "\n".join(["version: 1", f"n_points: {len(rows)}", "{", *rows, "}"]) + "\n"


def parse_csv(data: bytes) -> list[Array]:
    """Parse a table with columns x and y, and optional columns face and point. Raises BadFile.

    Columns may be separated by semicolons; numbers then have a decimal comma. The names of
    `csv_text` in column point sort the rows. Result: (N, 2) per face, in order of the first rows.
    """
    try:
        text = text_of(data)
        sign = ";" if ";" in text.partition("\n")[0] else ","
        rows = [row for row in csv.reader(io.StringIO(text), delimiter=sign, strict=True) if row]
    except csv.Error as error:
        raise BadFile(Text("the file is not a table ({error})", error=error)) from None
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
    return [_coordinates(_in_order(points)) for points in faces.values()]


def _in_order(named: list[tuple[str, list[str]]]) -> list[list[str]]:
    """Sort pairs by the names of `csv_text`; keep the order if the names differ."""
    by_name = dict(named)
    for names in (OWN_NAMES, _numbered(len(named))):
        if len(by_name) == len(named) and by_name.keys() == set(names):
            return [by_name[name] for name in names]
    return [pair for _, pair in named]


def _numbered(count: int) -> list[str]:
    """Return the numbers from 0 as names."""
    return [str(k) for k in range(count)]


def csv_text(faces: Sequence[Array]) -> str:
    """Return a table with one named row for each point of each face (N, 2)."""
    rows: list[tuple[object, ...]] = [("face", "point", "x", "y")]
    for index, points in enumerate(faces, start=1):
        names = OWN_NAMES if len(points) == len(OWN_NAMES) else _numbered(len(points))
        places = zip(names, points.tolist(), strict=True)
        rows += [(index, name, f"{x:.3f}", f"{y:.3f}") for name, (x, y) in places]
    with io.StringIO(newline="") as out:
        csv.writer(out, lineterminator="\n").writerows(rows)
        return out.getvalue()


def parse_faces(data: bytes) -> list[Face]:
    """Parse JSON of `faces_text` or ``kogao-cli detect --json``, at least one. Raises BadFile."""
    top = json_reader.parse(data, MOST_BYTES)
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


def _check_ours(value: object) -> None:
    """Raise BadFile with advice if the JSON is a project or from another program."""
    if not isinstance(value, dict) or not value or "faces" in value:
        return
    if "unit_px" in value:
        raise BadFile(
            Text("it is a project; open it in the editor or use kogao-cli warp --project")
        )
    raise BadFile(
        Text(
            "it has {fields} instead of the faces of kogao-cli detect --json; save points of "
            "other programs, such as LabelMe, as a .csv file with columns x and y",
            fields=shown(", ".join(list(value)[:4])),
        )
    )


def _face(node: Node) -> Face:
    outline, eyes, mouth = (_points(node.field(name)) for name in ("outline", "eyes", "mouth"))
    try:
        return Face(outline, eyes, mouth)
    except ValueError as error:
        node.refuse(Text("is not a face: {error}", error=error))


def _points(node: Node) -> Array:
    rows = [row.items(2) for row in node.items(_MOST_POINTS)]
    if any(len(row) != 2 for row in rows):
        node.refuse(Text("must be pairs of numbers"))
    pairs = [[value.number(-_FARTHEST_PX, _FARTHEST_PX) for value in row] for row in rows]
    return np.array(pairs).reshape(-1, 2)


def faces_text(faces: Sequence[Face]) -> str:
    """Return faces as JSON, without rounding."""
    return json.dumps({"faces": [face.to_dict() for face in faces]}, indent=1) + "\n"
