"""``kogao-cli experiment figures``: draw the paper's figures of any photo."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from kogao_core.base.atomic import atomic_write
from kogao_core.base.display import png
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.lab.experiments.figures import figures as drawings_of
from kogao_core.lab.subjects import Subject


def _subject(path: Path, given: Mapping[str, Any]) -> Subject:
    photo = reading.read_photo(path, given["max_megapixels"])
    faces = reading.find_faces(photo, given["landmarks"], given["points"])
    return Subject(path.name, photo.pixels, tuple(reading.selected(faces, given["which"])))


@words.command("figures")
@options.takes_photos
@words.option(
    "-o", "--output", "folder", required=True, type=common.FOLDER, metavar="DIR",
    help="Output folder, created if missing; files are named after the photos.",
)  # fmt: skip
@words.option(
    "--width", "width_px", type=click.IntRange(240, 8000), default=960, show_default=True,
    metavar="PX", help="Width of each figure.",
)  # fmt: skip
@options.chooses_percent
@options.chooses_as_the_paper
@common.forces
def figures(folder: Path, width_px: int, force: bool, **given: Any) -> int:
    """Draw the paper's figures of photos.

    Lattice (2), landmarks and targets (4, 5), directions (6), centre candidates (7), domains (14,
    15), before and after (16). Pictures are cropped to 4 : 3 around the faces.
    """
    recipe = options.paper_recipe_of(given["recipe_file"], given["percent"])
    photos = reading.input_paths(given["inputs"], given["sample"], named=True)

    def draw(photo: Path) -> None:
        drawings = drawings_of(_subject(photo, given), recipe, width_px)
        targets = {folder / f"{photo.stem}-{one.name}.png": one for one in drawings}
        for path in targets:
            common.check_free(path, force)
        with ending.writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            for path, drawing in targets.items():
                atomic_write(png(drawing.painted()), path)
        ending.print_text(f"{photo}: {', '.join(path.name for path in targets)}")

    return common.each(photos, draw)
