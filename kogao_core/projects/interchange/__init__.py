"""Landmarks in and out: WebMorph's .tem, iBUG's .pts, CSV and JSON (docs/interchange.md)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from kogao_core.base import strict
from kogao_core.base.atomic import put
from kogao_core.base.geometry import Box
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.base.wording import shown
from kogao_core.faces.face import Face
from kogao_core.projects.interchange import formats
from kogao_core.projects.interchange.formats import PointSet
from kogao_core.projects.interchange.templates import TEMPLATES, Template, fitting, template
from kogao_core.warp.limits import OutOfBounds, check_faces

__all__ = [
    "FORMATS",
    "TEMPLATES",
    "Format",
    "PointSet",
    "Template",
    "Written",
    "check_inside",
    "file_for",
    "files",
    "read",
    "template",
    "write",
    "write_points",
]


@dataclass(frozen=True, slots=True)
class Format:
    """A kind of file."""

    name: str  # its ending, without the dot
    title: str  # what it is called
    several: bool  # whether one file holds several faces
    # Templates it can be written in, the usual one first; empty where it holds our own groups.
    templates: tuple[str, ...]

    @property
    def suffix(self) -> str:
        """Its ending."""
        return f".{self.name}"


@dataclass(frozen=True, slots=True)
class Written:
    """A file that was written, and what isn't in it or isn't ours."""

    path: Path
    note: str


FORMATS: Final = {
    form.name: form
    for form in (
        Format("json", "JSON", several=True, templates=()),
        Format("csv", "CSV", several=True, templates=("27", "68", "189")),
        Format("tem", Text("WebMorph template"), several=False, templates=("27", "189", "68")),
        Format("pts", Text("iBUG points"), several=False, templates=("68", "27", "189")),
    )
}
# What reads and writes those that hold one face.
_OF_ONE: Final[dict[str, tuple[Callable[[bytes], PointSet], Callable[[PointSet], str]]]] = {
    "tem": (formats.parse_tem, formats.tem_text),
    "pts": (formats.parse_pts, formats.pts_text),
}


def _format_of(path: Path) -> Format:
    """Return the format that a file's ending names; raise `BadFile` if none does."""
    form = FORMATS.get(path.suffix.lower().removeprefix("."))
    if form is None:
        raise BadFile(
            Text(
                "{path} must end in one of {names}",
                path=path,
                names=", ".join(f.suffix for f in FORMATS.values()),
            )
        )
    return form


def read(path: Path, mapping: Template | None = None) -> list[Face]:
    """Read the faces of a file of landmarks; its format follows from its ending.

    Result: at least one, px of the photo it was made on. Raises BadFile.
    """
    form = _format_of(path)
    data = strict.read(path, formats.MOST_BYTES)
    try:
        if form.name == "json":
            return formats.parse_faces(data)
        found = formats.parse_csv(data) if form.several else [_OF_ONE[form.name][0](data)]
        return [(mapping or fitting(points)).face(points) for points in found]
    except BadFile as error:
        raise BadFile(Text("{path} can't be used: {error}", path=path, error=error)) from None


def write_points(points: Sequence[PointSet], path: Path) -> None:
    """Write points as they are, in the format of the file's ending, one file a face if need be."""
    form = _format_of(path)
    if form.several:
        put(formats.csv_text([one.points for one in points]).encode(), path)
        return
    _, text_of = _OF_ONE[form.name]
    for one, file in zip(points, files(path, points), strict=True):
        put(text_of(one).encode(), file)


def file_for(photo: Path, place: Path) -> Path:
    """Return the file of a photo's points: `place`, or that of its name there. Raises BadFile."""
    if not place.is_dir():
        return place
    files = [place / f"{photo.stem}{form.suffix}" for form in FORMATS.values()]
    found = next((file for file in files if file.is_file()), None)
    if found is None:
        raise BadFile(
            Text(
                "there are no points of {photo} in {folder}: {name} with one of {endings}",
                photo=photo.name,
                folder=place,
                name=photo.stem,
                endings=", ".join(form.suffix for form in FORMATS.values()),
            )
        )
    return found


def write(faces: Sequence[Face], path: Path, wanted: str | None = None) -> list[Written]:
    """Write faces; a format that holds one gets a file each, numbered after the first.

    Result: each file, with what it doesn't hold. Raises BadFile.
    """
    form = _format_of(path)
    name = wanted or next(iter(form.templates), "")
    if name and name not in form.templates:
        own = Text("its own way")
        known = Text("templates of {names} points", names=", ".join(form.templates))
        raise BadFile(
            Text(
                "{format} is written in {form}, not in {name}",
                format=form.title,
                form=known if form.templates else own,
                name=shown(name),
            )
        )
    if form.name == "json":
        put(formats.faces_text(faces).encode(), path)
        return [Written(path, "")]
    template = TEMPLATES[name]
    write_points([template.points(face) for face in faces], path)
    told = [faces] if form.several else [[face] for face in faces]
    places = zip(files(path, faces), told, strict=True)
    return [Written(place, _note(template, within)) for place, within in places]


def files(path: Path, faces: Sequence[object]) -> list[Path]:
    """Return the files that `write` writes. Result: one for each face, or one for all."""
    if _format_of(path).several:
        return [path]
    rest = [path.with_name(f"{path.stem}-{n}{path.suffix}") for n in range(2, len(faces) + 1)]
    return [path, *rest]


def _note(template: Template, faces: Sequence[Face]) -> str:
    """Say what a file of this template doesn't know, in a sentence; empty where it holds all."""
    notes = []
    if any(len(face.outline) != len(template.outline) for face in faces):
        notes.append(
            Text("the outline was resampled to {count} points", count=len(template.outline))
        )
    guessed = (template.count or 0) - len(template.ours)
    if guessed:
        notes.append(
            Text(
                "{guessed} of {count} points are a mean face's, not this one's",
                guessed=guessed,
                count=template.count,
            )
        )
    return Text.joined("; ", notes)


def check_inside(faces: Sequence[Face], image: Box) -> None:
    """Check that faces lie on a photo; the photo's edge may crop them. Raises BadFile."""
    for number, face in enumerate(faces, start=1):
        x, y = face.middle
        if not (image.left <= x < image.right and image.top <= y < image.bottom):
            raise BadFile(
                Text(
                    "face {number} lies at {x:.0f}, {y:.0f}, outside the photo of "
                    "{width} x {height} px; the points belong to another photo or "
                    "size",
                    number=number,
                    x=x,
                    y=y,
                    width=image.width,
                    height=image.height,
                )
            )
    try:
        check_faces(faces, image, typed=True)
    except OutOfBounds as error:
        raise BadFile(str(error)) from None
