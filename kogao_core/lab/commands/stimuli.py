"""``kogao-cli experiment stimuli``: faces at several doses, with all that a study needs of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from kogao_core.base.language import Text, tr
from kogao_core.base.wording import shown
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.lab.stimuli import (
    STIMULI,
    Posed,
    Stimulus,
    Wanted,
    doses,
    files_of,
    finish,
    written,
)


def _percents(_: click.Context, __: click.Parameter, value: str) -> tuple[float, ...]:
    try:
        return doses(value)
    except ValueError as error:
        raise words.bad_value(error.args[0]) from None


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
    stems = [photo.stem for photo in photos]
    if len(set(stems)) < len(stems):
        twice = next(stem for stem in stems if stems.count(stem) > 1)
        raise ending.Stop(
            Text("several photos are called {twice}; give those their own folder", twice=twice),
            ending.USAGE,
        )
    for photo in photos:
        for file in files_of(photo, percents, folder):
            common.check_free(file, force)
    rows: list[list[Stimulus]] = []

    def make(path: Path) -> None:
        posed = _posed(path, landmarks, max_megapixels, which)
        with ending.writing(folder):
            rows.append(written(posed, wanted, folder, form))
        ending.print_text(f"{path}: {', '.join(f'{one.name}.png' for one in rows[-1])}")

    code = common.each(photos, make)
    if rows:
        with ending.writing(folder):
            finish(rows, folder)
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
