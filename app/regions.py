"""Where a face lies in the photo, as someone who clicks on it sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np

from kogao_core.face import Face
from kogao_core.geometry import Array

# The hairline lies about as far above the eyes as the mouth lies below them.
_FOREHEAD: Final = 1.0


def face_at(faces: Sequence[Face], at: Array, margin_px: float) -> int | None:
    """Return the face that a point lies deepest in, by the face's own measure.

    Parameters
    ----------
    faces : sequence of Face
        Px of the photo.
    at : array of shape (2,)
        The point, px of the photo.
    margin_px : float
        How far outside its rim a face still counts, px of the photo.
    """
    found, deepest = None, -np.inf
    for index, face in enumerate(faces):
        x, y = at.tolist()
        inside_px = cv2.pointPolygonTest(_rim(face), (x, y), measureDist=True)
        depth = inside_px / face.anchor.spacing_px
        if inside_px >= -margin_px and depth > deepest:
            found, deepest = index, depth
    return found


def _rim(face: Face) -> Array:
    """Return the hull of the landmarks and the forehead, which the outline leaves out."""
    up = face.eye_center - face.mouth_center
    hairline = face.eyes[[0, 3]] + _FOREHEAD * up
    points = np.concatenate([face.points, hairline]).astype(np.float32)
    return np.asarray(cv2.convexHull(points))
