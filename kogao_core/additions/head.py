"""The displacement of a whole head: it shrinks as one body, and eyes and mouth keep their shape.

The paper's lattice moves the outline alone, so ears and temples are stretched. With `Recipe.scope`
"head" the control points take the displacement of the whole head *before* the landmarks are fitted
on top: the field stays one spline, and each landmark goes exactly to its target. With the pivot p,
the share s by which the head shrinks, rho and the direction a of `additions.rim`::

    d(x) = s / (1 - s) (x - p) * (1 - ramp((rho - keep(a)) / fade(a))) + shape(x)

keep(a) is the rho up to which the head moves whole, beyond the crown and at the chin; fade(a) is
about `_FADE` times the displacement where the fade begins, so its slope stays far below 1 and the
map one-to-one. shape(x) is what the rim does beside the similarity, such as a narrower jaw.
`docs/figures/head.svg` draws rim, keep and fade. Source: `docs/decisions/43`, with measurements.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.additions.contact import OtherHead, ahead, beyond, face_corners, head_corners
from kogao_core.additions.edge import edges_px
from kogao_core.additions.lens import NO_LENS, NOBODY, LensCorrection, away_px
from kogao_core.additions.outline import OutlineMotion, steep_part
from kogao_core.additions.rim import Rim, hairline_at, similarity, unit_vectors
from kogao_core.base.geometry import Array, Box, ramp, smoothstep
from kogao_core.faces.face import Face
from kogao_core.faces.head import EDGE_SLOPE, HeadFrame, limited
from kogao_core.faces.targets import FacePairs, shape_center
from kogao_core.faces.zones import Shape
from kogao_core.field.field import inverted
from kogao_core.recipe.recipe import Recipe

# The head moves whole up to this rho: straight up, which reaches past the crown, and straight
# down. Straight to the sides it is 1. Larger values move more hair, more neck.
_KEEP_UP: Final = 1.65
_KEEP_DOWN: Final = 1.05
_NARROW: Final = 6.0  # exponent of the cosine that bounds "down": larger, less of the shoulders
# A fade is this many times as wide as the displacement where it begins. Larger values squeeze the
# background less and move more of it.
_FADE: Final = 6.2
_FADE_DOWN: Final = 10.0  # the same straight down, where collar and shoulders follow a part
# A fade is at least this wide, in eyes-to-chin distances: straight up and down, and more straight
# to the sides, where straight lines of the background cross it.
_LEAST_FADE: Final = 0.25
_SIDE_FADE: Final = 0.9
# At a displacement of 0 the least width is this share of that at `_WIDE`, a share of the head.
_SOFT: Final = 0.75
_WIDE: Final = 0.08
_INNER: Final = 0.6  # up to this rho the shape leaves widths unchanged; larger: a steeper cheek
# The hairline's move takes the hair along up to `_KEEP_UP` in all directions in which the forehead
# rises to this share of its height: the crown keeps its shape. Larger: only the middle of the hair.
_HAIR: Final = 0.45
# Within this distance of other faces and people beside, in landmark spacings, nothing moves.
_APART: Final = 1.0
_ALL: Final = 3.0  # this much farther away, in landmark spacings, everything moves
# Beside a person who stays, the displacement fades this far from the own face, in the same unit.
_TOUCHED: Final = 1.5
# From the outline of a head in front the displacement rises over the first length, in the same
# unit, and the second times the share of the shrinking. Larger: more of the head behind gives way.
_LEAST_RISE: Final = 0.6
_RISE: Final = 16.0
# A ring of points round each feature, in half its width along and across it.
_EYE: Final = np.array(
    [(-1.15, 0), (-0.5, 0.55), (0.5, 0.55), (1.15, 0), (0.5, -0.55), (-0.5, -0.55)]
)
_MOUTH: Final = np.array([(-1, 0), (-0.4, 0.3), (0.4, 0.3), (1, 0), (0.4, -0.3), (-0.4, -0.3)])
# Eyes and mouth shrink by this share of the head's own shrinking. Larger values: smaller eyes.
_SHRINK: Final = 0.4
# Weight of an error at a feature's points; between these two rho the features give way to the
# outline. Larger: eyes and mouth change their shape more.
_TOLERANCE: Final = 0.01
_NEAR: Final = (0.75, 1.0)
_DIRECTIONS: Final = 73  # in which the ends of the displaced region are sampled
_STEPS: Final = 3  # of a fixed-point iteration, each ten times nearer to the solution


@dataclass(frozen=True, slots=True, eq=False)
class HeadMotion:
    """The displacement of a head and its shape, in an endless photo without other people."""

    face: Face  # after lens correction
    pairs: FacePairs  # the landmarks, their targets and the pivot
    middle_px: Array  # (2,): about which the face is shaped, before the warp
    shape: Shape | None  # what is requested of the face beside its warp distance
    rim: Rim

    @property
    def shapes_features(self) -> bool:
        """Whether eyes and mouth must be kept in shape."""
        return self.shape is not None or self.pairs.head_share != 0.0

    @property
    def strength(self) -> float:
        """How far the head and its shape move, as a share of the distance to the pivot."""
        shape = self.shape
        parts = () if shape is None else (shape.aside, shape.down, shape.hairline, *shape.zones)
        return abs(self.pairs.head_share) + float(np.abs([0.0, *parts]).max())

    def end(self, angles: Array) -> Array:
        """Return in directions of shape (N,) the rho beyond which nothing moves."""
        ends = (keep + fade for keep, fade in (self._fade(angles), self._hair_fade(angles)))
        return np.maximum(*ends)

    def at(self, points: Array) -> Array:
        """Return the backward displacement at points of shape (N, 2), px, same shape."""
        rim = self.rim
        rho, angles = rim.at(points)
        keep, fade = self._fade(angles)
        outside = 1.0 - ramp((rho - keep) / fade)
        moved = similarity(self.pairs, points) * outside[:, None]
        if not (rim.moves_px.any() or rim.hairline_px.any()):
            return moved
        # Inside the face heights change evenly, so that a line from temple to temple stays
        # straight, and widths near the outline only.
        inner = np.where(rho < 1.0, smoothstep((rho - _INNER) / (1.0 - _INNER)), outside)
        right = rim.across
        below = np.array([-right[1], right[0]])
        shape = rim.moved_px(angles, rim.moves_px) * rho[:, None]
        moved = moved + np.outer((shape @ right) * inner, right)
        moved = moved + np.outer((shape @ below) * np.where(rho < 1.0, 1.0, outside), below)
        if not rim.hairline_px.any():
            return np.asarray(moved)
        assert self.shape is not None
        keep, fade = self._hair_fade(angles)
        # The hairline's move is that of places before the warp.
        hair = hairline_at(self.face, self.middle_px, self.shape, points)
        hair = hairline_at(self.face, self.middle_px, self.shape, points + hair)
        return np.asarray(moved + hair * (1.0 - ramp((rho - keep) / fade))[:, None])

    def _fade(self, angles: Array) -> tuple[Array, Array]:
        """Return in directions of shape (N,) the rho where a fade begins, and its width in rho."""
        rim = self.rim
        up = smoothstep(np.interp(angles, rim.angles, rim.upwards))
        down = np.clip(np.cos(angles), 0.0, 1.0) ** _NARROW
        return self._faded(angles, 1.0 + (_KEEP_UP - 1.0) * up + (_KEEP_DOWN - 1.0) * down)

    def _hair_fade(self, angles: Array) -> tuple[Array, Array]:
        """Return the rho where the move of the hairline begins to fade, and the fade's width."""
        rim = self.rim
        if not rim.hairline_px.any():
            return np.ones_like(angles), np.zeros_like(angles)
        up = np.interp(angles, rim.angles, rim.upwards) / _HAIR
        return self._faded(angles, 1.0 + (_KEEP_UP - 1.0) * smoothstep(up))

    def _faded(self, angles: Array, keep: Array) -> tuple[Array, Array]:
        rim, size = self.rim, HeadFrame.of(self.face).height_px
        down = np.clip(np.cos(angles), 0.0, 1.0) ** _NARROW
        radius = rim.radius_px(angles)
        ends = rim.center_px + (keep * radius)[:, None] * unit_vectors(angles, rim.across)
        moves = rim.moved_px(angles, rim.moves_px + rim.hairline_px)
        wide = np.hypot(*(similarity(self.pairs, ends) + keep[:, None] * moves).T)
        wide *= _FADE + (_FADE_DOWN - _FADE) * down
        least = (_LEAST_FADE + _SIDE_FADE * np.abs(np.sin(angles)) ** 3) * size
        least *= _SOFT + (1.0 - _SOFT) * self.strength / _WIDE
        return keep, (wide**4 + least**4) ** 0.25 / radius


