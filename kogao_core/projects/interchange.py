"""Import of landmarks from JSON, CSV and iBUG's .pts, export to JSON and CSV (docs/interchange.md).

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
from pathlib import Path
from typing import Final

import numpy as np

from kogao_core.additions.limits import MOST_LANDMARKS, OutOfBounds, check_faces
from kogao_core.base import json_reader
from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Array, Box
from kogao_core.base.json_reader import BadFile, Node
from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.faces.face import OUTLINE_POINTS, Face
from kogao_core.faces.landmarks.outline import resampled

SUFFIXES: Final = (".json", ".csv", ".pts")
MOST_BYTES: Final = 8 * 2**20
_EYES, _MOUTH = 4, 2
_OWN_NAMES: Final = tuple(
    f"{part}-{number}"
    for part, count in (("outline", OUTLINE_POINTS), ("eye", _EYES), ("mouth", _MOUTH))
    for number in range(1, count + 1)
)
_MOST_POINTS: Final = 10_000
_MOST_FACES: Final = 1000
# More lines than a thousand faces need, with the line ends of Windows.
_MOST_LINES: Final = 400_000
_LONGEST_LINE: Final = 100_000
_LINE_ENDS: Final = re.compile("[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]")
# The largest coordinate of a landmark, px.
_FARTHEST_PX: Final = 1e6
_STEPS: Final = 16  # straight pieces between two points of an outline
# Outline, eyes and mouth among the 68 points of iBUG and dlib.
_IBUG_POINTS: Final = 68
_IBUG: Final = (range(17), (36, 39, 42, 45), (48, 54))


def read(path: Path) -> list[Face]:
    """Read the faces of a landmark file, px of the photo; at least one. Raises BadFile."""
    if (suffix := path.suffix.lower()) not in SUFFIXES:
        raise BadFile(
            Text(
                "{path} must end in one of {names}; save points of other programs as .csv with "
                "columns x and y",
                path=path,
                names=", ".join(SUFFIXES),
            )
        )
    data = json_reader.read(path, MOST_BYTES)
    try:
        if suffix == ".json":
            return parse_faces(data)
        sets = parse_csv(data) if suffix == ".csv" else [parse_pts(data)]
        return [face_of(points) for points in sets]
    except BadFile as error:
        raise BadFile(Text("{path} can't be used: {error}", path=path, error=error)) from None


def file_for(photo: Path, place: Path) -> Path:
    """Return `place`, or the landmark file of a photo if `place` is a folder. Raises BadFile."""
    if not place.is_dir():
        return place
    candidates = [place / f"{photo.stem}{suffix}" for suffix in SUFFIXES]
    file = next((file for file in candidates if file.is_file()), None)
    if file is None:
        raise BadFile(
            Text(
                "{folder} has no points for {photo}; expected {name} with one of {endings}",
                photo=photo.name,
                folder=place,
                name=photo.stem,
                endings=", ".join(SUFFIXES),
            )
        )
    return file


def write(faces: Sequence[Face], path: Path) -> str:
    """Write faces as JSON or, for the suffix .csv, as a table of 27 points.

    Return a note if an outline was resampled.
    """
    if path.suffix == ".json":
        atomic_write(faces_text(faces).encode(), path)
        return ""
    atomic_write(csv_text([own_points(face) for face in faces]).encode(), path)
    if all(len(face.outline) == OUTLINE_POINTS for face in faces):
        return ""
    return Text("the outline was resampled to {count} points", count=OUTLINE_POINTS)


def check_inside(faces: Sequence[Face], image: Box) -> None:
    """Check that the middle of each face lies in the photo. Raises BadFile."""
    for number, face in enumerate(faces, start=1):
        x, y = face.middle
        if not (image.left <= x < image.right and image.top <= y < image.bottom):
            raise BadFile(
                Text(
                    "face {number} lies at {x:.0f}, {y:.0f}, outside the photo of "
                    "{width} x {height} px; the points belong to another photo or "
                    "size",
                    number=number,
                    x=x,
                    y=y,
                    width=image.width,
                    height=image.height,
                )
            )
    try:
        check_faces(faces, image, typed=True)
    except OutOfBounds as error:
        raise BadFile(str(error)) from None


def face_of(points: Array) -> Face:
    """Return the face in 27 points (ours) or 68 (iBUG, dlib), shape (N, 2). Raises BadFile.

    The outline of 68 points is spaced evenly.
    """
    if len(points) == len(_OWN_NAMES):
        outline, eyes, mouth = np.split(points, [OUTLINE_POINTS, OUTLINE_POINTS + _EYES])
    elif len(points) == _IBUG_POINTS:
        outline, eyes, mouth = (points[list(numbers)] for numbers in _IBUG)
        outline = along(outline, OUTLINE_POINTS)
    else:
        raise BadFile(
            Text(
                "the file has {count} points instead of 27 or 68 (docs/interchange.md)",
                count=len(points),
            )
        )
    if not np.linalg.norm(np.diff(outline, axis=0), axis=1).all():
        raise BadFile(Text("two neighbouring points of the outline are equal"))
    return Face(outline, eyes, mouth, source="points")


def own_points(face: Face) -> Array:
    """Return our 27 points of a face, shape (27, 2). Resamples outlines of other lengths."""
    outline = face.outline
    if len(outline) != OUTLINE_POINTS:
        outline = along(outline, OUTLINE_POINTS)
    return np.vstack([outline, face.eyes, face.mouth])


def along(line: Array, count: int) -> Array:
    """Return `count` evenly spaced points on the Catmull-Rom curve through a line (N, 2), N >= 2.

    Result (count, 2), with both ends of the line. Straight pieces would cut every bend: on an oval
    face, 21 points to 17 and back lose 1.5 % of the distance between the eyes.
    """
    ends = 2.0 * line[[0, -1]] - line[[1, -2]]
    around = np.vstack([ends[:1], line, ends[1:]])
    before, first, last, after = (around[k : len(around) - 3 + k, None] for k in range(4))
    t = (np.arange(_STEPS) / _STEPS)[:, None]
    pieces = first + t / 2.0 * (
        last - before
        + t * (2.0 * before - 5.0 * first + 4.0 * last - after)
        + t**2 * (3.0 * (first - last) + after - before)
    )  # fmt: skip
    return resampled(np.vstack([pieces.reshape(-1, 2), line[-1:]]), count)


def _text_of(data: bytes) -> str:
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
    lines = [line for line in _text_of(data).splitlines() if not line.lstrip().startswith("#")]
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


def parse_csv(data: bytes) -> list[Array]:
    """Parse a table with columns x and y, and optional columns face and point. Raises BadFile.

    Columns may be separated by semicolons; numbers then have a decimal comma. The names of
    `csv_text` in column point sort the rows. Result: (N, 2) per face, in order of the first rows.
    """
    try:
        text = _text_of(data)
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
    if by_name.keys() == set(_OWN_NAMES) and len(named) == len(_OWN_NAMES):
        return [by_name[name] for name in _OWN_NAMES]
    return [pair for _, pair in named]


def csv_text(faces: Sequence[Array]) -> str:
    """Return a table with one named row for each of the 27 points of each face."""
    rows: list[tuple[object, ...]] = [("face", "point", "x", "y")]
    for index, points in enumerate(faces, start=1):
        for name, (x, y) in zip(_OWN_NAMES, points.tolist(), strict=True):
            rows.append((index, name, f"{x:.3f}", f"{y:.3f}"))
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
