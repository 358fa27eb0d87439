"""``kogao-cli experiment stimuli``: faces at several doses, with all that a study needs of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from kogao_core.base.atomic import put
from kogao_core.base.language import Text, tr
from kogao_core.base.wording import shown
from kogao_core.batch import measures
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.lab.stimuli import (
    STIMULI,
    Posed,
    Stimulus,
    Wanted,
    png_names,
    png_of,
    sheet,
    stimuli,
)
from kogao_core.projects import interchange
from kogao_core.recipe.settings import SETTINGS


def _percents(_: click.Context, __: click.Parameter, value: str) -> tuple[float, ...]:
    try:
        percents = tuple(float(part) for part in value.split(","))
        for percent in percents:
            SETTINGS["percent"].check(percent)
    except ValueError:
        raise words.bad_value(
            Text("{value} must be doses within -15..15, such as -8,-4,0,4,8.", value=shown(value))
        ) from None
    return tuple(dict.fromkeys(percents))


def _size(_: click.Context, __: click.Parameter, value: str | None) -> tuple[int, int] | None:
    if value is None:
        return None
    width, height = (*value.split("x"), "")[:2]
    if not (width.isdecimal() and height.isdecimal() and 64 <= int(width) <= 8000
            and 64 <= int(height) <= 8000):  # fmt: skip
        raise words.bad_value(
            Text("{value} is no size such as 900x1200, of 64 to 8000 px.", value=shown(value))
        )
    return int(width), int(height)


@words.command("stimuli")
@reading.takes_photos
@words.option(
    "-o", "--output", "folder", required=True, type=common.FOLDER, metavar="DIR",
    help="A folder; made if need be. Pictures are called PHOTO_DOSE.png.",
)  # fmt: skip
@words.option(
    "--percents", callback=_percents, default="-8,-4,0,4,8", show_default=True,
    metavar="P,P,...", help="Doses, in % of D; below 0 faces get larger.",
)  # fmt: skip
@words.option(
    "--align", "size", callback=_size, metavar="WxH",
    help="Turn, scale and shift each photo so that its first face's eyes lie at one place.",
)  # fmt: skip
@words.option(
    "--mask", type=click.Choice(["oval", "outline"]),
    help="Leave transparent what lies outside an oval round each face, or its outline.",
)  # fmt: skip
@words.option(
    "--field", "exports", type=click.Choice(["tfm", "npz", "maps"]), multiple=True,
    help="Write the displacement, too: ITK's B-spline transform, a dense array, or the maps of "
    "OpenCV's remap; repeatable.",
)  # fmt: skip
@words.option(
    "--format", "form", type=click.Choice(["tem", "pts", "csv"]), default="tem",
    show_default=True, help="Of the points of each picture.",
)  # fmt: skip
@options.chooses_as_the_paper
@common.forces
def command(
    inputs: Sequence[Path],
    sample: bool,
    folder: Path,
    percents: tuple[float, ...],
    size: tuple[int, int] | None,
    mask: str | None,
    exports: tuple[str, ...],
    form: str,
    recipe_file: Path | None,
    which: str,
    force: bool,
    landmarks: str | None,
    max_megapixels: float,
) -> int:
    """Make each photo's faces smaller and larger, by exactly the doses asked for.

    Beside each picture lie its points: those of --points, all of them moved, or the 27 found.
    measures.csv tells what each face asked for, achieved and measures; contact.png shows all.
    """
    recipe = options.recipe_of(recipe_file, {}, STIMULI)
    wanted = Wanted(percents, recipe, size, mask, exports)  # type: ignore[arg-type]  # click's
    photos = reading.input_paths(inputs, sample)
    names = [name for photo in photos for name in png_names(photo, percents)]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ending.Stop(
            Text("several photos would be written to {twice}; give those their own folder",
                 twice=folder / twice), ending.USAGE,
        )  # fmt: skip
    table = folder / "measures.csv"
    for file in (*(folder / name for name in names), table, folder / "contact.png"):
        common.check_free(file, force)
    common.check_free(measures.codebook_of(table), force)
    records: list[dict[str, Any]] = []
    rows: list[list[Stimulus]] = []

    def make(path: Path) -> None:
        posed = _posed(path, landmarks, max_megapixels, which)
        row = []
        with ending.writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            for one in stimuli(posed, wanted):
                _write(one, folder, form, posed.photo.icc_profile)
                records.extend(one.records)
                row.append(dataclasses.replace(one, files={}))
        rows.append(row)
        ending.print_text(f"{path}: {', '.join(f'{one.name}.png' for one in row)}")

    code = common.each(photos, make)
    if records:
        with ending.writing(folder):
            measures.write(records, table)
            put(sheet(rows), folder / "contact.png")
        ending.print_text(tr("{folder}: measures.csv, contact.png", folder=folder))
    return code


def _posed(path: Path, landmarks: str | None, max_megapixels: float, which: str) -> Posed:
    photo = reading.read_photo(path, max_megapixels)
    known = reading.points_of(photo)
    if known is None:
        faces = reading.selected(reading.find_faces(photo, landmarks), which)
        return Posed(photo, tuple(faces))
    chosen = reading.selected([face for face, _ in known], which)
    points = tuple(points for face, points in known if any(face is one for one in chosen))
    return Posed(photo, tuple(chosen), points)


def _write(one: Stimulus, folder: Path, form: str, icc_profile: bytes | None) -> None:
    put(png_of(one, icc_profile), folder / f"{one.name}.png")
    points = one.points or [interchange.TEMPLATES["27"].points(face) for face in one.faces]
    interchange.write_points(points, folder / f"{one.name}.{form}")
    for ending_, data in one.files.items():
        put(data, folder / f"{one.name}{ending_}")