@dataclass(frozen=True, eq=False)
class HeadField:
    """The displacement that one head asks of its control points, lens correction included."""

    face: Face  # after lens correction
    motion: HeadMotion | OutlineMotion
    photo: Box  # nothing moves across its edge
    neighbours_px: Array  # (M, 3): points of people beside, who don't go along (`PersonMask`)
    lens: LensCorrection = NO_LENS
    face_index: int = 0  # in `lens`
    others: tuple[OtherHead, ...] = ()  # other heads, near

    @cached_property
    def around_px(self) -> Array:
        """Corners (x, y) of a box outside which nothing moves, (2, 2), px; ignores the photo."""
        boxes = [head.around_px for head in self.lens.heads[self.face_index : self.face_index + 1]]
        if self.motion.strength:
            boxes.append(self._around_head_px)
        return np.array([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]])

    @cached_property
    def _around_head_px(self) -> Array:
        """Corners of a box outside which the head's own displacement is zero, (2, 2), px."""
        angles, rim = np.linspace(-np.pi, np.pi, _DIRECTIONS), self.motion.rim
        far = self.motion.end(angles) * rim.radius_px(angles)
        edge = rim.center_px + far[:, None] * unit_vectors(angles, rim.across)
        return np.array([edge.min(axis=0), edge.max(axis=0)])

    @property
    def corners_px(self) -> Array:
        """Corners (x, y) of the part of the photo that moves, (2, 2), px."""
        return np.clip(self.around_px, *edges_px(self.photo))

    def at(self, points: npt.ArrayLike) -> Array:
        """Return the backward displacement at points of shape (N, 2), px, same shape."""
        points = np.asarray(points, np.float64)
        moved = self._head_at(points) if self.motion.strength else np.zeros_like(points)
        if self.lens.heads:
            moved = moved + self.lens.part_at(self.face_index, points + moved, self.neighbours_px)
        return moved

    def _head_at(self, points: Array) -> Array:
        """Return the displacement without lens correction at points of shape (N, 2), px.

        Outside the photo the displacement mirrors the one inside, so that the spline through such
        control points moves nothing across the edge.
        """
        # Where the outermost pixels end.
        low, high = edges_px(self.photo) + np.array([[-0.5], [0.5]])
        inside = np.where(points < low, 2.0 * low - points, points)
        inside = np.where(inside > high, 2.0 * high - inside, inside)
        moved = self.motion.at(inside)
        if not moved.any():  # another head, far away
            return np.zeros_like(points)
        moved = moved * self.free(inside)[:, None]
        room = np.maximum(0.0, np.minimum(inside - low, high - inside))
        moved = limited(moved, EDGE_SLOPE * self.motion.strength * room)
        return np.where((points < low) | (points > high), -moved, moved)

    def is_near(self, spans_px: Array) -> npt.NDArray[np.bool_]:
        """Return which boxes, (N, 2, 2): least and largest (x, y), are near the face. (N,)."""
        far = (_APART + _ALL) * self.face.anchor.spacing_px
        low, high = np.clip(self._around_head_px, *edges_px(self.photo))
        return np.asarray(
            ((spans_px[:, 1] > low - far) & (spans_px[:, 0] < high + far)).all(axis=1)
        )

    @cached_property
    def features(self) -> tuple[Array, Array, Array]:
        """Points round eyes and mouth, (M, 2), where they go, and how much they give way, (M,).

        Each feature is shifted by the displacement of its middle, and all are scaled alike. Without
        a displacement of the head, the points are those of lens correction, if any: the corners.
        """
        motion = self.motion
        if not isinstance(motion, HeadMotion) or not motion.shapes_features:
            if not self.lens.heads:
                return NOBODY, NOBODY, np.zeros(0)
            source, target = (
                np.vstack([face.eyes, face.mouth])
                for face in (self.lens.heads[self.face_index].face, self.face)
            )
            return source, target, np.full(len(source), _TOLERANCE)
        eyes, mouth = self.face.eyes, self.face.mouth
        rings = [_ring(eyes[:2], _EYE), _ring(eyes[2:], _EYE), _ring(mouth, _MOUTH)]
        source = np.vstack(rings)
        middles = np.array([ring.mean(axis=0) for ring in rings])
        shown = self.shown(middles)
        scale = 1.0 - _SHRINK * abs(motion.pairs.head_share)
        target = np.vstack(
            [
                there + scale * (ring - middle)
                for ring, middle, there in zip(rings, middles, shown, strict=True)
            ]
        )
        rho, _ = motion.rim.at(target)
        near = smoothstep((rho - _NEAR[0]) / (_NEAR[1] - _NEAR[0]))
        return source + self.lens.at(source), target, _TOLERANCE / np.maximum(1.0 - near, 1e-6)

    def shown(self, points: Array) -> Array:
        """Return where points of shape (N, 2) are shown, px: ``x + d(x) = point``."""
        return inverted(self._head_at, points, _STEPS)

    @cached_property
    def _hulls(self) -> tuple[Array, Array]:
        return head_corners(self.face), face_corners(self.face)

    def free(self, points: Array) -> Array:
        """Return 0 near what must not move, 1 far from it, at points of shape (N, 2).

        Within its own head nothing gives way, except to heads in front: nothing moves within
        these.
        """
        unit = self.face.anchor.spacing_px
        outer, inner = self._hulls
        outside = beyond(points, outer) / unit
        face = smoothstep(beyond(points, inner) / (_TOUCHED * unit))
        beside = smoothstep((away_px(points, self.neighbours_px) / unit - _APART) / _ALL)
        front = max((one.ahead for one in self.others if one.still), default=0.0)
        free = 1.0 - (1.0 - beside) * _mixed(smoothstep(outside / _TOUCHED), 1.0, front)
        rise = (_LEAST_RISE + _RISE * self.motion.strength) * unit
        for one in self.others:
            clear = smoothstep((beyond(points, one.face_px) / unit - _APART) / _ALL)
            # A face that stays shows up to this head's own face, others up to its hair.
            own = face if one.still else smoothstep(outside / _ALL)
            free *= 1.0 - (1.0 - clear) * _mixed(own, 1.0, one.ahead)
            if one.ahead:
                free *= _mixed(1.0, smoothstep(beyond(points, one.head_px) / rise), one.ahead)
        return np.asarray(free)


