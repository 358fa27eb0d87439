"""Formats of landmark files: one table, one parser for each format (docs/interchange.md).

A parser returns points as the file counts them; `Format.first_pixel` is the centre of the first
pixel.
"""

from __future__ import annotations

import csv
import io
import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from itertools import islice
from typing import Any, Final, NamedTuple
from xml.etree import ElementTree

import numpy as np

from kogao_core.additions.limits import MOST_LANDMARKS
from kogao_core.base import json_reader
from kogao_core.base.geometry import Array
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.faces.face import Face

MOST_BYTES: Final = 8 * 2**20
_MOST_FACES: Final = 1000
# The largest coordinate of a landmark, px.
_FARTHEST_PX: Final = 1e6
# More lines than a thousand faces need, with the line ends of Windows.
_MOST_LINES: Final = 400_000
_LONGEST_LINE: Final = 100_000
_LINE_ENDS: Final = re.compile("[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]")
MESH_COUNTS: Final = (468, 478)  # points of MediaPipe's face mesh
_PUPILS_FIRST: Final = 70  # points of WebMorph's dlib70: both pupils, then the 68
_MEDIAPIPE: Final = ("faceLandmarks", "face_landmarks", "multi_face_landmarks", "landmark")

# Name, x and y of a point as a file lists them.
Mark = tuple[Any, ...]


class Listed(NamedTuple):
    """Points of one face in a file."""

    points: list[Mark]
    photo: str = ""  # file name of the photo; "" if the file doesn't tell
    size: tuple[int, int] | None = None  # width and height of the photo, px


class Format(NamedTuple):
    """A format of landmark files."""

    title: str
    suffix: str
    fields: Sequence[str]  # one of these: a JSON field, a CSV column, the XML root; "" for all
    first_pixel: float  # coordinate of the centre of the first pixel
    parse: Callable[[Any], Sequence[Listed | Face]]


