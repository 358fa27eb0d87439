"""``kogao-cli read``: measure how a retouch moved the faces of a photo."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from kogao_core.base.language import Text, tr, translated
from kogao_core.cli import common, ending, reading, words
from kogao_core.photo import Photo
from kogao_core.projects.project import Project, Sheet, save
from kogao_core.projects.sidecar import original
from kogao_core.reading import controls
from kogao_core.reading.controls import Match
from kogao_core.reading.flow import NotRead
from kogao_core.recipe import presets


@words.command("read")
@click.argument("inputs", nargs=-1, required=True, type=common.PHOTO, metavar="BEFORE AFTER...")
@words.option(
    "--project", "project_file", type=click.Path(path_type=Path), metavar="FILE",
    help="Write a project with the read outlines as targets, for warp --project.",
)  # fmt: skip
@words.option("--style", metavar="NAME", help="Save the median settings as a preset.")
@common.limits_megapixels
@reading.chooses_landmarks
@common.writes_json
@common.forces
def command(
    inputs: tuple[Path, ...],
    project_file: Path | None,
    style: str | None,
    max_megapixels: float,
    landmarks: str | None,
    json_file: Path | None,
    force: bool,
) -> None:
    """Measure how a retouch moved the faces of a photo.

    BEFORE is the original, AFTER its retouched copy; it may be cropped, resized or toned. Name more
    pairs to read a style.
    """
    if len(inputs) % 2:
        raise ending.Stop(Text("name photos in pairs: the original, then its retouched copy"))
    if project_file is not None and len(inputs) > 2:
        raise ending.Stop(Text("--project takes one pair"))
    for report in (project_file, json_file):
        common.check_report(report, force)
    if style is not None:
        if style in presets.BUILT_IN:
            raise ending.Stop(Text("{name} is a built-in preset; choose another name", name=style))
        with ending.stopping(ValueError, ending.USAGE):
            common.check_free(presets.file_of(presets.user_folder(), style), force)
    found = []
    for before, after in zip(inputs[::2], inputs[1::2], strict=True):
        photo = reading.read_photo(before, max_megapixels)
        found.append((photo, after, _matches(photo, after, max_megapixels, landmarks)))
    if project_file is not None:
        made = original(photo.path, reading.hash_of(photo.path), photo.pixels)
        sheet = Sheet(tuple(one.face for one in found[0][2]))
        with ending.writing(project_file):
            save(Project(made, "automatic", sheet), project_file)
    recipe, spread = controls.style([one.recipe for _, _, faces in found for one in faces])
    if style is not None:
        with ending.writing(presets.user_folder()):
            presets.add(presets.user_folder(), style, recipe)

    def everything() -> dict[str, Any]:
        pairs = [
            {
                "before": str(photo.path),
                "after": str(after),
                "faces": [one.to_dict() for one in faces],
            }
            for photo, after, faces in found
        ]
        return {"pairs": pairs, "style": {"settings": recipe.to_dict(), "spread": spread}}

    def table() -> str:
        lines = []
        for _, after, faces in found:
            lines.append(str(after))
            for number, one in enumerate(faces, 1):
                lines += [f"  {translated(line)}" for line in one.report(number)]
        if len(found) > 1:
            lines.append(tr("style: {settings}", settings=recipe.amount))
        return "\n".join(lines)

    common.deliver(everything, table, json_file)


def _matches(
    photo: Photo, after: Path, max_megapixels: float, landmarks: str | None
) -> list[Match]:
    copy = reading.read_photo(after, max_megapixels)
    known = reading.find_faces(photo, landmarks)
    faces = reading.chosen(photo, known, "all", doubtful=False).faces
    try:
        return controls.match(photo.pixels, copy.pixels, faces)
    except NotRead as problem:
        why = Text("{after} can't be read: {problem}", after=after, problem=problem)
        raise ending.Stop(why, ending.NO_FACE) from problem
