"""Landmarks as tables: CSV for a spreadsheet, JSON as ``kogao-cli detect --json`` prints it.

Both count pixel centres from 0, y down, and hold any number of faces.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile, Node
from kogao_core.base.strict import parse as parse_json
from kogao_core.base.wording import shown
from kogao_core.faces.face import Face
from kogao_core.projects.interchange.points import (
    FARTHEST_PX,
    MOST_BYTES,
    MOST_POINTS,
    PointSet,
    coordinates,
    number,
    text_of,
)
from kogao_core.projects.interchange.templates import OWN_NAMES
from kogao_core.warp.limits import MOST_LANDMARKS

_MOST_FACES: Final = 1000
_TOLD: Final = 4  # fields of a file of others


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
    return [PointSet(coordinates(_in_order(points))) for points in faces.values()]


def _in_order(named: list[tuple[str, list[str]]]) -> list[list[str]]:
    """Return pairs in the order that their names tell, if these are ours; else as they are."""
    by_name = dict(named)
    for names in (OWN_NAMES, numbered(len(named))):
        if len(by_name) == len(named) and by_name.keys() == set(names):
            return [by_name[name] for name in names]
    return [pair for _, pair in named]


def numbered(count: int) -> list[str]:
    """Return the names of points that have none of their own: how many precede each.

    Result: from 0.
    """
    return [str(k) for k in range(count)]


def csv_text(faces: Sequence[Array], names: Sequence[str]) -> str:
    """Write a row for each point of each face, shape (N, 2), with its name.

    Result: the file, with its header.
    """
    with io.StringIO(newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(("face", "point", "x", "y"))
        for index, points in enumerate(faces, start=1):
            for name, (x, y) in zip(names, points.tolist(), strict=True):
                writer.writerow((index, name, number(x), number(y)))
        return out.getvalue()


def parse_faces(data: bytes) -> list[Face]:
    """Read what `faces_text` or ``kogao-cli detect --json`` wrote.

    Result: at least one. Raises BadFile.
    """
    top = parse_json(data, MOST_BYTES)
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
            fields=shown(", ".join(list(found)[:_TOLD])),
        )
    )


def _face(node: Node) -> Face:
    outline, eyes, mouth = (_points(node.field(name)) for name in ("outline", "eyes", "mouth"))
    try:
        return Face(outline, eyes, mouth)
    except ValueError as error:
        node.refuse(Text("is no face: {error}", error=error))


def _points(node: Node) -> Array:
    rows = [row.items(2) for row in node.items(MOST_POINTS)]
    if any(len(row) != 2 for row in rows):
        node.refuse(Text("must be pairs of numbers"))
    pairs = [[value.number(-FARTHEST_PX, FARTHEST_PX) for value in row] for row in rows]
    return np.array(pairs).reshape(-1, 2)


def faces_text(faces: Sequence[Face]) -> str:
    """Write faces to the last bit. Result: JSON."""
    return json.dumps({"faces": [face.to_dict() for face in faces]}, indent=1) + "\n"
