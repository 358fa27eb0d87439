"""Heads that touch: who is in front, and where the head behind gives way.

Inside the head in front only its own displacement counts. The head behind shrinks about a point
near the line of contact (`near_heads`), and its displacement rises from nothing at that line. A
person who isn't shrunk counts like a head that doesn't move.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array, smoothstep
from kogao_core.faces.face import Face
from kogao_core.faces.head import HeadFrame
from kogao_core.faces.reshape import across
from kogao_core.faces.targets import FacePairs

# A face is surely in front of another that is smaller by this factor, or higher in the photo by
# this many distances from the eyes to the chin. Larger values call more pairs of heads equal.
_LARGER: Final = 1.35
_LOWER: Final = 1.8
# The head's own outline in radii of the face: up, down, and to the sides of a frontal head. On the
# side away from which a head is turned, ear and hair add so much per `turn`.
_UP: Final = 1.65
_DOWN: Final = 1.05
_SIDE: Final = 1.22
_TURNED: Final = 0.6
_LEAST_SIDE: Final = 1.05
_ROUND: Final = 0.05  # width over which that limit sets in
# Places of heads in front up to this far from a landmark attract the pivot, in eyes-to-chin
# distances, and the pivot's own weight against a place as long as that distance.
_ATTRACTED: Final = 0.5
_OWN_WEIGHT: Final = 0.5
_DIRECTIONS: Final = 73  # in which the outline of a head is sampled


@dataclass(frozen=True, eq=False)
class OtherHead:
    """A head beside another."""

    face: Face
    ahead: float  # 0: beside or behind the other, 1: in front of it
    still: bool  # it isn't shrunk

    @cached_property
    def hull(self) -> Array:
        """Corners of the face in order, (K, 2), px."""
        return hull(self.face)

    @cached_property
    def outline(self) -> HeadOutline:
        """The head's own outline."""
        return HeadOutline(self.face)


def ahead(one: Face, other: Face) -> float:
    """Return how far the head of `one` is in front of `other`; 0 if beside it or behind."""
    larger = np.log(one.anchor.spacing_px / other.anchor.spacing_px) / np.log(_LARGER)
    heights = [HeadFrame.of(face).height_px for face in (one, other)]
    lower = float((one.eye_center - other.eye_center)[1]) / float(np.mean(heights)) / _LOWER
    return float(smoothstep(np.asarray(larger + lower)))


class HeadOutline:
    """A head with ears and hair, about: larger than the face, and more so where it is turned."""

    def __init__(self, face: Face) -> None:
        """Measure the directions of a face's edge."""
        self._right = across(face)
        self._center = face.middle
        ring = face.outline if face.forehead is None else np.vstack([face.outline, face.forehead])
        if face.forehead is None:
            # An arch: the mirror image of the ends' chord, as far above as the chin is below.
            up = face.eye_center - face.mouth_center
            ring = np.vstack([ring, face.middle + 1.3 * up, face.outline[[0, -1]] + 0.6 * up])
        angles, radii = self._seen(ring)
        order = np.argsort(angles, kind="stable")
        order = np.concatenate([order[-1:], order, order[:1]])
        turns = np.concatenate([[-2.0 * np.pi], np.zeros(len(ring)), [2.0 * np.pi]])
        self._angles, self._radii = angles[order] + turns, radii[order]
        left, right = (face.outline[[0, -1]] - face.eye_center) @ self._right
        self._turn = float((right + left) / max(1e-9, abs(right - left)))

    def beyond_px(self, points: Array) -> Array:
        """Return about how far points (N, 2) are outside the head, px; below 0 within."""
        angles, far = self._seen(points)
        return np.asarray(far - self._edge_px(angles))

    @cached_property
    def ring_px(self) -> Array:
        """The outline, (`_DIRECTIONS` - 1, 2), px."""
        angles = np.linspace(-np.pi, np.pi, _DIRECTIONS)[:-1]
        down = np.array([-self._right[1], self._right[0]])
        ways = np.outer(np.sin(angles), self._right) + np.outer(np.cos(angles), down)
        return np.asarray(self._center + self._edge_px(angles)[:, None] * ways)

    def _edge_px(self, angles: Array) -> Array:
        sides, along = np.sin(angles), np.cos(angles)
        wide = _SIDE + _TURNED * self._turn * np.sign(sides) - _LEAST_SIDE
        wide = _LEAST_SIDE + 0.5 * (wide + np.hypot(wide, _ROUND))
        ends = np.where(along > 0.0, _DOWN, _UP)
        radii_px = np.interp(angles, self._angles, self._radii)
        return np.asarray(radii_px * (ends + (wide - ends) * sides**2))

    def _seen(self, points: Array) -> tuple[Array, Array]:
        away = points - self._center
        right, down = away @ self._right, away @ np.array([-self._right[1], self._right[0]])
        return np.arctan2(right, down), np.hypot(right, down)


