"""``kogao-cli landmarks``: export landmarks to files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from kogao_core.base.language import Text, translated
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.projects import interchange


@words.group("landmarks")
def command() -> None:
    """Export landmarks for other programs.

    Import: warp --points. Formats: docs/interchange.md.
    """


@command.command("export")
@reading.takes_photos
@words.option(
    "--format", "form", type=click.Choice(tuple(interchange.FORMATS)), required=True,
    help="The format of detect --json, a table, or iBUG points",
)  # fmt: skip
@words.option(
    "-o", "--output", "folder", required=True, type=common.FOLDER, metavar="DIR",
    help="Output folder, created if missing; files are named after the photos",
)  # fmt: skip
@options.chooses_faces
@common.forces
def export(
    inputs: Sequence[Path],
    sample: bool,
    form: str,
    folder: Path,
    which: str,
    force: bool,
    landmarks: str | None,
    max_megapixels: float,
) -> int:
    """Find the faces in photos and write the landmarks."""
    photos = reading.input_paths(inputs, sample)
    targets = [_target(photo, folder, form) for photo in photos]
    twice = {target for target in targets if targets.count(target) > 1}
    if twice:
        raise ending.Stop(
            Text(
                "several photos would be written to {twice}; use separate folders",
                twice=min(twice),
            )
        )

    def write(photo: Path) -> None:
        target = _target(photo, folder, form)
        found = reading.find_faces(reading.read_photo(photo, max_megapixels), landmarks)
        faces = reading.selected(found, which)
        for file in interchange.files(target, faces):
            common.check_free(file, force)
        with ending.writing(target):
            folder.mkdir(parents=True, exist_ok=True)
            written = interchange.write(faces, target)
        for one in written:
            note = f" ({translated(one.note)})" if one.note else ""
            ending.print_text(f"{photo}: {one.path}{note}")

    return common.each(photos, write)


def _target(photo: Path, folder: Path, form: str) -> Path:
    return folder / f"{photo.stem}.{form}"