def give_way(
    pairs: Sequence[FacePairs], heads: Sequence[HeadField | None]
) -> tuple[FacePairs, ...]:
    """Return pairs that follow heads in front where these hide a landmark or touch it."""
    found, spans_px = [], _spans_px([pair.target_px for pair in pairs])
    for k, (pair, head) in enumerate(zip(pairs, heads, strict=True)):
        if head is None or not any(one.ahead for one in head.others):
            found.append(pair)
            continue
        points, span_px = pair.target_px, spans_px[k : k + 1]
        rest = (
            one
            for j, one in enumerate(heads)
            if j != k and one is not None and (one.lens.heads or one.is_near(span_px).any())
        )
        moved = sum((one.at(points) for one in rest), np.zeros_like(points))
        moves = _mixed(moved, pair.displacement_px, head.free(points)[:, None])
        found.append(dataclasses.replace(pair, target_px=pair.source_px - moves))
    return tuple(found)


def head_fields(
    faces: Sequence[Face],
    pairs: Sequence[FacePairs],
    recipes: Sequence[Recipe],
    photo: Box,
    neighbours_px: Sequence[Array] = (),
    lens: LensCorrection = NO_LENS,
    still: Sequence[Face] = (),
) -> tuple[HeadField | None, ...]:
    """Return the displacement of each head; None where landmarks alone move, or nothing does.

    `faces` and `pairs` are those after the correction by `lens`. `neighbours_px` are points of
    people beside each face, who don't go along (`Held.neighbours`); `still` are their faces.
    """
    fields: list[HeadField | None] = []
    everyone = (*faces, *still)
    rings, fronts = [face_corners(face) for face in everyone], ahead(everyone)
    spans_px = _spans_px(rings)
    for k, (face, pair, recipe) in enumerate(zip(faces, pairs, recipes, strict=True)):
        motion = motion_of(face, pair, recipe)
        beside = neighbours_px[k] if neighbours_px else NOBODY
        head = HeadField(face, motion, photo, beside, lens, k)
        if motion.strength:
            others = tuple(
                OtherHead(rings[j], head_corners(everyone[j]), float(fronts[j, k]), j >= len(faces))
                for j in np.flatnonzero(head.is_near(spans_px)).tolist()
                if j != k
            )
            head = dataclasses.replace(head, others=others)
        fields.append(head if motion.strength or lens.heads else None)
    return tuple(fields)


