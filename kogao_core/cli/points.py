"""Landmarks from a file in place of a search, as `warp` takes them."""

from __future__ import annotations

from pathlib import Path

import click

from kogao_core.base.geometry import Box
from kogao_core.base.strict import BadFile
from kogao_core.cli import ending, reading, words
from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.photo import Photo
from kogao_core.projects import interchange

takes_points = words.together(
    words.option(
        "--points", "points_file", type=click.Path(path_type=Path), metavar="FILE",
        excludes=("--landmarks",),
        help="Take the landmarks from a .tem, .pts, .csv or .json file instead of looking for "
        "faces.",
    ),
    words.option(
        "--points-map", metavar="MAP", needs="--points",
        help="Which of the file's points are outline/eyes/mouth, such as 0-16/36,39,42,45/48,54 "
        "[by their number: 27, 68 or 189].",
    ),
)  # fmt: skip


def faces(
    photo: Photo,
    file: Path | None,
    mapping: str | None,
    landmarks: str | None,
    known: LandmarkSource | None,
) -> list[Face]:
    """Return the faces of a file of points, or find them where there is none."""
    if file is None:
        return reading.find_faces(photo, landmarks, known)

    with ending.stopping(ValueError, ending.USAGE):
        template = None if mapping is None else interchange.template(mapping)
    with ending.stopping(BadFile, ending.UNREADABLE):
        found = interchange.read(file, template)
        interchange.check_inside(found, Box.of(photo.pixels))
    return found
