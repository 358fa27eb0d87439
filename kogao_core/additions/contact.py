"""Heads that touch: who is in front, and how far each head reaches.

Inside the head in front only its own displacement counts. The head behind shrinks about a point
near the line of contact, and its displacement rises from nothing at that line. A person who isn't
shrunk counts like a head that doesn't move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array, smoothstep
from kogao_core.faces.face import Face
from kogao_core.faces.head import HeadFrame
from kogao_core.faces.reshape import across

# A face is surely in front of another that is smaller by this factor, or higher in the photo by
# this many distances from the eyes to the chin. Larger values call more pairs of heads equal.
_LARGER: Final = 1.35
_LOWER: Final = 1.8
# A head with ears and hair, in sizes of its face: up, down, and to the sides of a frontal head. On
# the side away from which a head is turned, ear and hair add so much per turn.
_UP: Final = 1.65
_DOWN: Final = 1.05
_SIDE: Final = 1.22
_TURNED: Final = 0.6
_LEAST_SIDE: Final = 1.05
_ROUND: Final = 0.05  # width over which that limit sets in
# A forehead that nobody marked: above the middle of the face and above the ends of its outline, in
# distances from the mouth to the eyes.
_ARCH: Final = (1.3, 0.6)


@dataclass(frozen=True, slots=True, eq=False)
class OtherHead:
    """A head beside another, as corners in order, px."""

    face_px: Array  # (K, 2)
    head_px: Array  # (L, 2), ears and hair included
    ahead: float  # 0: beside or behind the other, 1: in front of it
    still: bool  # it isn't shrunk


def ahead(faces: Sequence[Face]) -> Array:
    """Return how far each head is in front of each other, (K, K); 0 if beside it or behind."""
    larger = np.log([face.anchor.spacing_px for face in faces]) / np.log(_LARGER)
    heights = np.array([HeadFrame.of(face).height_px for face in faces])
    lower = np.array([face.eye_center[1] for face in faces]) / _LOWER
    apart = (lower[:, None] - lower) / ((heights[:, None] + heights) / 2.0)
    return smoothstep(larger[:, None] - larger + apart)


def face_corners(face: Face) -> Array:
    """Return the corners of a face in order, (K, 2), px."""
    return _hull(face.points if face.forehead is None else np.vstack([face.points, face.forehead]))


def head_corners(face: Face) -> Array:
    """Return the corners of a head with ears and hair in order, (K, 2), px; about."""
    right, up = across(face), face.eye_center - face.mouth_center
    top = face.forehead
    if top is None:
        top = np.vstack([face.middle + _ARCH[0] * up, face.outline[[0, -1]] + _ARCH[1] * up])
    axes = np.stack([right, (-right[1], right[0])])
    aside, down = ((np.vstack([face.outline, top]) - face.middle) @ axes.T).T
    one, other = (face.outline[[0, -1]] - face.eye_center) @ right
    turn = float((one + other) / max(1e-9, abs(other - one)))
    wide = _SIDE + _TURNED * turn * np.sign(aside) - _LEAST_SIDE
    wide = _LEAST_SIDE + 0.5 * (wide + np.hypot(wide, _ROUND))
    ends = np.where(down > 0.0, _DOWN, _UP)
    return _hull(face.middle + np.column_stack([aside * wide, down * ends]) @ axes)


def beyond(points: Array, hull: Array) -> Array:
    """Return about how far points are outside a hull, px; 0 or less within."""
    outward, offsets_px = _sides(hull.tobytes())
    return np.asarray((points @ outward.T - offsets_px).max(axis=1))


@lru_cache(1024)
def _sides(corners: bytes) -> tuple[Array, Array]:
    """Return the normals of the sides of a hull, (K, 2), and their distances from 0, 0, px."""
    hull = np.frombuffer(corners).reshape(-1, 2)
    along = np.roll(hull, -1, axis=0) - hull
    outward = np.column_stack([along[:, 1], -along[:, 0]])
    outward /= np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-12)[:, None]
    if (outward * (hull - hull.mean(axis=0))).sum() < 0.0:
        outward = -outward
    return outward, (hull * outward).sum(axis=1)


def _hull(points: Array) -> Array:
    corners: Array = cv2.convexHull(points.astype(np.float32))[:, 0].astype(np.float64)
    return corners