def motion_of(face: Face, pairs: FacePairs, recipe: Recipe) -> HeadMotion | OutlineMotion:
    """Return the motion of a head, or of the outline alone with scope "face"."""
    middle_px = shape_center(face, recipe)
    if recipe.scope == "face":
        still = dataclasses.replace(pairs, source_px=pairs.target_px)
        pairs = steep_part(pairs, face.anchor.spacing_px) if recipe.guard else still
        return OutlineMotion(Rim.of(face, pairs, middle_px, None))
    shape = Shape.of(face, recipe)
    return HeadMotion(face, pairs, middle_px, shape, Rim.of(face, pairs, middle_px, shape))


def forehead_pairs(face: Face, recipe: Recipe, pairs: FacePairs) -> tuple[Array, Array]:
    """Return the rim of the forehead and where it goes if nothing is in its way, (13, 2), px.

    Of shape (0, 2) where the face alone moves, or nobody marked the forehead.
    """
    if face.forehead is None or recipe.scope == "face":
        return np.zeros((0, 2)), np.zeros((0, 2))
    photo = Box(-(2**30), -(2**30), 2**30, 2**30)
    head = HeadField(face, motion_of(face, pairs, recipe), photo, NOBODY)
    return face.forehead, head.shown(face.forehead)


def _spans_px(points_px: Sequence[Array]) -> Array:
    """Return the least and the largest (x, y) of each of N sets of points, (N, 2, 2), px."""
    ends = [(points.min(axis=0), points.max(axis=0)) for points in points_px]
    return np.reshape(ends, (-1, 2, 2))


def _mixed(one: Array | float, other: Array | float, share: Array | float) -> Array:
    """Return `one` at a share of 0, `other` at 1, and values between."""
    return np.asarray(one + share * (other - one))


def _ring(corners: Array, shape: Array) -> Array:
    """Return points round a feature whose two corners are given, px."""
    half = (corners[1] - corners[0]) / 2.0
    aside = np.array([-half[1], half[0]])
    return np.asarray(corners.mean(axis=0) + shape @ np.stack([half, aside]))
