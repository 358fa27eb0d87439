"""Import and export of landmarks: iBUG's .pts, CSV and JSON (docs/interchange.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from kogao_core.base import json_reader
from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Array, Box
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.faces.face import OUTLINE_POINTS, Face
from kogao_core.projects.interchange import formats
from kogao_core.projects.interchange.pointmap import (
    default_map,
    own_points,
)
from kogao_core.warp.limits import OutOfBounds, check_faces

__all__ = [
    "FORMATS",
    "Format",
    "Written",
    "check_inside",
    "file_for",
    "files",
    "own_points",
    "read",
    "write",
    "write_points",
]


@dataclass(frozen=True, slots=True)
class Format:
    """A file format for landmarks."""

    name: str  # suffix without the dot
    title: str
    holds_several: bool  # whether one file can hold several faces

    @property
    def suffix(self) -> str:
        """File suffix with the dot."""
        return f".{self.name}"


@dataclass(frozen=True, slots=True)
class Written:
    """A written file, with a note if the outline was resampled."""

    path: Path
    note: str


FORMATS: Final = {
    form.name: form
    for form in (
        Format("json", "JSON", holds_several=True),
        Format("csv", "CSV", holds_several=True),
        Format("pts", Text("iBUG points"), holds_several=False),
    )
}


def _format_of(path: Path) -> Format:
    """Return the format for the suffix of a path. Raises BadFile."""
    form = FORMATS.get(path.suffix.lower().removeprefix("."))
    if form is None:
        raise BadFile(
            Text(
                "{path} must end in one of {names}; save points of other programs as .csv with "
                "columns x and y",
                path=path,
                names=", ".join(f.suffix for f in FORMATS.values()),
            )
        )
    return form


def read(path: Path) -> list[Face]:
    """Read the faces of a landmark file, px of the photo; at least one. Raises BadFile."""
    form = _format_of(path)
    data = json_reader.read(path, formats.MOST_BYTES)
    try:
        if form.name == "json":
            return formats.parse_faces(data)
        sets = formats.parse_csv(data) if form.name == "csv" else [formats.parse_pts(data)]
        return [default_map(points).face(points) for points in sets]
    except BadFile as error:
        raise BadFile(Text("{path} can't be used: {error}", path=path, error=error)) from None


def write_points(points: Sequence[Array], path: Path) -> None:
    """Write the points (N, 2) of each face, in the format of the suffix (.csv or .pts)."""
    if _format_of(path).holds_several:
        atomic_write(formats.csv_text(points).encode(), path)
        return
    for one, file in zip(points, files(path, points), strict=True):
        atomic_write(formats.pts_text(one).encode(), file)


def file_for(photo: Path, place: Path) -> Path:
    """Return `place`, or the landmark file of a photo if `place` is a folder. Raises BadFile."""
    if not place.is_dir():
        return place
    candidates = [place / f"{photo.stem}{form.suffix}" for form in FORMATS.values()]
    file = next((file for file in candidates if file.is_file()), None)
    if file is None:
        raise BadFile(
            Text(
                "{folder} has no points for {photo}; expected {name} with one of {endings}",
                photo=photo.name,
                folder=place,
                name=photo.stem,
                endings=", ".join(form.suffix for form in FORMATS.values()),
            )
        )
    return file


def write(faces: Sequence[Face], path: Path) -> list[Written]:
    """Write faces in the format of the suffix. Raises BadFile.

    A format for one face gets one file per face: NAME.pts, NAME-2.pts and so on.
    """
    form = _format_of(path)
    if form.name == "json":
        atomic_write(formats.faces_text(faces).encode(), path)
        return [Written(path, "")]
    write_points([own_points(face) for face in faces], path)
    groups = [faces] if form.holds_several else [[face] for face in faces]
    return [Written(*pair) for pair in zip(files(path, faces), map(_note, groups), strict=True)]


def files(path: Path, faces: Sequence[object]) -> list[Path]:
    """Return the paths that `write` writes: one for each face, or one for all faces."""
    if _format_of(path).holds_several:
        return [path]
    rest = [path.with_name(f"{path.stem}-{n}{path.suffix}") for n in range(2, len(faces) + 1)]
    return [path, *rest]


def _note(faces: Sequence[Face]) -> str:
    if all(len(face.outline) == OUTLINE_POINTS for face in faces):
        return ""
    return Text("the outline was resampled to {count} points", count=OUTLINE_POINTS)


def check_inside(faces: Sequence[Face], image: Box) -> None:
    """Check that the middle of each face lies in the photo. Raises BadFile."""
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
