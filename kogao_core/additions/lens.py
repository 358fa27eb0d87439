"""Lens correction: remove the perspective stretch of heads away from the photo's centre.

A rectilinear lens draws a sphere at angle t from the optical axis 1 / cos t longer in the radial
direction than across. A camera aimed at the head would have taken a picture that differs by the
homography ``K R K^-1``, if the head is far enough away (Hartley and Zisserman 2004, 8.4). The
correction is the displacement of this homography for the whole head, hair and ears included. The
head keeps the size that it has across the radial direction.

The control points take the displacement before the landmarks are fitted, as with `surround`.
Outside the head the displacement fades to zero, in neck, shoulders and background. The corrected
head may shift: the shift is chosen to stretch the other heads and the photo's edge the least.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.additions.edge import edges_px
from kogao_core.base.geometry import Array, Box, ramp
from kogao_core.base.language import Text
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across
from kogao_core.field.field import inverted
from kogao_core.photo.optics import FILM_MM
from kogao_core.recipe.recipe import Recipe

# A circle approximates a head with hair. The centre is this far above the middle of eyes and mouth,
# in landmark spacings.
_ABOVE: Final = 1.5
# Radius of the head's circle in landmark spacings. Larger values correct more hair and background.
_RADIUS: Final = 7.0
# Width of the fade outside the head, in head radii. Larger values spread the stretch wider.
_FADE: Final = 2.5
# Exponent of the distance to a head's centre inside the head. Where heads overlap, larger values
# narrow the transition between the two displacements.
_SHARP: Final = 8
# `_apart` at the rim of a head, no unit. Smaller values weaken the influence of other heads there.
_RIM: Final = 0.02
# Exponent of the distance from a head's rim. Between heads, larger values narrow the transition.
_GAP: Final = 1.5
# Least distance, in head radii, over which the displacement across the photo's edge falls to zero.
_EDGE: Final = 0.3
# Distance from a face's origin to the photo's edge, in head radii. Among other heads, the photo's
# edge stays in place up to this distance, and the head's rim from one radius more.
_NEAR_EDGE: Final = 1.5
# Heads with centres at most this far apart, in mean head radii, shift together with full weight.
_CLOSE: Final = 2.0
# Heads with centres at least this far apart, in mean head radii, shift independently.
_ALONE: Final = 3.0
# Weight of equal displacements in the gap between two heads, relative to the weight 1 of the head's
# own position. Larger values shear the gap less and shift the heads more.
_TOGETHER: Final = 12.0
# Extra weight of the head's own position one head radius from the photo's edge. The weight falls by
# the fourth power of the distance. Larger values shift heads near the edge less.
_KEPT: Final = 10.0
# Least depth of a point behind the homography, in focal lengths: smaller depths are far outside the
# head and would divide by zero.
_LEAST_DEPTH: Final = 0.2
_STEPS: Final = 12  # of the fixed-point inversion; each step reduces the error to a fifth
NOBODY: Final = np.zeros((0, 2))
STRETCH_SEEN_PERCENT: Final = 1.0  # stretch of a face, %, from which the stretch is reported
# Distances on an adult's face, m: between the outer corners of the eyes, and from the eyes to the
# mouth. Checked by iris size: 112 of 118 people are within 10 %.
_ADULT_M: Final = np.array([0.087, 0.068])
_WITHIN: Final = 0.1  # relative error of an estimated distance for nearly all adults
# From the outer corners of the eyes to the tip of the nose, m, along the camera's axis. The widest
# part of the face is assumed to be as far behind the corners.
_NOSE_M: Final = 0.04
_NATURAL_M: Final = 1.5  # camera distance, m, from which a nose has a natural size
NOSE_SEEN_PERCENT: Final = 5.0  # enlargement of the nose, %, from which a note mentions the nose


def focal_px(focal_mm: float, photo: Box) -> float:
    """Convert a 35-mm equivalent focal length to px of a photo, by the length of the diagonal."""
    return focal_mm * float(np.hypot(photo.width, photo.height)) / FILM_MM


def stretch_percent(face: Face, focal_mm: float, photo: Box) -> float:
    """Return the radial stretch of a face by the lens, %: how much longer than across."""
    off = np.asarray(face.anchor.origin_px) - edges_px(photo).mean(axis=0)
    return 100.0 * (float(np.hypot(np.hypot(*off) / focal_px(focal_mm, photo), 1.0)) - 1.0)


def distance_m(face: Face, focal_mm: float, photo: Box) -> float:
    """Return the distance between the camera and an adult's face, m, from the angles in view.

    A turned head looks narrower and a nodding head looks lower; the larger angle counts.
    """
    ends = np.array([face.eyes[[0, 3]], [face.eye_center, face.mouth_center]])
    rays = np.dstack(
        [ends - edges_px(photo).mean(axis=0), np.full((2, 2), focal_px(focal_mm, photo))]
    )
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    return float((_ADULT_M / np.linalg.norm(rays[:, 0] - rays[:, 1], axis=1)).min())


def distance_range_m(distance: float) -> tuple[float, float]:
    """Return the least and greatest likely distance, m, given an estimate for an average adult."""
    return distance * (1.0 - _WITHIN), distance * (1.0 + _WITHIN)


def nose_percent(distance: float) -> float:
    """Return how much larger a nose looks than from 1.5 m, relative to the face's width, %."""
    near, natural = ((d + _NOSE_M) / max(d - _NOSE_M, _NOSE_M) for d in (distance, _NATURAL_M))
    return 100.0 * (near / natural - 1.0)


