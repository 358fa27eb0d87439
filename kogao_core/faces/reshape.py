"""Move landmarks and targets by hand; neighbours and, optionally, the other side follow."""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array, arc_lengths
from kogao_core.faces.face import Face

# A landmark closer to the midline than this, in landmark spacings, belongs to both sides.
MIDDLE: Final = 0.25


def across(face: Face) -> Array:
    """Return the direction across the midline, shape (2,), to the right of an upright head."""
    down = face.mouth_center - face.eye_center
    down = down / max(1e-12, float(np.linalg.norm(down)))
    return np.array([down[1], -down[0]])


def turns(face: Face, points: Array) -> Array:
    """Return the angle of each point around the face's middle, from left over chin to right."""
    right = across(face)
    down = np.array([-right[1], right[0]])
    away = points - face.middle
    return np.asarray(np.arctan2(away @ right, away @ down))


def reflection(face: Face) -> Affine:
    """Return the map that mirrors px at the line from the middle of the eyes to the mouth."""
    normal, on_midline = across(face), face.eye_center
    matrix = np.eye(2) - 2.0 * np.outer(normal, normal)
    return Affine(matrix, on_midline - matrix @ on_midline)


def opposite(face: Face, index: int) -> int | None:
    """Return the landmark nearest to the mirror image of landmark `index`, across the midline.

    Result: None for a landmark on the midline, or if the other side has no landmark.
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
    """Return the share with which each landmark follows landmark `index`: a half cosine wave.

    Result (N,): 1 at the landmark, 0.5 half way, 0 from `reach_px` on.
    """
    along = arc_lengths(outline)
    away = np.abs(along - along[index])
    near = np.clip(away / max(reach_px, 1e-12), 0.0, 1.0)
    weights = 0.5 * (1.0 + np.cos(np.pi * near))
    weights[near >= 1.0] = 0.0  # the cosine of pi is not quite -1 for every near
    weights[index] = 1.0
    return np.asarray(weights)


def moved(
    face: Face, index: int, to: npt.ArrayLike, reach_px: float = 0.0, *, symmetric: bool = False
) -> Face:
    """Return the face with one outline landmark and its followers moved.

    `to` (2,) px. Result: the landmark has confidence 1; the lattice anchor is unchanged.
    """
    changed = face.with_outline_point(index, to)
    moves = _moves(
        face, index, np.asarray(to, np.float64) - face.outline[index], reach_px, symmetric
    )
    outline = face.outline + moves
    outline[index] = changed.outline[index]
    return dataclasses.replace(changed, outline=outline)


def with_target_moved(
    face: Face,
    target_px: Array,
    index: int,
    to: npt.ArrayLike,
    reach_px: float = 0.0,
    *,
    symmetric: bool = False,
) -> Face:
    """Return the face with one target moved by hand; other targets follow like landmarks.

    `to` (2,) px. Result: the moved targets count as placed by hand, the others are unchanged.
    """
    moves = _moves(face, index, np.asarray(to, np.float64) - target_px[index], reach_px, symmetric)
    changed = face.with_target(index, to)
    assert changed.targets is not None
    followed = np.asarray(moves.any(axis=1), bool)
    followed[index] = False
    targets = np.where(followed[:, None], target_px + moves, changed.targets)
    return dataclasses.replace(changed, targets=targets)


def _moves(face: Face, index: int, by: Array, reach_px: float, symmetric: bool) -> Array:
    """Return the move of each outline point if one point moves `by`, shape (N, 2), px."""
    here = influence(face.outline, index, reach_px)
    mirror = opposite(face, index) if symmetric else None
    if mirror is None:
        return np.asarray(here[:, None] * by)
    there = influence(face.outline, mirror, reach_px)
    return _blended(here, by, there, reflection(face).matrix @ by)


def _blended(here: Array, by: Array, there: Array, mirrored_by: Array) -> Array:
    """Blend two moves for each landmark, shape (N, 2), px.

    The two dragged landmarks keep the full move.
    """
    mine, others = here * (1.0 - there), there * (1.0 - here)
    share = mine / np.maximum(mine + others, 1e-12)
    most = np.maximum(here, there)
    return np.asarray(most[:, None] * (share[:, None] * by + (1.0 - share[:, None]) * mirrored_by))