def text_of(data: bytes) -> str:
    """Decode a file without its byte order mark. Raises BadFile."""
    if len(data) > MOST_BYTES:
        raise BadFile("the file has more than {n} bytes, too many for landmarks", n=MOST_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise BadFile("the file is no text")
    start = 0
    ends = [*islice((end.start() for end in _LINE_ENDS.finditer(text)), _MOST_LINES + 1), len(text)]
    for end in ends:
        if len(ends) > _MOST_LINES + 1 or end - start > _LONGEST_LINE:
            raise BadFile("the file has too many lines, or too long ones, for landmarks")
        start = end
    return text


def coordinates(marks: Sequence[Mark]) -> Array:
    """Parse the coordinates of points. Result: (N, 2). Raises BadFile."""
    points = np.full((len(marks), 2), np.nan)
    for number, (_, *pair) in enumerate(marks, start=1):
        with suppress(TypeError, ValueError):
            points[number - 1] = [float(value) for value in pair]
        if not (np.abs(points[number - 1]) <= _FARTHEST_PX).all():
            text = shown(" ".join(map(str, pair)))
            raise BadFile("point {n} must be two numbers, got {text}", n=number, text=text)
    return points


def _rows(count: int, lines: Iterable[str]) -> list[Mark]:
    """Return unnamed points, one a line. Raises BadFile unless there are `count`."""
    rows = [("", *line.split()) for line in lines if line.strip()]
    if len(rows) != count:
        raise BadFile("the file says {n} points and has {found}", n=count, found=len(rows))
    return rows


# .pts: version, number of points, and the points in braces; rows that begin with # are comments.
_PTS: Final = re.compile(
    r"\s*version:\s*1(?:\.0)?\s+n_points:\s*(\d{1,5})\s*\{([^{}]*)\}\s*", re.ASCII
)


def _pts(text: str) -> list[Listed]:
    lines = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
    match = _PTS.fullmatch("\n".join(lines))
    if match is None:
        raise BadFile("the file must be 'version: 1', 'n_points: N' and the points in braces")
    return [Listed(_rows(int(match[1]), match[2].splitlines()))]


def _tem(text: str) -> list[Listed]:
    """Parse the number of points and the points; lines between points follow."""
    lines = text.splitlines()
    if not re.fullmatch(r"\s*\d{1,5}\s*", lines[0] if lines else "", re.ASCII):
        raise BadFile("the first line must be the number of points")
    count = int(lines[0])
    return [Listed(_rows(count, lines[1 : count + 1])[2 if count == _PUPILS_FIRST else 0 :])]


def _table(text: str) -> list[list[str]]:
    first = text.partition("\n")[0]
    sign = ";" if ";" in first else ","
    if "\t" in first and sign not in first:
        raise BadFile("its columns are separated by tabs; save it as CSV with commas")
    try:
        rows = [row for row in csv.reader(io.StringIO(text), delimiter=sign, strict=True) if row]
    except csv.Error as error:
        raise BadFile("the file is not a table ({error})", error=error) from None
    return [[name.strip().lower() for name in row] for row in rows[:1]] + rows[1:]


def _csv(table: list[list[str]]) -> list[Listed]:
    """Parse a table with columns x and y, and optional columns face and point.

    Numbers may have a decimal comma if semicolons separate the columns.
    """
    header = table[0] if table else []
    if header.count("x") != 1 or header.count("y") != 1:
        raise BadFile("the file's first row must name the columns x and y")
    if any(len(row) != len(header) for row in table[1:]):
        raise BadFile("every row must have {n} columns, like the first", n=len(header))
    faces = defaultdict[str, list[Mark]](list)
    for row in table[1:]:
        values = {"face": "", "point": ""} | dict(zip(header, map(str.strip, row), strict=True))
        x, y = (values[name].replace(",", ".") for name in ("x", "y"))
        faces[values["face"]].append((values["point"], x, y))
    return [Listed(points) for points in faces.values()]


def _size(width: object, height: object) -> tuple[int, int] | None:
    sides = [str(side) for side in (width, height)]
    return (int(sides[0]), int(sides[1])) if all(map(str.isdecimal, sides)) else None


def _labelme(top: Any) -> list[Listed]:
    """Return points and polylines, a face for each group."""
    groups = defaultdict[Any, list[Mark]](list)
    for shape in top["shapes"]:
        if shape["shape_type"] in ("point", "points", "line", "linestrip"):
            groups[shape.get("group_id")] += [(shape["label"], x, y) for x, y in shape["points"]]
    size = _size(top.get("imageWidth"), top.get("imageHeight"))
    return [Listed(points, str(top.get("imagePath", "")), size) for points in groups.values()]


def _coco(top: Any) -> list[Listed]:
    """Return the keypoints of each annotation; in COCO-WholeBody the 68 of the face."""
    images = {image["id"]: image for image in top["images"]}
    faces = []
    for one in top["annotations"]:
        image = images[one["image_id"]]
        flat = iter(one.get("face_kpts") or one["keypoints"])
        # A point without visibility has no position.
        marks = [
            ("", x, y) if seen else ("", "?", "")
            for x, y, seen in zip(flat, flat, flat, strict=True)
        ]
        size = _size(image.get("width"), image.get("height"))
        faces.append(Listed(marks, str(image["file_name"]), size))
    return faces


def _mediapipe(top: Any) -> list[Listed]:
    """Return points with fields x and y, as MediaPipe's results are written to JSON."""
    if isinstance(top, dict):
        top = next(top[name] for name in _MEDIAPIPE if name in top)
    faces = [top] if isinstance(top[0], dict) and "x" in top[0] else top
    lists = [face["landmark"] if isinstance(face, dict) else face for face in faces]
    return [Listed([("", point["x"], point["y"]) for point in points]) for points in lists]


def _cvat(top: ElementTree.Element) -> list[Listed]:
    """Return points and polylines, a face for each skeleton or group."""
    faces = []
    for image in top.iterfind("image"):
        groups = defaultdict[Any, list[Mark]](list)
        for shape in image:
            key = shape if shape.tag == "skeleton" else shape.get("group_id")
            for part in shape if shape.tag == "skeleton" else [shape]:
                if part.tag in ("points", "polyline"):
                    pairs = [pair.split(",") for pair in part.attrib["points"].split(";")]
                    groups[key] += [(part.attrib["label"], x, y) for x, y in pairs]
        size = _size(image.get("width"), image.get("height"))
        faces += [Listed(points, image.attrib["name"], size) for points in groups.values()]
    return faces


def _dlib(top: ElementTree.Element) -> list[Listed]:
    """Return the parts of each box."""
    return [
        Listed(
            [(part.attrib["name"], part.get("x"), part.get("y")) for part in box.iterfind("part")],
            image.attrib["file"],
            _size(image.get("width"), image.get("height")),
        )
        for image in top.iterfind("images/image")
        for box in image.iterfind("box")
        if len(box)
    ]


def _kogao(top: Any) -> list[Face]:
    """Return faces as `kogao-cli detect --json` and `landmarks export` write them."""
    if sum(len(face["outline"]) for face in top["faces"]) > MOST_LANDMARKS:
        raise BadFile("its faces have more than {n} landmarks together", n=MOST_LANDMARKS)
    faces = []
    for face in top["faces"]:
        outline, eyes, mouth = (
            coordinates([("", *pair) for pair in face[part]])
            for part in ("outline", "eyes", "mouth")
        )
        faces.append(Face(outline, eyes, mouth))
    return faces


# Positions from the corner of the photo have their first pixel's centre at 0.5. How each value was
# measured: docs/interchange.md.
FORMATS: Final = (
    Format("Kogao", ".json", ("faces",), 0.0, _kogao),
    Format("labelme", ".json", ("shapes",), 0.5, _labelme),
    Format("COCO", ".json", ("annotations",), 0.5, _coco),
    Format("MediaPipe", ".json", (*_MEDIAPIPE, ""), 0.0, _mediapipe),
    Format("CSV, ImageJ", ".csv", ("",), 0.0, _csv),
    Format("iBUG", ".pts", ("",), 1.0, _pts),
    Format("WebMorph", ".tem", ("",), 0.0, _tem),
    Format("CVAT", ".xml", ("annotations",), 0.5, _cvat),
    Format("dlib", ".xml", ("dataset",), 0.0, _dlib),
)
SUFFIXES: Final = tuple(dict.fromkeys(form.suffix for form in FORMATS))


def parse(data: bytes, suffix: str) -> tuple[Format, Sequence[Listed | Face]]:
    """Parse a landmark file; at least one face. Raises BadFile."""
    content, fields = _content(data, suffix)
    form = next((f for f in FORMATS if f.suffix == suffix and {*f.fields} & {*fields}), None)
    if form is None:
        raise BadFile(_advice(fields))
    try:
        faces = form.parse(content)
    except BadFile:
        raise
    except (AttributeError, LookupError, TypeError, ValueError):
        raise BadFile("it isn't as {program} writes it", program=form.title) from None
    if not 0 < len(faces) <= _MOST_FACES:
        raise BadFile("the file holds {count} faces", count=len(faces))
    return form, faces


def _content(data: bytes, suffix: str) -> tuple[Any, Collection[str]]:
    """Return the content of a file and the names of its fields, "" for none. Raises BadFile."""
    if suffix == ".json":
        top = json_reader.parse(data, MOST_BYTES).value
        first = top[0] if isinstance(top, list) and top else top
        if isinstance(first, dict) and first is not top and "x" not in first:
            raise BadFile(_advice(first))
        return top, top if isinstance(top, dict) else [""]
    text = text_of(data)
    if suffix == ".csv":
        table = _table(text)
        return table, ["", *(name.strip() for row in table[:1] for name in row)]
    if suffix != ".xml":
        return text, [""]
    if re.search("<!(DOCTYPE|ENTITY)", text):
        raise BadFile("landmarks need no XML with definitions")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise BadFile("the file is not XML ({error})", error=str(error)[:80]) from None
    return root, [root.tag]


def _advice(fields: Collection[str]) -> Text:
    """Return a sentence about content that no format has."""
    if "unit_px" in fields:
        return Text("it is a project; open it in the editor or use kogao-cli warp --project")
    return Text(
        "it has {fields} instead of landmarks; save points of other programs, such as Label "
        "Studio, as COCO or as a .csv file with columns x and y",
        fields=shown(", ".join(map(str, [*fields][:4]))),
    )
