"""The card of a batch: one zip file of results and of what made them, to cite and to check."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final
from zipfile import ZipFile, ZipInfo

from kogao_core import __version__
from kogao_core.base.atomic import temporary_folder
from kogao_core.base.machine import machine, networks
from kogao_core.batch.measures import COLUMNS, table_text
from kogao_core.cli import licences
from kogao_core.photo.picture import sha256_of
from kogao_core.recipe.recipe import Recipe

_DATE: Final = (1980, 1, 1, 0, 0, 0)  # so that the same results make the same bytes
_POINTS: Final = ("picture", "face", "point", "x_px", "y_px", "result_x_px", "result_y_px")
_POINT: Final = (
    "px of the upright photo; 0,0 is the centre of the first pixel; points from 1: outline, eyes, "
    "mouth; result_x_px is before a change of size"
)


def write(file: Path, folder: Path, recipe: Recipe, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write the card of the results in a folder, from the rows of `measures_of`. Raises OSError."""
    photos = {Path(row["picture"]): Path(row["photo"]) for row in rows}
    names = {one: one.relative_to(folder).as_posix() for one in photos}
    measures, points = list[list[object]](), list[list[object]]()
    for row in rows:
        name = names[Path(row["picture"])]
        told = {**row, "picture": name, "photo": Path(row["photo"]).name}
        measures.append([told[column] for column in COLUMNS])
        found = enumerate(row.get("points", ()), start=1)
        points += [[name, row["face"], number, *places] for number, places in found]
    words = sorted({one for photo in photos.values() for one in photo.parent.glob("LICEN[CS]E*")})
    card = {
        "program": f"Kogao {__version__}",
        **{name: machine()[name] for name in ("python", "packages")},
        "networks": networks(),
        "pictures": [
            {"name": names[one], "sha256": sha256_of(one),
             "photo": photo.name, "photo_sha256": sha256_of(photo)}
            for one, photo in photos.items()
        ],
    }  # fmt: skip
    content: dict[str, str | Path] = {
        "card.json": json.dumps(card, indent=1),
        "recipe.json": json.dumps(recipe.to_dict(), indent=1),
        "measures.csv": table_text([list(COLUMNS), *measures]),
        "landmarks.csv": table_text([_POINTS, *points]),
        "codebook.csv": table_text([("column", "meaning"), *COLUMNS.items(), ("x_px", _POINT)]),
        "licences-of-kogao.txt": licences.text(),
        **{f"photos/{one.name}": one for one in words},
        **{f"pictures/{name}": one for one, name in names.items()},
    }
    file.parent.mkdir(parents=True, exist_ok=True)
    with temporary_folder(file.parent) as place:
        fresh = place / "card.zip"
        with ZipFile(fresh, "w") as zipped:
            for name, one in content.items():
                data = (
                    one.read_bytes()
                    if isinstance(one, Path)
                    else one.encode(errors="backslashreplace")
                )
                zipped.writestr(ZipInfo(name, _DATE), data)
        fresh.replace(file)
