"""Lets the head follow a face that is made smaller: forehead, hairline and hair.

The outline ends at the eye line, and what lies higher stays: at large amounts a head looks light at
the bottom. Here what lies round the forehead goes towards the same centre, at the hairline the same
share of the way as the landmarks, less and less above it and to the sides, and nothing beyond the
hair. The control points there take that displacement before the landmarks are fitted, so it is one
spline, and each landmark still goes exactly where it did (`docs/decisions/43`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, smoothstep
from kogao_core.base.language import Text
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across
from kogao_core.faces.zones import directions, gains
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.protection import Protection

# In distances between the centre and the mesh's edge of the forehead: how far outside it the
# hairline lies, how far beyond that nothing follows any more, and how far within it.
_HAIRLINE: Final = 0.08
_REACH: Final = 1.2
_WITHIN: Final = 0.35
# What lies beside the face follows, too, down to here: the way from the middle of the forehead to
# the outline's end is 1. Without it hair bulges at the eye line.
_DOWN: Final = 1.6
_SIDE: Final = 6  # landmarks of each side that tell where the face's edge is there
# In landmark spacings: so far inside the photo all follows, at its edge nothing; so near to other
# faces and protected places nothing, and so much farther all.
_EDGE: Final = 4.0
_APART: Final = 1.0
_WHOLE: Final = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Head:
    """What a head asks of the control points above its face."""

    # (2,): where it goes, and the direction across the face.
    center_px: Array
    across: Array
    # (N,): along the edge of forehead and cheeks, by ascending direction from straight up: the
    # direction, the distance from the centre, the place (see `_DOWN`), and which part of the
    # distance things go.
    degrees: Array
    radii_px: Array
    aside: Array
    share: Array
    spacing_px: float  # of the landmarks
    photo: Box  # nothing moves across its edge
    protection: Protection  # places that must not move
    hulls: tuple[Array, ...]  # (K, 2): of other faces, corners in order

    @property
    def corners_px(self) -> Array:
        """Corners of a box, as far as it lies in the photo, outside which all is 0; (2, 2)."""
        return _corners(self.center_px, self.radii_px, self.photo)

    def at(self, points: npt.ArrayLike) -> Array:
        """Return the displacement at points, backwards, px. Result (N, 2)."""
        points = np.asarray(points, np.float64)
        degrees, far = directions(points, self.center_px, -self.across)
        aside = np.minimum(1.0, np.interp(degrees, self.degrees, self.aside) / _DOWN)
        over = np.cos(np.pi / 2.0 * np.minimum(1.0, aside * _DOWN))
        rim = np.interp(degrees, self.degrees, self.radii_px) * (1.0 + _HAIRLINE * np.sqrt(over))
        out = far / np.maximum(rim, 1e-12) - 1.0
        reach = np.maximum(_REACH * np.cos(np.pi / 2.0 * aside), 1e-12)
        part = np.where(out > 0.0, 1.0 - _rise(out / reach), _rise(1.0 + out / _WITHIN))
        beside = _rise((1.0 - aside) / (1.0 - 1.0 / _DOWN))
        part = part * beside * np.interp(degrees, self.degrees, self.share) * self._free(points)
        return np.asarray((part / (1.0 - part))[:, None] * (points - self.center_px))

    def _free(self, points: Array) -> Array:
        """Return 0 at the photo's edge and near what must not move, 1 far from it."""
        low = points - (self.photo.left, self.photo.top)
        high = np.array([self.photo.right - 1, self.photo.bottom - 1]) - points
        inside = np.minimum(low, high).min(axis=1)
        away = self.protection.away_px(points)
        for hull in self.hulls:
            away = np.minimum(away, _beyond(points, hull))
        free = _rise((away / self.spacing_px - _APART) / _WHOLE)
        return np.asarray(free * _rise(inside / (_EDGE * self.spacing_px)))


