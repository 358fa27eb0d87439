"""``kogao-cli experiment figures``: the paper's figures of any photo."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import click

from kogao_core.base.atomic import put
from kogao_core.base.language import Text
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.lab.experiments.figures import figures
from kogao_core.lab.reports.drawing import Drawing
from kogao_core.lab.subjects import Subject

_KINDS: Final = ("png", "svg")


@words.command("figures")
@reading.takes_photos
@words.option(
    "-o", "--output", "folder", required=True, type=common.FOLDER, metavar="DIR",
    help="A folder; made if need be. Files are called PHOTO-FIGURE.png.",
)  # fmt: skip
@words.option("--format", "kinds", type=click.Choice((*_KINDS, "both")), default="png",
              show_default=True)  # fmt: skip
@words.option(
    "--width", "width_px", type=click.IntRange(240, 8000), default=960, show_default=True,
    metavar="PX", help="Width of each figure.",
)  # fmt: skip
@options.chooses_percent
@options.chooses_as_the_paper
@common.forces
def command(
    inputs: Sequence[Path],
    sample: bool,
    folder: Path,
    kinds: str,
    width_px: int,
    percent: float | None,
    recipe_file: Path | None,
    which: str,
    force: bool,
    landmarks: str | None,
    max_megapixels: float,
) -> int:
    """Draw the paper's figures of photos.

    Landmarks and targets (4, 5), directions (6), centre candidates (7), lattice (2), one point (1),
    control points of two (3), small, large and four lattices (8 to 10), domains (12 to 15), before
    and after (16), cut to the paper's 4 : 3 round the faces.
    """
    recipe = options.paper_recipe_of(recipe_file, percent)
    photos = reading.input_paths(inputs, sample)
    stems = [photo.stem for photo in photos]
    twice = {stem for stem in stems if stems.count(stem) > 1}
    if twice:
        raise ending.Stop(
            Text("several photos are called {twice}; draw them apart", twice=min(twice)),
            ending.USAGE,
        )

    def draw(photo: Path) -> None:
        read = reading.read_photo(photo, max_megapixels)
        faces = reading.selected(reading.find_faces(read, landmarks), which)
        drawings = figures(Subject(photo.name, read.pixels, tuple(faces)), recipe, width_px)
        written = _write(drawings, photo, folder, _KINDS if kinds == "both" else (kinds,), force)
        ending.print_text(f"{photo}: {', '.join(path.name for path in written)}")

    return common.each(photos, draw)


def _write(
    drawings: Sequence[Drawing], photo: Path, folder: Path, kinds: Sequence[str], force: bool
) -> list[Path]:
    targets = {
        folder / f"{photo.stem}-{drawing.name}.{kind}": (drawing, kind)
        for drawing in drawings
        for kind in kinds
    }
    for path in targets:
        common.check_free(path, force)
    with ending.writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for path, (drawing, kind) in targets.items():
            put(drawing.png() if kind == "png" else drawing.svg(), path)
    return list(targets)
