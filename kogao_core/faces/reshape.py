"""Moves the outline of a face by hand: neighbours follow a landmark, and so may the other side."""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.face import Face

# Nearer to the midline than this, in landmark spacings, a landmark belongs to both sides.
MIDDLE: Final = 0.25


def across(face: Face) -> Array:
    """Return the direction across the midline, shape (2,), to the right of an upright head."""
    down = face.mouth_center - face.eye_center
    down = down / max(1e-12, float(np.linalg.norm(down)))
    return np.array([down[1], -down[0]])


def reflection(face: Face) -> Affine:
    """Return the mirroring at the midline, through the middle of the eyes and of the mouth."""
    normal, on_midline = across(face), face.eye_center
    matrix = np.eye(2) - 2.0 * np.outer(normal, normal)
    return Affine(matrix, on_midline - matrix @ on_midline)


def opposite(face: Face, index: int) -> int | None:
    """Return the landmark across the midline that is nearest to where landmark `index` mirrors to.

    Result: None for a landmark on the midline, and where there is none on the other side.
    """
    sides = (face.outline - face.eye_center) @ across(face)
    if abs(sides[index]) < MIDDLE * face.anchor.spacing_px:
        return None
    beyond = np.flatnonzero(sides * sides[index] < 0.0)
    if not beyond.size:
        return None
    away = face.outline[beyond] - reflection(face)(face.outline[index])
    return int(beyond[np.argmin(np.linalg.norm(away, axis=1))])


def influence(outline: Array, index: int, reach_px: float) -> Array:
    """Return how far each landmark follows landmark `index`: half a cosine wave along the outline.

    Result (N,): 1 at the landmark, 0.5 half way, 0 from `reach_px` on.
    """
    steps = np.linalg.norm(np.diff(outline, axis=0), axis=1)
    along = np.append(0.0, np.cumsum(steps))
    away = np.abs(along - along[index])
    near = np.clip(away / max(reach_px, 1e-12), 0.0, 1.0)
    weights = 0.5 * (1.0 + np.cos(np.pi * near))
    weights[near >= 1.0] = 0.0  # the cosine of pi is not quite -1 for every near
    weights[index] = 1.0
    return np.asarray(weights)


def moved(
    face: Face, index: int, to: npt.ArrayLike, reach_px: float = 0.0, *, symmetric: bool = False
) -> Face:
    """Return the face with a landmark of its outline moved, and what follows it.

    `to` (2,) px. Result: sure of that landmark; the lattice anchor stays.
    """
    changed = face.with_outline_point(index, to)
    mirror = opposite(face, index) if symmetric else None
    if reach_px <= 0.0 and mirror is None:
        return changed
    by = np.asarray(to, np.float64) - face.outline[index]
    here = influence(face.outline, index, reach_px)
    if mirror is None:
        move = here[:, None] * by
    else:
        there = influence(face.outline, mirror, reach_px)
        move = _blended(here, by, there, reflection(face).matrix @ by)
    outline = face.outline + move
    outline[index] = changed.outline[index]
    return dataclasses.replace(changed, outline=outline)


def _blended(here: Array, by: Array, there: Array, mirrored_by: Array) -> Array:
    """Return each landmark's move between two moves that meet, shape (N, 2).

    Either landmark makes its own move in full, whatever the other one's reach.
    """
    mine, others = here * (1.0 - there), there * (1.0 - here)
    share = mine / np.maximum(mine + others, 1e-12)
    most = np.maximum(here, there)
    return np.asarray(most[:, None] * (share[:, None] * by + (1.0 - share[:, None]) * mirrored_by))
