"""What each face of each picture asked for, achieved and measures: one table, and its codebook."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from kogao_core.base.atomic import put
from kogao_core.faces.face import Face
from kogao_core.pipeline import Rendering
from kogao_core.warp.measures import asked_percent, measures, moved

_DIGITS: Final = 6  # behind the point
# The columns, and what each one means.
COLUMNS: Final = {
    "picture": "the picture's file",
    "photo": "the file that it was made of",
    "face": "number of the face in the photo, from 1",
    "asked_percent": "how far the targets lie towards the centre, % of D; below 0 larger",
    "achieved_percent": "how far the landmarks came there, % of D",
    "center": "centre candidate",
    "lattice": "lattice spacing R, as the recipe's unit says",
    "fit": "how the lattice takes up the moves",
    "width_px": "width of the outline, px of the photo",
    "jaw_px": "width at the height of the mouth's corners, px",
    "area_px2": "area inside the outline, px squared",
    "interocular_px": "between the outer corners of the eyes, px",
    "jaw_to_eyes": "jaw_px in shares of interocular_px",
    "width_change_percent": "change of width_px, %",
    "jaw_change_percent": "change of jaw_px, %",
    "area_change_percent": "change of area_px2, %",
    "smallest_det_sampled": "least det J of 8 x 8 samples a cell; below 1 stretch, at 0 a fold",
    "one_to_one_proven": "1 where it is proven that nothing folds",
    "share_let_through": "share of the displacement that the guard let through",
}


def measured(
    picture: str, photo: str, rendering: Rendering, faces: Sequence[Face]
) -> list[dict[str, Any]]:
    """Return a row of the table for each face that was warped."""
    rows = []
    pairs = zip(faces, rendering.pairs, rendering.achieved, rendering.shares, strict=True)
    for number, (face, pair, achieved, share) in enumerate(pairs, start=1):
        recipe = rendering.recipe.of_face(face.recipe)
        before, after = measures(face), measures(moved(face, rendering.field, pair))
        row = {
            "picture": picture,
            "photo": photo,
            "face": number,
            "asked_percent": asked_percent(pair),
            "achieved_percent": achieved,
            "center": recipe.center,
            "lattice": recipe.lattice,
            "fit": recipe.fit,
            "width_px": after.width_px,
            "jaw_px": after.jaw_px,
            "area_px2": after.area_px2,
            "interocular_px": after.interocular_px,
            "jaw_to_eyes": after.jaw_to_eyes,
            "width_change_percent": _change(before.width_px, after.width_px),
            "jaw_change_percent": _change(before.jaw_px, after.jaw_px),
            "area_change_percent": _change(before.area_px2, after.area_px2),
            "smallest_det_sampled": rendering.one_to_one.min_det,
            "one_to_one_proven": int(rendering.one_to_one.certified),
            "share_let_through": share,
        }
        rows.append({name: _rounded(value) for name, value in row.items()})
    return rows


def _change(before: float, after: float) -> float:
    return 100.0 * (after / before - 1.0)


def _rounded(value: object) -> object:
    return round(value, _DIGITS) + 0.0 if isinstance(value, float) else value  # -0.0 is 0.0


def codebook_of(file: Path) -> Path:
    """Return where the codebook of a table lies."""
    return file.with_name(f"{file.stem}-codebook.csv")


def write(rows: Iterable[Mapping[str, Any]], file: Path) -> None:
    """Write a table and its codebook: CSV in UTF-8, a point before decimals, 1 for yes."""
    told = [("column", "meaning"), *COLUMNS.items()]
    lines = [list(COLUMNS), *([row[name] for name in COLUMNS] for row in rows)]
    file.parent.mkdir(parents=True, exist_ok=True)
    for table, to in ((lines, file), (told, codebook_of(file))):
        put(table_text(table).encode(errors="backslashreplace"), to)  # names may be no text at all


def table_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as CSV for any program: an empty field where there is nothing."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()
