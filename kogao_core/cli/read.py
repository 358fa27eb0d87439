"""``kogao-cli read``: measure how a retouch moved the faces of a photo."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import click

from kogao_core.base.geometry import Box
from kogao_core.base.language import Text, tr, translated
from kogao_core.cli import common, ending, reading, words
from kogao_core.photo import Photo
from kogao_core.projects.project import Project, Sheet, save
from kogao_core.projects.sidecar import original
from kogao_core.reading import controls
from kogao_core.reading.controls import ControlFit
from kogao_core.reading.displacement import Reading, read_faces
from kogao_core.reading.flow import NotRead
from kogao_core.recipe import presets

_Read = list[tuple[Reading, ControlFit]]


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
    pairs = list(zip(inputs[::2], inputs[1::2], strict=False))
    if len(inputs) % 2:
        raise ending.Stop(Text("name photos in pairs: the original, then its retouched copy"))
    if project_file is not None and len(pairs) > 1:
        raise ending.Stop(Text("--project takes one pair"))
    common.check_report(project_file, force)
    common.check_report(json_file, force)
    if style is not None:
        with ending.stopping(ValueError, ending.USAGE):
            target = presets.file_of(presets.user_folder(), style)
        if style in presets.BUILT_IN:
            raise ending.Stop(
                Text("{style} is a built-in preset; choose another name", style=style)
            )
        common.check_free(target, force)
    found = [(pair, *_read(*pair, max_megapixels, landmarks)) for pair in pairs]
    if project_file is not None:
        _, photo, faces = found[0]
        _write_project(photo, faces, project_file)
    recipe, spread = controls.style([one for _, _, faces in found for _, one in faces])
    if style is not None:
        with ending.writing(target):
            presets.add(presets.user_folder(), style, recipe)

    def everything() -> dict[str, Any]:
        return {
            "pairs": [
                {
                    "before": str(before),
                    "after": str(after),
                    "faces": [{**one.to_dict(), "settings": near.to_dict()} for one, near in faces],
                }
                for (before, after), _, faces in found
            ],
            "style": {"settings": recipe.to_dict(), "spread": spread},
        }

    def table() -> str:
        lines = []
        for (_, after), _, faces in found:
            lines.append(str(after))
            for number, (one, near) in enumerate(faces, 1):
                lines += [f"  {translated(line)}" for line in controls.report(number, one, near)]
        if len(found) > 1:
            lines.append(tr("style: {settings}", settings=recipe.amount))
        return "\n".join(lines)

    common.deliver(everything, table, json_file)


def _read(
    before: Path, after: Path, max_megapixels: float, landmarks: str | None
) -> tuple[Photo, _Read]:
    photo, copy = (reading.read_photo(path, max_megapixels) for path in (before, after))
    known = reading.find_faces(photo, landmarks)
    faces = reading.chosen(photo, known, "all", doubtful=False).faces
    try:
        read = read_faces(photo.pixels, copy.pixels, faces)
    except NotRead as problem:
        why = Text("{after} can't be read: {problem}", after=after, problem=problem)
        raise ending.Stop(why, ending.NO_FACE) from problem
    return photo, [(one, controls.fit_controls(one, Box.of(photo.pixels))) for one in read]


def _write_project(photo: Photo, faces: _Read, file: Path) -> None:
    targets = tuple(dataclasses.replace(one.targets, recipe=near.recipe) for one, near in faces)
    made = original(photo.path, reading.hash_of(photo.path), photo.pixels)
    with ending.writing(file):
        save(Project(made, "automatic", Sheet(targets)), file)