def distance_note(distance: float) -> str:
    """Describe the distance of the camera and, from `NOSE_SEEN_PERCENT`, the enlarged nose."""
    said = dict(zip(("least", "most"), distance_range_m(distance), strict=True), about=distance)
    if distance < 1.0:
        said = {name: 100.0 * value for name, value in said.items()}
        note = Text("about {about:.0f} cm from the camera ({least:.0f} to {most:.0f})", **said)
    else:
        note = Text("about {about:.1f} m from the camera ({least:.1f} to {most:.1f})", **said)
    if (percent := nose_percent(distance)) < NOSE_SEEN_PERCENT:
        return note
    return Text(
        "{distance}: a nose looks {percent:.0f} % larger than from 1.5 m",
        distance=note,
        percent=percent,
    )


@dataclass(frozen=True, eq=False)
class Head:
    """The displacement that removes the lens stretch of one head."""

    face: Face
    focal_px: float
    photo: Box
    share: float = 1.0  # fraction of the stretch to remove, 0 to 1
    crowding: float = 0.0  # nearness of other heads, 0 to 1
    # Extra shift, (2,), px: keeps the gaps to other heads from being sheared.
    offset_px: Array = dataclasses.field(default_factory=lambda: np.zeros(2))

    @cached_property
    def center_px(self) -> Array:
        """The centre of the head's circle in the result, (2,), px."""
        right = across(self.face)
        above = _ABOVE * self.face.anchor.spacing_px * np.array([right[1], -right[0]])
        return np.asarray(self.face.anchor.origin_px + above + self.offset_px)

    @property
    def radius_px(self) -> float:
        """The radius of the head's circle, px."""
        return _RADIUS * self.face.anchor.spacing_px

    @cached_property
    def around_px(self) -> Array:
        """Corners (x, y) of a box outside which the displacement is zero, (2, 2), px."""
        far = (1.0 + _FADE) * self.radius_px
        return np.array([self.center_px - far, self.center_px + far])

    @cached_property
    def room_px(self) -> float:
        """Distance from the face's origin to the photo's edge, px, away from the photo's centre."""
        low, high = edges_px(self.photo)
        way = np.maximum(np.abs(self.face.anchor.origin_px - (low + high) / 2.0), 1e-9)
        far = float(np.hypot(*way))
        return max(0.0, float(((high - low) / 2.0 * far / way).min()) - far)

    @cached_property
    def _aimed(self) -> tuple[Array, Array]:
        """The homography from the corrected head to the photo, (3, 3), and the shift, (2,), px.

        The shift sets the distance, outwards from the head, at which the result stays in place. A
        head alone is shifted so far that the fade stretches both sides alike. Among other heads,
        the head's rim stays in place, or the photo's edge if that is near.
        """
        middle = edges_px(self.photo).mean(axis=0)
        origin = np.asarray(self.face.anchor.origin_px)
        off, f, radius = origin - middle, self.focal_px, self.radius_px
        far = float(np.hypot(*off))
        way = off / max(far, 1e-9 * f)
        angle = float(np.arctan2(far, f))
        turn, _ = cv2.Rodrigues(angle * np.array([-way[1], way[0], 0.0]))
        nears = 1.0 - ramp(np.asarray(self.room_px / radius - _NEAR_EDGE))
        rim = radius + (self.room_px - radius) * float(nears)
        strip = float(np.clip(self.room_px / radius - 1.0, 0.0, _FADE))
        alone = min(self.room_px, radius) * (_FADE - strip) / (_FADE + strip)
        stays = alone + (rim - alone) * self.crowding
        shift = stays - f * np.tan(np.arctan2(far + stays, f) - angle) / np.cos(angle)
        scale = np.diag([np.cos(angle), np.cos(angle), 1.0])
        lens = np.diag([f, f, 1.0])
        back = _shift(middle) @ lens @ turn @ np.linalg.inv(lens) @ scale @ _shift(-origin)
        return np.asarray(back), self.share * shift * way

    def undistorted(self, points: npt.ArrayLike) -> Array:
        """Return the backward displacement of the head at points of shape (N, 2), px."""
        homography, shift = self._aimed
        shift = shift + self.offset_px
        points = np.asarray(points, np.float64) - shift
        seen = np.column_stack([points, np.ones(len(points))]) @ homography.T
        back = seen[:, :2] / np.maximum(seen[:, 2:], _LEAST_DEPTH) - points
        return np.asarray(self.share * back - shift)

    def rho(self, points: Array) -> Array:
        """Return the distance of points of shape (N, 2) from the head's centre, in head radii."""
        away = points - self.center_px
        return np.asarray(np.hypot(away[:, 0], away[:, 1]) / self.radius_px)

    def within_photo(self, points: Array) -> Array:
        """Return `undistorted` without the displacement across the photo's edges.

        That component falls to zero outside the head, or inside a head that is near the edge.
        """
        moved = self.undistorted(points)
        beside = np.maximum(self.rho(points) - 1.0, 0.0) * self.radius_px
        for edge, inwards in zip(edges_px(self.photo), (1.0, -1.0), strict=True):
            for axis in (0, 1):
                depth = np.maximum(inwards * (points[:, axis] - edge[axis]), 0.0)
                left = ramp(depth / np.maximum(depth + beside, _EDGE * self.radius_px))
                near = left < 1.0
                if not near.any():
                    continue
                there = points[near]
                there[:, axis] = edge[axis]
                moved[near, axis] -= self.undistorted(there)[:, axis] * (1.0 - left[near])
        return moved


