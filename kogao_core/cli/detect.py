"""``kogao-cli detect``: where the faces and their 27 points are."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from kogao_core.cli import common

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kogao_core.face import Face
    from kogao_core.photo import Photo


@click.command("detect")
@common.takes_photo
@click.option("--json", "as_json", is_flag=True, help="Print all landmarks as JSON.")
def command(
    source: Path | None, sample: bool, max_megapixels: float, landmarks: str | None, as_json: bool
) -> None:
    """Find the faces in the photo IN.

    Positions are pixels of the upright photo, counted from the centre of its first pixel.
    """
    photo = common.read_photo(common.input_path(source, sample), max_megapixels)
    faces = common.find_faces(photo, landmarks)
    if as_json:
        found = {
            "image": {"width": photo.width, "height": photo.height},
            "faces": [face.to_dict() for face in faces],
        }
        click.echo(json.dumps(found))
    else:
        click.echo(_table(photo, faces))


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
