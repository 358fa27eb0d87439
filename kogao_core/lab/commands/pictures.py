"""``kogao-cli experiment figures`` and ``stimuli``: pictures of any photo, in a folder."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import click

from kogao_core.base.atomic import put
from kogao_core.base.language import Text, tr
from kogao_core.base.wording import shown
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.lab.experiments.figures import figures as drawings_of
from kogao_core.lab.stimuli import (
    STIMULI,
    Export,
    Mask,
    Posed,
    Stimulus,
    Wanted,
    doses,
    files_of,
    finish,
    written,
)
from kogao_core.lab.subjects import Subject

_KINDS: Final = ("png", "svg")
_writes_pictures = words.option(
    "-o", "--output", "folder", required=True, type=common.FOLDER, metavar="DIR",
    help="A folder for the pictures, which are called after the photos; made if need be.",
)  # fmt: skip


def _photos(given: Mapping[str, Any]) -> list[Path]:
    """Return the photos to read; stop where pictures of two would have one name."""
    photos = reading.input_paths(given["inputs"], given["sample"])
    (stem, count), *_ = Counter(photo.stem for photo in photos).most_common(1)
    if count > 1:
        raise ending.Stop(
            Text("several photos are called {twice}; give those their own folder", twice=stem),
            ending.USAGE,
        )
    return photos


def _posed(path: Path, given: Mapping[str, Any]) -> Posed:
    photo = reading.read_photo(path, given["max_megapixels"])
    known = reading.points_of(photo)
    if known is None:
        faces = reading.find_faces(photo, given["landmarks"])
        return Posed(photo, tuple(reading.selected(faces, given["which"])))
    chosen = reading.selected([face for face, _ in known], given["which"])
    points = tuple(points for face, points in known if any(face is one for one in chosen))
    return Posed(photo, tuple(chosen), points)


@words.command("figures")
@reading.takes_photos
@_writes_pictures
@words.option("--format", "kinds", type=click.Choice((*_KINDS, "both")), default="png",
              show_default=True)  # fmt: skip
@words.option(
    "--width", "width_px", type=click.IntRange(240, 8000), default=960, show_default=True,
    metavar="PX", help="Width of each figure.",
)  # fmt: skip
@options.chooses_percent
@options.chooses_as_the_paper
@common.forces
def figures(folder: Path, kinds: str, width_px: int, force: bool, **given: Any) -> int:
    """Draw the paper's figures of photos.

    Landmarks and targets (4, 5), directions (6), centre candidates (7), lattice (2), one point (1),
    control points of two (3), small, large and four lattices (8 to 10), domains (12 to 15), before
    and after (16), cut to the paper's 4 : 3 round the faces.
    """
    recipe = options.paper_recipe_of(given["recipe_file"], given["percent"])
    photos = _photos(given)

    def draw(photo: Path) -> None:
        posed = _posed(photo, given)
        drawings = drawings_of(
            Subject(photo.name, posed.photo.pixels, posed.faces), recipe, width_px
        )
        targets = {
            folder / f"{photo.stem}-{drawing.name}.{kind}": (drawing, kind)
            for drawing in drawings
            for kind in (_KINDS if kinds == "both" else (kinds,))
        }
        for path in targets:
            common.check_free(path, force)
        with ending.writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            for path, (drawing, kind) in targets.items():
                put(drawing.png() if kind == "png" else drawing.svg(), path)
        ending.print_text(f"{photo}: {', '.join(path.name for path in targets)}")

    return common.each(photos, draw)


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
@_writes_pictures
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
    "--field", "exports", type=click.Choice(["tfm", "evidence"]), multiple=True,
    help="Write the displacement, too: ITK's B-spline transform, or an evidence file (.npz) with "
    "displacement, lattices and domains; repeatable.",
)  # fmt: skip
@words.option(
    "--format", "form", type=click.Choice(["csv", "pts"]), default="csv",
    show_default=True, help="Of the points of each picture.",
)  # fmt: skip
@options.chooses_as_the_paper
@common.forces
def stimuli(
    folder: Path,
    percents: tuple[float, ...],
    size: tuple[int, int] | None,
    mask: Mask | None,
    exports: tuple[Export, ...],
    form: str,
    force: bool,
    **given: Any,
) -> int:
    """Make each photo's faces smaller and larger, by exactly the doses asked for.

    Beside each picture lie its points: those of --points, all of them moved, or the 27 found.
    measures.csv tells what each face asked for, achieved and measures; contact.png shows all.
    """
    recipe = options.recipe_of(given["recipe_file"], {}, STIMULI)
    wanted = Wanted(percents, recipe, size, mask, exports)
    photos = _photos(given)
    for photo in photos:
        for file in files_of(photo, percents, folder):
            common.check_free(file, force)
    rows: list[list[Stimulus]] = []

    def make(path: Path) -> None:
        posed = _posed(path, given)
        with ending.writing(folder):
            rows.append(written(posed, wanted, folder, form))
        ending.print_text(f"{path}: {', '.join(f'{one.name}.png' for one in rows[-1])}")

    code = common.each(photos, make)
    if rows:
        with ending.writing(folder):
            finish(rows, folder)
        ending.print_text(tr("{folder}: measures.csv, contact.png", folder=folder))
    return code
