"""The rim of a face: its closed edge in polar form, and what the rim does beside shrinking.

A point p has the direction a from the centre c, from straight down, and the distance rho in units
of the rim in this direction::

    rho(p) = |p - c| / radius(a)        1 on the rim, 0 in the centre

`docs/figures/rim.svg` draws curves of equal rho. The rim goes through the targets of the outline
and over the forehead: as marked, or an arch over the outline's ends. Between these points radius
and displacement are linear in the direction. rho is the gauge (Minkowski functional) of the face, a
region that is star-shaped about c; Rockafellar (1970), "Convex Analysis", has it for convex ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array, smoothstep
from kogao_core.faces.face import FOREHEAD_POINTS, Face
from kogao_core.faces.reshape import across
from kogao_core.faces.targets import FacePairs
from kogao_core.faces.zones import Shape, directions

# The hairline begins to move this far up from the eye line to the top of the forehead.
_BROWS: Final = 0.25
_CROWN: Final = 1.25  # top of a forehead that nobody marked, in radii of the outline's ends
_TURN: Final = 2.0 * np.pi


@dataclass(frozen=True, slots=True, eq=False)
class Rim:
    """The closed edge of a face after the warp, by ascending direction.

    Directions are from straight down, in radians; `upwards` is 0 at the outline's ends and below,
    1 at the top of the forehead.
    """

    center_px: Array
    across: Array
    angles: Array
    radii_px: Array
    moves_px: Array  # the backward displacement, less that of the head as one body
    hairline_px: Array  # the displacement of the top of the forehead beside that
    upwards: Array

    @classmethod
    def of(cls, face: Face, pairs: FacePairs, middle: Array, shape: Shape | None) -> Rim:
        """Return the rim after the moves of `pairs`, shaped about `middle` (2,), px."""
        right, share = across(face), pairs.head_share
        center = middle + share * (pairs.center_px - middle)
        rest = pairs.displacement_px - similarity(pairs, pairs.target_px)
        forehead = _forehead(face, middle)
        along = np.linspace(0.0, 1.0, FOREHEAD_POINTS + 2)[1:-1]
        height = 1.0 - np.abs(2.0 * along - 1.0)
        moves = np.zeros_like(forehead)
        hairline = np.zeros_like(forehead)
        if shape is not None:
            away = forehead - middle
            first, last = shape.zones[[0, -1]]
            aside = first + (last - first) * smoothstep(along)
            moves = shape.scaled(away, aside=aside)
            hairline = hairline_at(face, middle, shape, forehead)
        body = share * (pairs.center_px - forehead)
        rim = np.vstack([pairs.target_px, forehead + body - moves - hairline])
        angles, radii = _seen_from(rim, center, right)
        order = np.argsort(angles, kind="stable")
        order = np.concatenate([order[-1:], order, order[:1]])  # once round, and a step on
        angles = angles[order] + np.concatenate([[-_TURN], np.zeros(len(rim)), [_TURN]])
        moves = np.vstack([rest, moves])[order]
        hairline = np.vstack([np.zeros_like(rest), hairline])[order]
        upwards = np.concatenate([np.zeros(len(rest)), height])[order]
        radii = np.maximum(radii[order], 1e-3 * max(1e-9, float(radii.max())))
        return cls(center, right, angles, radii, moves, hairline, upwards)

    def at(self, points: Array) -> tuple[Array, Array]:
        """Return rho and direction, radians, of points of shape (N, 2)."""
        angles, far = _seen_from(points, self.center_px, self.across)
        return far / self.radius_px(angles), angles

    def radius_px(self, angles: Array) -> Array:
        """Return how far the rim is from the centre in directions of shape (N,)."""
        return np.interp(angles, self.angles, self.radii_px)

    def moved_px(self, angles: Array, moves_px: Array) -> Array:
        """Return `moves_px` or `hairline_px` of the rim in directions of shape (N,); (N, 2), px."""
        return np.stack([np.interp(angles, self.angles, move) for move in moves_px.T], axis=-1)


def similarity(pairs: FacePairs, points: Array) -> Array:
    """Return the backward displacement at points (N, 2) of a head that shrinks as one, px."""
    share = pairs.head_share
    return np.asarray(share / (1.0 - share) * (points - pairs.center_px))


def _forehead(face: Face, center: Array) -> Array:
    """Return the rim of the forehead, (13, 2), px: as it was seen, or an arch over the ends."""
    if face.forehead is not None:
        return face.forehead
    right = across(face)
    (first, last), radii = _seen_from(face.outline[[0, -1]], center, right)
    along = np.linspace(0.0, 1.0, FOREHEAD_POINTS + 2)[1:-1]
    # From the left end, whose direction is negative, over the top at -pi = pi to the right end.
    first, last = first % (2.0 * np.pi), last % (2.0 * np.pi)
    turn = first + along * (last - first)
    far = radii[0] + along * (radii[1] - radii[0])
    far = far + smoothstep(1.0 - np.abs(2.0 * along - 1.0)) * (_CROWN * float(radii.mean()) - far)
    return np.asarray(center + far[:, None] * unit_vectors(turn, right))


def hairline_at(face: Face, middle: Array, shape: Shape, points: Array) -> Array:
    """Return the displacement of the top of the head at points of shape (N, 2), px.

    It grows with the height above the brows, alike over the whole width of the hair.
    """
    below, forehead = shape.axes[1], _forehead(face, middle)
    heights = (middle - points) @ below
    low = float(((middle - face.outline[[0, -1]]) @ below).mean())
    top = float((middle - forehead[len(forehead) // 2]) @ below)
    share = (heights - low) / max(1e-9, top - low)
    rise = smoothstep((share - _BROWS) / (1.0 - _BROWS))
    return np.outer(-shape.hairline * heights * rise, below)


def unit_vectors(angles: Array, right: Array) -> Array:
    """Return unit vectors, (N, 2), in directions from straight down, radians."""
    below = np.array([-right[1], right[0]])
    return np.asarray(np.outer(np.sin(angles), right) + np.outer(np.cos(angles), below))


def _seen_from(points: Array, center: Array, right: Array) -> tuple[Array, Array]:
    """Return directions from straight down, radians, and distances, px, of points (N, 2)."""
    degrees, far = directions(points, center, right)
    return np.radians(degrees), far