def others_of(k: int, faces: Sequence[Face], still: Sequence[Face] = ()) -> tuple[OtherHead, ...]:
    """Return the other heads of a photo, seen from face `k`; `still` are those that stay."""
    moving = [face for j, face in enumerate(faces) if j != k]
    return tuple(
        OtherHead(face, ahead(face, faces[k]), stays)
        for stays, some in ((False, moving), (True, still))
        for face in some
    )


def near_heads(
    pairs: Sequence[FacePairs], faces: Sequence[Face], still: Sequence[Face]
) -> tuple[FacePairs, ...]:
    """Move the pivot of each head towards heads in front that touch it, and all targets alike."""
    found = []
    for k, (pair, face) in enumerate(zip(pairs, faces, strict=True)):
        front = [one for one in others_of(k, faces, still) if one.ahead > 0.0]
        if not front or not pair.head_share:
            found.append(pair)
            continue
        size = HeadFrame.of(face).height_px
        rings = [one.outline.ring_px for one in front]
        lengths = [np.hypot(*(np.roll(r, -1, axis=0) - np.roll(r, 1, axis=0)).T) / 2 for r in rings]
        places, weights = (
            np.vstack(rings),
            np.concatenate([one.ahead * part for one, part in zip(front, lengths, strict=True)]),
        )
        points = np.vstack([face.points, face.points if face.forehead is None else face.forehead])
        away = np.min(np.hypot(*(places[:, None] - points).transpose(2, 0, 1)), axis=1)
        weights = weights / size * smoothstep(1.0 - away / (_ATTRACTED * size))
        shift = weights @ (places - pair.center_px) / (_OWN_WEIGHT + weights.sum())
        found.append(shifted(pair, face, shift))
    return tuple(found)


def shifted(pair: FacePairs, face: Face, shift: Array) -> FacePairs:
    """Return pairs with another pivot; targets placed by hand stay."""
    moved = pair.target_px + pair.head_share * shift
    if face.targets is not None:
        moved = np.where(np.isnan(face.targets), moved, pair.target_px)
    center = pair.center_px + (shift if pair.head_share else 0.0)
    return dataclasses.replace(pair, target_px=moved, center_px=center)


def hull(face: Face) -> Array:
    """Return the corners of a face in order, (K, 2), px."""
    ring = face.points if face.forehead is None else np.vstack([face.points, face.forehead])
    corners: Array = cv2.convexHull(ring.astype(np.float32))[:, 0].astype(np.float64)
    return corners


def beyond(points: Array, hull: Array) -> Array:
    """Return about how far points are outside a hull, px; 0 or less within."""
    along = np.roll(hull, -1, axis=0) - hull
    outward = np.column_stack([along[:, 1], -along[:, 0]])
    outward /= np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-12)[:, None]
    if (outward * (hull - hull.mean(axis=0))).sum() < 0.0:
        outward = -outward
    return np.asarray((points @ outward.T - (hull * outward).sum(axis=1)).max(axis=1))
