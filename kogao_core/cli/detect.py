"""``kogao-cli detect``: where the faces and their 27 points are."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kogao_core.cli import common
from kogao_core.cli import json_file as to_json

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kogao_core.face import Face
    from kogao_core.photo import Photo


@click.command("detect")
@common.takes_photo
@to_json.writes_json
@common.forces
def command(
    source: Path | None,
    sample: bool,
    max_megapixels: float,
    landmarks: str | None,
    json_file: Path | None,
    force: bool,
) -> None:
    """Find the faces in the photo IN.

    Positions are pixels of the upright photo, counted from the centre of its first pixel.
    """
    to_json.check(json_file, force)
    photo = common.read_photo(common.input_path(source, sample), max_megapixels)
    faces = common.find_faces(photo, landmarks)
    to_json.deliver(lambda: _found(photo, faces), lambda: _table(photo, faces), json_file)


def _found(photo: Photo, faces: Sequence[Face]) -> dict[str, Any]:
    return {
        "image": {"width": photo.width, "height": photo.height},
        "faces": [face.to_dict() for face in faces],
    }


def _table(photo: Photo, faces: Sequence[Face]) -> str:
    size = f"{photo.width} x {photo.height} px"
    lines = [f"{photo.path}: {size}, {common.count_of_faces(len(faces))}"]
    lines.append("face  score      x      y  width  height  tilt")
    for number, face in enumerate(faces, start=1):
        x, y, width, height = face.box
        across = face.eyes[3] - face.eyes[0]
        tilt = math.degrees(math.atan2(across[1], across[0]))
        lines.append(
            f"{number:4}  {face.score:5.2f}  {x:5.0f}  {y:5.0f}  {width:5.0f}  {height:6.0f}"
            f"  {tilt:+3.0f}°"
        )
    return "\n".join(lines)