@dataclass(frozen=True, eq=False)
class LensCorrection:
    """The heads of a photo. Where heads overlap, each point follows mainly the nearer head."""

    heads: tuple[Head, ...] = ()

    @classmethod
    def of(cls, faces: Sequence[Face], recipe: Recipe, photo: Box) -> LensCorrection:
        """Return the heads of `faces`; none if `recipe.lens` is not a focal length.

        Replace "auto" by `optics.settled` first.
        """
        if isinstance(recipe.lens, str):
            return cls()
        focal = focal_px(recipe.lens, photo)
        shares = (recipe.of_face(face.recipe).lens_amount / 100.0 for face in faces)
        heads = [Head(f, focal, photo, s) for f, s in zip(faces, shares, strict=True)]
        return cls(_beside_each_other(heads))

    def part_at(self, which: int, points: Array, others_px: Array = NOBODY) -> Array:
        """Return the displacement of one head at points of shape (N, 2), same shape, px.

        Full on the head; fades to zero outside the head and towards `others_px` (M, 2 or 3), points
        of other people that must not move.
        """
        head = self.heads[which]
        rho = head.rho(points)
        mine, share = _apart(rho), 1.0 - ramp((rho - 1.0) / _FADE)
        share /= 1.0 + sum(mine / _apart(other.rho(points)) for other in self._near(which))
        beside = np.maximum(rho - 1.0, 0.0) * head.radius_px
        share *= ramp(1.0 / (1.0 + beside / np.maximum(away_px(points, others_px), 1e-9)))
        return head.within_photo(points) * share[:, None]

    def _near(self, which: int) -> list[Head]:
        """Return the other heads whose fades overlap the fade of this head."""
        head = self.heads[which]
        apart = (float(np.hypot(*(one.center_px - head.center_px))) for one in self.heads)
        return [
            other
            for k, (other, far) in enumerate(zip(self.heads, apart, strict=True))
            if k != which and far < (1.0 + _FADE) * (head.radius_px + other.radius_px)
        ]

    def at(self, points: Array) -> Array:
        """Return the displacement of all heads at points of shape (N, 2), same shape, px."""
        total = np.zeros_like(points)
        for which, head in enumerate(self.heads):
            near = head.rho(points) < 1.0 + _FADE
            if near.any():
                total[near] += self.part_at(which, points[near])
        return total

    @cached_property
    def faces(self) -> list[Face]:
        """The faces after lens correction only. The lattices keep their original grids."""
        faces = [head.face for head in self.heads]
        parts = [part for face in faces for part in _parts(face)]
        if not parts:
            return []
        ends = np.cumsum([len(part) for part in parts])[:-1]
        moved = iter(np.split(inverted(self.at, np.vstack(parts), _STEPS), ends))
        return [
            dataclasses.replace(
                face,
                outline=next(moved),
                eyes=next(moved),
                mouth=next(moved),
                forehead=None if face.forehead is None else next(moved),
                pinned_anchor=face.anchor,
            )
            for face in faces
        ]


