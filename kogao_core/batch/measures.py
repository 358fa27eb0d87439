"""Table of requested and achieved warp distances and lengths per face, with a codebook."""

from __future__ import annotations

import csv
import dataclasses
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from kogao_core.base.atomic import atomic_write
from kogao_core.base.wording import printable
from kogao_core.faces.face import Face
from kogao_core.field.measures import asked_percent, measures, moved
from kogao_core.pipeline import Rendering

_DIGITS: Final = 6  # decimals
# Name and meaning of each column.
COLUMNS: Final = {
    "picture": "file of the result",
    "photo": "file of the source photo",
    "face": "number of the face in the photo, from 1",
    "asked_percent": "requested move of the targets towards the centre, % of D; below 0: larger",
    "achieved_percent": "achieved move of the landmarks towards the centre, % of D",
    "center": "centre candidate",
    "lattice": "lattice spacing R, in the unit of the recipe",
    "fit": "fit of the lattice: approximation, exact or multilevel",
    "width_px": "width of the outline, px of the photo",
    "jaw_px": "width at the height of the mouth corners, px",
    "area_px2": "area inside the outline, px squared",
    "interocular_px": "distance between the outer eye corners, px",
    "jaw_to_eyes": "jaw_px divided by interocular_px",
    "width_change_percent": "change of width_px, %",
    "jaw_change_percent": "change of jaw_px, %",
    "area_change_percent": "change of area_px2, %",
    "smallest_det_sampled": "smallest det J of 8 x 8 samples per cell; 0 or less is a fold",
    "one_to_one_proven": "1 if the absence of folds is proven",
    "share_let_through": "fraction of the displacement that the guard allowed",
}


def measured(
    picture: str, photo: str, rendering: Rendering, faces: Sequence[Face]
) -> list[dict[str, Any]]:
    """Return one row of the table for each warped face.

    Beside the columns, `points` has x and y, px, of each landmark before and after.
    """
    rows = []
    pairs = zip(faces, rendering.pairs, rendering.achieved, rendering.shares, strict=True)
    for number, (face, pair, achieved, share) in enumerate(pairs, start=1):
        recipe = rendering.recipe.of_face(face.recipe)
        result = moved(face, rendering.field, pair)
        before, after = measures(face), measures(result)
        row = {
            "picture": picture,
            "photo": photo,
            "face": number,
            "asked_percent": asked_percent(pair),
            "achieved_percent": achieved,
            "center": recipe.center,
            "lattice": recipe.lattice,
            "fit": recipe.fit,
            **dataclasses.asdict(after),
            "jaw_to_eyes": after.jaw_to_eyes,
            "width_change_percent": _change(before.width_px, after.width_px),
            "jaw_change_percent": _change(before.jaw_px, after.jaw_px),
            "area_change_percent": _change(before.area_px2, after.area_px2),
            "smallest_det_sampled": rendering.one_to_one.min_det,
            "one_to_one_proven": int(rendering.one_to_one.certified),
            "share_let_through": share,
            "points": np.hstack([face.points, result.points]).round(2).tolist(),
        }
        rows.append({name: _rounded(value) for name, value in row.items()})
    return rows


def _change(before: float, after: float) -> float:
    return 100.0 * (after / before - 1.0)


def _rounded(value: object) -> object:
    return round(value, _DIGITS) + 0.0 if isinstance(value, float) else value  # -0.0 is 0.0


def codebook_of(file: Path) -> Path:
    """Return the path of the codebook of a table."""
    return file.with_name(f"{file.stem}-codebook.csv")


def write(rows: Iterable[Mapping[str, Any]], file: Path) -> None:
    """Write a table and its codebook: CSV in UTF-8, decimal points, 1 for true."""
    told = [("column", "meaning"), *COLUMNS.items()]
    lines = [list(COLUMNS), *([row[name] for name in COLUMNS] for row in rows)]
    file.parent.mkdir(parents=True, exist_ok=True)
    for table, to in ((lines, file), (told, codebook_of(file))):
        atomic_write(
            table_text(table).encode(errors="backslashreplace"), to
        )  # names may be invalid text


def table_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as CSV text; None becomes an empty field.

    Text that a spreadsheet would take for a formula gets an apostrophe in front.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(_cell, row) for row in rows)
    return text.getvalue()


def _cell(value: object) -> object:
    if not isinstance(value, str):
        return value
    value = printable(value)
    is_formula = value.startswith(("=", "+", "-", "@")) and not _is_number(value)
    return f"'{value}" if is_formula else value


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
