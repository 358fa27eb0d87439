"""``kogao-cli landmarks``: points for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from kogao_core.cli import common, options, words
from kogao_core.language import Text, translated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kogao_core.face import Face

_FORMATS: Final = ("tem", "pts", "csv", "json")
_TEMPLATES: Final = ("27", "68", "189")


@words.group("landmarks")
def command() -> None:
    """Give landmarks to other programs.

    Theirs come in by warp --points. docs/interchange.md says what each format holds of ours.
    """


@command.command("export")
@common.takes_photos
@words.option(
    "--format", "form", type=click.Choice(_FORMATS), required=True,
    help="WebMorph, iBUG, a table, or what detect --json writes.",
)  # fmt: skip
@words.option(
    "--template", type=click.Choice(_TEMPLATES),
    help="How many points [tem, csv: 27, ours alone; pts: 68; the rest is a mean face's].",
)  # fmt: skip
@words.option(
    "-o", "--output", "folder", required=True, type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR", help="A folder; made if need be. Files take the photos' names.",
)  # fmt: skip
@options.chooses_faces
@common.forces
def export(
    inputs: Sequence[Path],
    sample: bool,
    form: str,
    template: str | None,
    folder: Path,
    which: str,
    force: bool,
    landmarks: str | None,
    max_megapixels: float,
) -> int:
    """Find the faces of photos and write their landmarks."""
    photos = common.input_paths(inputs, sample)
    targets = _targets(photos, folder, form)
    if template is not None and form == "json":
        raise common.Stop(Text("JSON holds our own points; leave --template out"), common.USAGE)
    code = 0
    for photo, target in zip(photos, targets, strict=True):
        try:
            found = common.find_faces(common.read_photo(photo, max_megapixels), landmarks)
            _write(photo, common.selected(found, which), target, template, force)
        except common.Stop as stop:
            if len(photos) == 1:
                raise
            common.print_message(stop.message)
            code = common.SOME_FAILED
    return code


def _targets(photos: Sequence[Path], folder: Path, form: str) -> list[Path]:
    targets = [folder / f"{photo.stem}.{form}" for photo in photos]
    twice = {target for target in targets if targets.count(target) > 1}
    if twice:
        raise common.Stop(
            Text(
                "several photos would be written to {twice}; give those their own folder",
                twice=min(twice),
            ),
            common.USAGE,
        )
    return targets


def _write(
    photo: Path, faces: Sequence[Face], target: Path, template: str | None, force: bool
) -> None:
    from kogao_core import interchange

    for file in interchange.files(target, faces):
        common.check_free(file, force)
    with common.writing(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        written = interchange.write(faces, target, template)
    for one in written:
        note = f" ({translated(one.note)})" if one.note else ""
        common.print_text(f"{photo}: {one.path}{note}")
