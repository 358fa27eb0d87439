"""``kogao-cli read``: measure how a retouch moved the faces of a photo."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from kogao_core.base.language import Text, tr, translated
from kogao_core.cli import common, ending, reading
from kogao_core.photo import Photo
from kogao_core.projects.project import Project, Sheet, save
from kogao_core.projects.sidecar import original
from kogao_core.reading import controls
from kogao_core.reading.controls import Match
from kogao_core.reading.flow import NotRead
from kogao_core.recipe import presets
from kogao_core.retouch import RetouchJob


def run(args: SimpleNamespace) -> None:
    """Run the command."""
    if len(args.inputs) % 2:
        raise ending.Stop("name photos in pairs: the original, then its retouched copy")
    if args.project_file is not None and len(args.inputs) > 2:
        raise ending.Stop("--project takes one pair")
    for report in (args.project_file, args.json_file):
        common.check_report(report, args.force)
    if args.style is not None:
        if args.style in presets.BUILT_IN:
            raise ending.Stop("{name} is a built-in preset; choose another name", name=args.style)
        with ending.stopping(ValueError, ending.USAGE):
            common.check_free(presets.file_of(presets.user_folder(), args.style), args.force)
    found = []
    for before, after in zip(args.inputs[::2], args.inputs[1::2], strict=True):
        photo = reading.read_photo(before, args.max_megapixels)
        found.append((photo, after, _matches(photo, after, args.max_megapixels, args.landmarks)))
    if args.project_file is not None:
        made = original(photo)
        sheet = Sheet(tuple(one.face for one in found[0][2]))
        with ending.writing(args.project_file):
            save(Project(made, "automatic", sheet), args.project_file)
    recipe, spread = controls.style([one.recipe for _, _, faces in found for one in faces])
    if args.style is not None:
        with ending.writing(presets.user_folder()):
            presets.add(presets.user_folder(), args.style, recipe)

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

    common.deliver(everything, table, args.json_file)


def _matches(
    photo: Photo, after: Path, max_megapixels: float, landmarks: str | None
) -> list[Match]:
    copy = reading.read_photo(after, max_megapixels)
    known = reading.find_faces(photo, landmarks)
    faces = reading.chosen(photo, known, RetouchJob()).faces
    try:
        return controls.match(photo.pixels, copy.pixels, faces)
    except NotRead as problem:
        why = Text("{after} can't be read: {problem}", after=after, problem=problem)
        raise ending.Stop(why, ending.NO_FACE) from problem
