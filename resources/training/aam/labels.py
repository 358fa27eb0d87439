"""The 80 points of a face, from hand labels or from a mesh corrected by hand labels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.face import OUTLINE_POINTS
from kogao_core.faces.landmarks import mesh as face_mesh
from kogao_core.faces.landmarks.aam.points import (
    EYE_LABELS,
    EYES,
    INNER_LABELS,
    MIRROR,
    OUTLINE_LABELS,
    similarity,
)
from kogao_core.faces.landmarks.outline import ended, resampled, silhouette

from .detected import SURFACE
from .faces import Photographed

_NEUTRAL, _SMILING = "_neutral", "_smiling"
MIRRORED_X: Final = np.array([-1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Labeller:
    """Converts a mesh to the 80 points; the correction is learnt from hand labels."""

    mean: Array  # (80, 2): mean hand-labelled face, one outer inter-ocular distance wide
    vertices: tuple[int, ...]  # the mesh point next to each inner point
    offset: Array  # (80, 2): from the mesh to the hand labels, mean, in the frame of `mean`
    personal: Mapping[str, Array]  # (80, 2): the same for each person with hand labels

    def points(self, mesh: Array, person: str) -> Array:
        """Return the 80 points of a mesh (478, 2 or more), corrected for this person."""
        raw = _raw(mesh, self.vertices)
        frame = similarity(self.mean, raw)
        return frame(frame.inverse(raw) + self.personal.get(person, self.offset))


def labeller(faces: Sequence[Photographed]) -> Labeller:
    """Learn the offset between meshes and hand labels, from the faces with hand labels.

    Other pictures of a person with hand labels get this person's own correction, so smiles are
    labelled nearly as by hand.
    """
    labelled = [face for face in faces if face.labels is not None]
    hand = [_by_hand(face) for face in labelled]
    units = [similarity(shape, _unit(shape)) for shape in hand]
    mean = np.mean([unit(shape) for unit, shape in zip(units, hand, strict=True)], axis=0)
    meshes = [
        unit(face.view.mesh[:SURFACE, :2]) for unit, face in zip(units, labelled, strict=True)
    ]
    mesh = np.mean(meshes, axis=0)
    inner = mean[OUTLINE_POINTS:]
    vertices = tuple(int(np.linalg.norm(mesh - point, axis=1).argmin()) for point in inner)
    personal = {}
    for face, shape in zip(labelled, hand, strict=True):
        raw = _raw(face.view.mesh, vertices)
        back = similarity(mean, raw).inverse
        personal[face.person] = back(shape) - back(raw)
    offset = np.mean(list(personal.values()), axis=0)
    return Labeller(mean, vertices, (offset + offset[MIRROR] * MIRRORED_X) / 2.0, personal)


def interocular(shape: Array) -> float:
    """Return the distance between the outer eye corners of a shape (80, 2)."""
    return float(np.linalg.norm(shape[EYES[3]] - shape[EYES[0]]))


def _unit(shape: Array) -> Array:
    return np.asarray((shape - shape.mean(axis=0)) / interocular(shape))


def _raw(mesh: Array, vertices: Sequence[int]) -> Array:
    outline = silhouette(mesh[:, :2], mesh[list(face_mesh.EYES), :2])
    return np.vstack([outline, mesh[list(vertices), :2]])


def _by_hand(face: Photographed) -> Array:
    assert face.labels is not None
    line = ended(face.labels[list(OUTLINE_LABELS)], face.labels[list(EYE_LABELS)])
    return np.vstack([resampled(line, OUTLINE_POINTS), face.labels[list(INNER_LABELS)]])
