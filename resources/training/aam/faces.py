"""Training photographs, cropped to one upright face each."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.landmarks.aam.fitting import HALF_UNITS, UNIT_PX, Grey
from kogao_core.faces.landmarks.blazeface import Detection
from kogao_core.faces.landmarks.mesh import EYES
from kogao_core.faces.landmarks.pixels import Pyramid

from .detected import SURFACE, Networks, Seen, read
from .turned import FaceCrop

FOLDERS: Final = ("frll", "canada", "composites", "portraits", "headshots", "groups", "synthetic")
STUDIO: Final = ("frll", "canada", "composites")
_LEAST_UNIT_PX: Final = 24.0
# Crops with at least this correlation show the same face: the sheets repeat some faces. Crops of
# one face correlate by 0.93 and more, crops of two faces by less. Studio pictures of different
# people are more alike, but are not repeated.
_SAME: Final = 0.92
_SAME_PX: Final = 32
# The lower rows of this sheet repeat the faces of the first row with drawings over them.
_DRAWN_ON, _DRAWN_BELOW = "sheet05", 1.0 / 3.0


@dataclass(frozen=True, eq=False)
class Photographed:
    """One face, in px of its crop."""

    path: Path  # the photograph
    view: FaceCrop  # crop, mesh and keypoints
    box: Detection  # the detector's box
    to_photo: Affine  # maps the crop to the photograph
    labels: Array | None  # (189, 2): hand labels
    person: str  # the same for all pictures of one person, if known

    @property
    def folder(self) -> str:
        """Data set, such as ``"frll"``."""
        return self.path.parent.name


def photographed(data: Path) -> list[Photographed]:
    """Return the faces of all photographs in the shared folder, in a fixed order."""
    networks = Networks()
    faces: list[Photographed] = []
    for folder in FOLDERS:
        for path in sorted((data / folder).glob("*.jpg")):
            faces += _in_photograph(networks, path)
    return _with_people(faces)


def _in_photograph(networks: Networks, path: Path) -> Iterator[Photographed]:
    picture = Pyramid(read(path))
    seen = sorted(networks.faces(picture), key=lambda face: tuple(face.box.center_px))
    table = path.with_suffix(".csv")
    labels = np.loadtxt(table, delimiter=",", skiprows=1) if table.is_file() else None
    for face in seen:
        drawn_on = path.stem == _DRAWN_ON and (
            face.box.center_px[1] > _DRAWN_BELOW * picture.height
        )
        if not drawn_on and np.linalg.norm(_across(face)) >= _LEAST_UNIT_PX:
            yield _cut(path, picture, face, labels)


def _across(face: Seen) -> Array:
    return np.asarray(face.mesh[EYES[3], :2] - face.mesh[EYES[0], :2])


def _cut(path: Path, picture: Pyramid, face: Seen, labels: Array | None) -> Photographed:
    across = _across(face)
    unit, angle = float(np.linalg.norm(across)), float(np.arctan2(across[1], across[0]))
    side = 2 * round(HALF_UNITS * UNIT_PX) + 1
    turn = Affine.similarity(unit / UNIT_PX, float(np.degrees(angle)), (0.0, 0.0))
    middle = face.mesh[:SURFACE, :2].mean(axis=0)
    to_photo = Affine(turn.matrix, middle - turn(np.full(2, (side - 1) / 2.0)))
    rgb = picture.sample(to_photo, side, cv2.BORDER_REPLICATE)
    grey: Grey = np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.uint8)
    to_crop = to_photo.inverse
    assert face.box.keypoints_px is not None
    keypoints = to_crop(face.box.keypoints_px)
    mesh = np.column_stack([to_crop(face.mesh[:, :2]), face.mesh[:, 2] * to_crop.scale])
    box = Detection(
        to_crop(face.box.center_px),
        face.box.side_px * to_crop.scale,
        face.box.degrees - float(np.degrees(angle)),
        face.box.score,
        keypoints,
    )
    labelled = None if labels is None else to_crop(labels)
    person = f"{path.parent.name}/{path.stem.split('_')[0]}"
    return Photographed(path, FaceCrop(grey, mesh, keypoints), box, to_photo, labelled, person)


def _with_people(faces: Sequence[Photographed]) -> list[Photographed]:
    """Name the people of faces outside the studio; give copies of one face the same name."""
    named = list(faces)
    names: list[str] = []
    thumbs: list[Array] = []
    for place, face in enumerate(faces):
        if face.folder in STUDIO:
            continue
        thumb = _thumb(face.view.grey)
        alike = np.array(thumbs) @ thumb if thumbs else np.zeros(1)
        name = f"{face.folder}/{len(names)}" if alike.max() < _SAME else names[int(alike.argmax())]
        names.append(name)
        thumbs.append(thumb)
        named[place] = replace(face, person=name)
    return named


def _thumb(grey: Grey) -> Array:
    middle, half = grey.shape[0] // 2, round(1.375 * UNIT_PX)
    inner = grey[middle - half : middle + half, middle - half : middle + half]
    small = cv2.resize(inner, (_SAME_PX, _SAME_PX), interpolation=cv2.INTER_AREA)
    flat = small.astype(np.float64).ravel() - small.mean()
    return np.asarray(flat / max(1e-9, float(np.linalg.norm(flat))))


def once_each(faces: Sequence[Photographed]) -> list[Photographed]:
    """Drop copies: keep only the first picture of each face outside the studio."""
    seen: set[str] = set()
    kept = []
    for face in faces:
        if face.folder in STUDIO or face.person not in seen:
            kept.append(face)
        seen.add(face.person)
    return kept


def people_in(labels: Path, faces: Sequence[Photographed]) -> set[str]:
    """Return the people in a file of hand labels (``tests/labels/faces.json``)."""
    entries = json.loads(labels.read_text(encoding="utf-8"))["faces"]
    people = set()
    for entry in entries:
        for face in faces:
            if entry["file"] == f"{face.folder}/{face.path.name}" and _inside(face, entry):
                people.add(face.person)
    return people


def _inside(face: Photographed, entry: dict[str, list[float]]) -> bool:
    if "crop" not in entry:
        return True
    x, y, width, height = entry["crop"]
    across, down = face.to_photo(face.box.center_px)
    return bool(x <= across <= x + width and y <= down <= y + height)
