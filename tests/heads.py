"""Heads for the landmark search without networks: what a detector and a mesh see is computed."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import MeshSource
from kogao_core.faces.landmarks.blazeface import BlazeFace, Detection, Look, Square, _detection
from kogao_core.faces.landmarks.mesh import Mesh, MeshInput, MeshNetwork, _box
from kogao_core.faces.landmarks.outline import resampled
from kogao_core.faces.landmarks.pixels import Pyramid
from kogao_core.faces.landmarks.sources import template_face


@dataclasses.dataclass(frozen=True)
class Head:
    """A head in a photo, and how well the networks see it."""

    center: tuple[float, float] = (140.0, 130.0)  # px
    side: float = 40.0  # px
    degrees: float = 0.0
    score: float = 1.0  # of the detector, in a view four sides wide
    opposite: float = 0.0  # the same for the head upside down
    close: float = 1.0  # factor of the score in a close view
    presence: float = 4.0  # of the mesh, log-odds
    lift: float = -2.0  # change of the presence for the head upside down
    drift: float = 0.05  # share of a box's offset that a pass of the mesh keeps


_SMALL = Head(side=18.0)
_BEHIND = Head(side=18.0, center=(167.0, 130.0))
_FARTHER = Head(side=15.0, center=(177.0, 130.0), score=0.65)
# Heads in photos of 300 x 300 px. Each photo lies close to some limit of the search, so that half
# or twice the limit finds other faces: company, rolls, tiles, close views, upside-down faces,
# faces that touch, passes of the mesh.
ON_THE_BRINK: Final = (
    *([_SMALL, replace(_BEHIND, score=0.55, presence=one)] for one in (-0.8, -1.7)),
    *([_SMALL, replace(_BEHIND, score=one)] for one in (0.35, 0.45)),
    *([replace(_SMALL, degrees=one), _FARTHER] for one in (20.0, 45.0)),
    *([_SMALL, replace(_BEHIND, score=one), _FARTHER] for one in (0.2, 0.5)),
    *([Head(side=60.0, degrees=119.0, score=one)] for one in (0.57, 0.7)),
    *([Head(score=0.8, close=one)] for one in (0.09, 0.15)),
    [Head(side=18.0, score=0.62)],
    [Head(degrees=100.0, score=0.97, opposite=0.98, lift=-3.7)],
    [Head(presence=-1.7)],
    [Head(presence=-1.0), Head(center=(70.0, 220.0), degrees=180.0)],
    [Head(side=36.0, degrees=35.0), Head(side=33.0, center=(216.0, 130.0), score=0.55)],
    *(
        [Head(drift=0.3), Head(center=(140.0 + one, 130.0), drift=0.3)]
        for one in (20.0, 22.0, 26.0, 36.0, 44.0)
    ),
    *(
        [Head(degrees=180.0, score=0.95, presence=-0.46, opposite=one, lift=4.0)]
        for one in (0.55, 0.6)
    ),
    *([Head(side=70.0, degrees=one)] for one in (12.0, 25.0)),
    *([Head(drift=one)] for one in (0.035, 0.2, 0.3)),
)


class _Detector(BlazeFace):
    def __init__(self, heads: Sequence[Head]) -> None:
        self._heads = heads

    def look(self, _: Pyramid, view: Square, least_score: float, *, soft: bool = False) -> Look:
        boxes, most = [], 0.0
        for head in self._heads:
            tilt = abs((head.degrees - view.degrees + 180.0) % 360.0 - 180.0)
            apart = np.abs(head.center - view.center_px).max()
            sides = view.side_px / head.side
            if apart > view.side_px / 2.0 or not 1.0 < sides < 25.0:
                continue
            over = tilt > 120.0
            lean = 180.0 - tilt if over else tilt
            score = (head.opposite if over else head.score) * np.exp(-((lean / 90.0) ** 2))
            score *= np.exp(-((np.log(sides / 4.0) / 2.0) ** 2)) * (head.close if soft else 1.0)
            most = max(most, score)
            if score > least_score:
                boxes.append(_seen(head, view, score, over))
        return Look(sorted(boxes, key=lambda box: -box.score), most)


def _seen(head: Head, view: Square, score: float, over: bool) -> Detection:
    """Return the box that a network's output for this head gives."""
    turn = Affine.similarity(head.side, head.degrees + 180.0 * over, head.center)
    off = 0.1 * np.cos(view.side_px)  # a box differs a little from view to view
    frame = np.array([(off, 0), (-0.2, -0.2), (0.2, -0.2), (0, 0), (0, 0.2), (-0.4, 0), (0.4, 0)])
    center, *keypoints = view.to_image.inverse(turn(frame)) + 0.5
    side = head.side / view.to_image.scale
    return _detection(np.array([*center, side, side, *np.ravel(keypoints)]), view, score)


class _Network(MeshNetwork):
    def __init__(self, heads: Sequence[Head]) -> None:
        self._heads = heads

    def look(self, _: Pyramid, box: Detection) -> tuple[Mesh | None, MeshInput]:
        head = min(self._heads, key=lambda one: np.hypot(*(one.center - box.center_px)))
        over = abs((head.degrees - box.degrees + 180.0) % 360.0 - 180.0) > 90.0
        center = head.center + head.drift * (box.center_px - head.center)
        mesh = self._mesh(center, head, over, head.presence + head.lift * over)
        return mesh, MeshInput(np.array([mesh]), Affine.similarity(1.0, 0.0, (0.0, 0.0)))

    def look_mirrored(self, crop: MeshInput) -> Mesh | None:
        (mesh,) = crop.pixels
        return replace(mesh, eyes=mesh.eyes + 0.01, presence=mesh.presence - 0.1)

    def _mesh(self, center: Array, head: Head, over: bool, presence: float) -> Mesh:
        face = template_face(center, 0.9 * head.side, head.degrees + 180.0 * over)
        rim = resampled(2.0 * face.eye_center - face.outline[::-1], 15)
        box = _box(np.vstack([face.outline, rim]), face.eyes[3] - face.eyes[0])
        return Mesh(face.outline, face.eyes, face.mouth, rim, box, presence)


def found(heads: Sequence[Head]) -> list[Face]:
    """Return the faces that a `MeshSource` finds, as it searches with the real networks."""
    source = MeshSource(refined=False)
    vars(source).update(_detector=_Detector(heads), _network=_Network(heads))
    return source.find(np.zeros((300, 300), np.uint8))
