"""What each face of each picture asked for, achieved and measures: one table, and its codebook."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from kogao_core.base.atomic import put
from kogao_core.faces.face import Face
from kogao_core.pipeline import Rendering
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.measures import FaceMeasures, asked_percent, measures, moved

_DIGITS: Final = 6  # behind the point


@dataclass(frozen=True, slots=True, eq=False)
class _Row:
    """One face of one picture."""

    picture: str
    photo: str
    number: int  # of the face, from 1
    rendering: Rendering
    recipe: Recipe  # the face's
    before: FaceMeasures
    after: FaceMeasures

    def of_all(self, values: Sequence[float]) -> float:
        """Return the face's own of the values of all."""
        return values[self.number - 1]

    def change(self, name: str) -> float:
        """Return by how much a length or an area has changed, %."""
        before, after = (float(getattr(one, name)) for one in (self.before, self.after))
        return 100.0 * (after / before - 1.0)


_Value = Callable[[_Row], object]
# The columns: what each one means, and how a row fills it.
COLUMNS: Final[Mapping[str, tuple[str, _Value]]] = {
    "picture": ("the picture's file", lambda row: row.picture),
    "photo": ("the file that it was made of", lambda row: row.photo),
    "face": ("number of the face in the photo, from 1", lambda row: row.number),
    "asked_percent": (
        "how far the targets lie towards the centre, % of D; below 0 larger",
        lambda row: asked_percent(row.rendering.pairs[row.number - 1]),
    ),
    "achieved_percent": (
        "how far the landmarks came there, % of D",
        lambda row: row.of_all(row.rendering.achieved),
    ),
    "center": ("centre candidate", lambda row: row.recipe.center),
    "lattice": ("lattice spacing R, as the recipe's unit says", lambda row: row.recipe.lattice),
    "fit": ("how the lattice takes up the moves", lambda row: row.recipe.fit),
    "width_px": ("width of the outline, px of the photo", lambda row: row.after.width_px),
    "jaw_px": ("width at the height of the mouth's corners, px", lambda row: row.after.jaw_px),
    "area_px2": ("area inside the outline, px squared", lambda row: row.after.area_px2),
    "interocular_px": (
        "between the outer corners of the eyes, px",
        lambda row: row.after.interocular_px,
    ),
    "jaw_to_eyes": ("jaw_px in shares of interocular_px", lambda row: row.after.jaw_to_eyes),
    "width_change_percent": ("change of width_px, %", lambda row: row.change("width_px")),
    "jaw_change_percent": ("change of jaw_px, %", lambda row: row.change("jaw_px")),
    "area_change_percent": ("change of area_px2, %", lambda row: row.change("area_px2")),
    "smallest_det_sampled": (
        "least det J of 8 x 8 samples a cell; below 1 stretch, at 0 a fold",
        lambda row: row.rendering.one_to_one.min_det,
    ),
    "one_to_one_proven": (
        "1 where it is proven that nothing folds",
        lambda row: int(row.rendering.one_to_one.certified),
    ),
    "share_let_through": (
        "share of the displacement that the guard let through",
        lambda row: row.of_all(row.rendering.shares),
    ),
}


def measured(
    picture: str, photo: str, rendering: Rendering, faces: Sequence[Face]
) -> list[dict[str, Any]]:
    """Return a row of the table for each face that was warped."""
    records = []
    pairs = zip(faces, rendering.pairs, strict=True)
    for number, (face, pair) in enumerate(pairs, start=1):
        after = measures(moved(face, rendering.field, pair))
        recipe = rendering.recipe.of_face(face.recipe)
        row = _Row(picture, photo, number, rendering, recipe, measures(face), after)
        values = ((name, value(row)) for name, (_, value) in COLUMNS.items())
        records.append({name: _rounded(value) for name, value in values})
    return records


def _rounded(value: object) -> object:
    return round(value, _DIGITS) + 0.0 if isinstance(value, float) else value  # -0.0 is 0.0


def codebook_of(file: Path) -> Path:
    """Return where the codebook of a table lies."""
    return file.with_name(f"{file.stem}-codebook.csv")


def write(rows: Iterable[Mapping[str, Any]], file: Path) -> None:
    """Write a table and its codebook: CSV in UTF-8, a point before decimals, 1 for yes."""
    told = [("column", "meaning"), *((name, meaning) for name, (meaning, _) in COLUMNS.items())]
    lines = [list(COLUMNS), *([row[name] for name in COLUMNS] for row in rows)]
    file.parent.mkdir(parents=True, exist_ok=True)
    for table, to in ((lines, file), (told, codebook_of(file))):
        put(table_text(table).encode(errors="backslashreplace"), to)  # names may be no text at all


def table_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as CSV for any program: an empty field where there is nothing."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()