NO_LENS: Final = LensCorrection()


def _beside_each_other(heads: Sequence[Head]) -> tuple[Head, ...]:
    """Return heads shifted to reduce the shear between neighbours.

    Least squares: in the middle of the gap both heads should displace alike. Smaller gaps weigh
    more. A head's own position weighs more near the photo's edge.
    """
    near = _nearness(heads)
    heads = [
        dataclasses.replace(head, crowding=1.0 - float(np.prod(1.0 - row)))
        for head, row in zip(heads, near, strict=True)
    ]
    rooms = np.array([max(head.room_px / head.radius_px, 1e-3) for head in heads])
    matrix = np.diag(1.0 + _KEPT / rooms**4)
    wanted = np.zeros((len(heads), 2))
    for j, k in zip(*np.nonzero(np.triu(near)), strict=True):
        one, other, weight = heads[j], heads[k], _TOGETHER * near[j, k]
        share = one.radius_px / (one.radius_px + other.radius_px)
        middle = (one.center_px + share * (other.center_px - one.center_px))[None]
        apart = (one.undistorted(middle) - other.undistorted(middle))[0]
        matrix[[j, k], [j, k]] += weight
        matrix[[j, k], [k, j]] -= weight
        wanted[j] += weight * apart
        wanted[k] -= weight * apart
    aside = np.linalg.solve(matrix, wanted) if len(heads) else wanted
    return tuple(dataclasses.replace(h, offset_px=by) for h, by in zip(heads, aside, strict=True))


def _nearness(heads: Sequence[Head]) -> Array:
    """Return the nearness of each pair of heads, 0 to 1, (K, K); 0 on the diagonal."""
    centers = np.array([head.center_px for head in heads]).reshape(-1, 2)
    radii = np.array([head.radius_px for head in heads])
    apart = centers[:, None] - centers
    far = np.hypot(apart[..., 0], apart[..., 1]) / ((radii[:, None] + radii) / 2.0)
    near = 1.0 - ramp((far - _CLOSE) / (_ALONE - _CLOSE))
    np.fill_diagonal(near, 0.0)
    return np.asarray(near)


def away_px(points: Array, others_px: Array) -> Array:
    """Return the distance of points (N, 2) from the nearest of others (M, 2 or 3), (N,), px."""
    start = points[:1].sum(axis=0)
    heights = (others_px[:, 2:] ** 2).sum(axis=1)
    points, others_px = points - start, others_px[:, :2] - start
    # One product of matrices takes a third of the time of differences.
    apart = ((others_px**2).sum(axis=1) + heights)[:, None] - 2.0 * others_px @ points.T
    nearest = apart.min(axis=0, initial=np.inf) + (points**2).sum(axis=1)
    return np.asarray(np.sqrt(np.maximum(nearest, 0.0)))


def _apart(rho: Array) -> Array:
    """Return the separation of points from a head, no unit, from their distance in head radii.

    The share of a head at a point is inversely proportional to this value.
    """
    within = _RIM * np.clip(rho, 0.1, 1.0) ** _SHARP
    return np.asarray(within + np.maximum(rho - 1.0, 0.0) ** _GAP)


def _parts(face: Face) -> list[Array]:
    parts = (face.outline, face.eyes, face.mouth, face.forehead)
    return [part for part in parts if part is not None]


def _shift(by: Array) -> Array:
    return np.array([[1.0, 0.0, by[0]], [0.0, 1.0, by[1]], [0.0, 0.0, 1.0]])