def heads_of(
    faces: Sequence[Face],
    centers_px: Sequence[Array],
    recipes: Sequence[Recipe],
    photo: Box,
    protection: Protection,
) -> tuple[Head | None, ...]:
    """Return what follows of each head whose recipe asks for it and whose forehead is known.

    `centers_px` (2,). Result: None for faces whose heads stay.
    """
    foreheads = [_following(*both) for both in zip(faces, recipes, strict=True)]
    if all(forehead is None for forehead in foreheads):
        return (None,) * len(faces)
    hulls = [_hull(face) for face in faces]
    found: list[Head | None] = []
    asked = zip(faces, foreheads, recipes, centers_px, strict=True)
    for k, (face, forehead, own, center) in enumerate(asked):
        if forehead is None:
            found.append(None)
            continue
        line, aside, share = _edge(face, forehead, own)
        degrees, radii = directions(line, center, -across(face))
        order = np.argsort(degrees, kind="stable")
        unit = face.anchor.spacing_px
        far = (_APART + _WHOLE) * unit
        low, high = _corners(center, radii, photo) + np.array([[-far], [far]])
        others = (hull for other, hull in enumerate(hulls) if other != k)
        head = Head(
            *(center, across(face), degrees[order], radii[order], aside[order], share[order]),
            unit,
            photo,
            protection,
            tuple(
                o for o in others if (o.max(axis=0) > low).all() and (o.min(axis=0) < high).all()
            ),
        )
        found.append(head)
    return tuple(found)


def forehead_pairs(face: Face, recipe: Recipe, center_px: Array) -> tuple[Array, Array]:
    """Return the rim of a forehead that follows, and where it goes if nothing is in its way.

    `center_px` (2,). Result (13, 2): px; of shape (0, 2) where the head doesn't follow.
    """
    forehead = _following(face, recipe)
    if forehead is None:
        return np.zeros((0, 2)), np.zeros((0, 2))
    _, aside, share = _edge(face, forehead, recipe)
    share = share[aside < 1.0]
    return forehead, forehead + share[:, None] * (center_px - forehead)


def unfollowed(faces: Sequence[Face], recipe: Recipe) -> str:
    """Return a sentence on the faces whose heads are asked to follow and can't.

    Result: empty where there is none.
    """
    count = sum(f.forehead is None and recipe.of_face(f.recipe).whole_head for f in faces)
    if count == 0:
        return ""
    return Text.counted(
        count,
        "whole head does nothing for {n} face, whose landmarks don't say where the forehead is; "
        "look for faces with the mesh",
        "whole head does nothing for {n} faces, whose landmarks don't say where the forehead is; "
        "look for faces with the mesh",
    )


def _following(face: Face, recipe: Recipe) -> Array | None:
    return face.forehead if recipe.whole_head else None


def _edge(face: Face, forehead: Array, recipe: Recipe) -> tuple[Array, Array, Array]:
    """Return the edge of forehead and upper cheeks from left to right, (N, 2).

    And of each point `Head.aside` and `Head.share`.
    """
    side = min(_SIDE, len(face.outline) // 3)
    left, right = slice(side, None, -1), slice(None, -side - 2, -1)
    line = np.vstack([face.outline[left], forehead, face.outline[right]])
    half = (len(forehead) + 1) / 2.0
    aside = np.abs(np.arange(len(line)) - (len(line) - 1) / 2.0) / half
    gain = gains(face, recipe) if recipe.zones else np.ones(len(face.outline))
    over = _rise(np.linspace(0.0, 1.0, len(forehead) + 2)[1:-1])
    over = gain[0] + (gain[-1] - gain[0]) * over
    share = recipe.percent / 100.0 * np.concatenate([gain[left], over, gain[right]])
    return line, aside, share


def _corners(center: Array, radii: Array, photo: Box) -> Array:
    far = (1.0 + _HAIRLINE) * (1.0 + _REACH) * float(radii.max())
    edges = np.array([(photo.left, photo.top), (photo.right, photo.bottom)], np.float64)
    return np.asarray(np.clip([center - far, center + far], edges[0], edges[1]), np.float64)


def _hull(face: Face) -> Array:
    ring = face.points if face.forehead is None else np.vstack([face.points, face.forehead])
    corners: Array = cv2.convexHull(ring.astype(np.float32))[:, 0].astype(np.float64)
    return corners


def _beyond(points: Array, hull: Array) -> Array:
    """Return about how far points are outside a hull, px; 0 or less within."""
    along = np.roll(hull, -1, axis=0) - hull
    outward = np.column_stack([along[:, 1], -along[:, 0]])
    outward /= np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-12)[:, None]
    if (outward * (hull - hull.mean(axis=0))).sum() < 0.0:
        outward = -outward
    return np.asarray((points @ outward.T - (hull * outward).sum(axis=1)).max(axis=1))


def _rise(share: Array) -> Array:
    """Return a smooth step from 0 at 0 and below to 1 at 1 and above."""
    return smoothstep(np.clip(share, 0.0, 1.0))
