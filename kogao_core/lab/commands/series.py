"""``kogao-cli experiment series``: photos of one person brought to one result."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from kogao_core.base.language import Text
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.cli.progress import ProgressLine
from kogao_core.lab import series
from kogao_core.lab.reports.report import translated_report
from kogao_core.photo import CannotWrite
from kogao_core.recipe.recipe import Recipe


@words.command("series")
@reading.takes_photos
@words.option(
    "-o", "--output", "folder", required=True, type=common.FOLDER, metavar="DIR",
    help="A folder; made if need be. Pictures take the photos' names and their amounts.",
)  # fmt: skip
@options.chooses_percent
@words.option(
    "--recipe", "recipe_file", type=click.Path(path_type=Path), metavar="FILE",
    help="A saved recipe (JSON).",
)  # fmt: skip
@common.forces
def command(
    inputs: Sequence[Path],
    sample: bool,
    folder: Path,
    percent: float | None,
    recipe_file: Path | None,
    force: bool,
    landmarks: str | None,
    max_megapixels: float,
) -> int:
    """Bring photos of one person, as you say, to one result.

    Each gets the amount at which its jaw, in shares of the distance between the eyes, is as wide as
    in the median photo after --percent. Heads that are turned too far are left out. series.csv
    tells what each photo gets.
    """
    recipe = options.recipe_of(recipe_file, {"percent": percent}, Recipe())
    photos = reading.input_paths(inputs, sample)
    if folder.is_dir() and any(folder.iterdir()) and not force:
        raise ending.Stop(
            Text("{folder} isn't empty; choose another, or --force to replace files in it",
                 folder=folder), ending.USAGE,
        )  # fmt: skip
    source = reading.landmark_source(landmarks)
    given = reading.point_files()[0] is not None
    progress = ProgressLine()
    progress.begin(str(folder))
    with (
        ending.stopping(CannotWrite, ending.UNREADABLE),
        ending.writing(folder),
        ending.stopping(ValueError, ending.NO_FACE),
    ):
        brought, left_out = series.one_result(
            photos, folder, recipe, source, force=force, progress=progress.step,
            max_megapixels=max_megapixels,
            find=(lambda photo: reading.find_faces(photo, landmarks)) if given else None,
        )  # fmt: skip
    progress.end()
    for sentence in left_out:
        ending.print_message(sentence)
    ending.print_text(translated_report(series.report(brought, recipe)).text())
    return ending.SOME_FAILED if left_out else 0
