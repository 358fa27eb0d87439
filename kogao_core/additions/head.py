"""The displacement of a whole head: it shrinks as one body, and eyes and mouth keep their shape.

The paper's lattice moves the outline alone, so ears and temples are stretched. With `Recipe.scope`
"head" the control points take the displacement of the whole head *before* the landmarks are fitted
on top: the field stays one spline, and each landmark goes exactly to its target
(`docs/decisions/43`). The displacement is the sum of two parts:

- the head as one body: a similarity about the head's pivot (`faces.head`), whole up to `keep` and
  fading to nothing beyond;
- the shape: what the landmarks do beside that similarity, such as a narrower jaw. It is given in
  polar form about the middle of the face, by ``rho``, the distance over the distance of the edge
  of the face in that direction, after the warp.
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
from kogao_core.base.geometry import Array, Box, ramp, smoothstep
from kogao_core.faces.face import FOREHEAD_POINTS, Face
from kogao_core.faces.head import EDGE_SLOPE, HeadFrame, limited
from kogao_core.faces.reshape import across
from kogao_core.faces.targets import FacePairs, shape_center
from kogao_core.faces.zones import Shape, directions
from kogao_core.field.field import inverted
from kogao_core.field.protection import Stroke, Strokes, sampled
from kogao_core.recipe.recipe import Recipe

# The head moves whole up to this rho: straight up, which reaches past the crown, and straight
# down. Straight to the sides it is 1. Larger values move more hair, more neck.
_KEEP_UP: Final = 1.65
_KEEP_DOWN: Final = 1.05
_NARROW: Final = 6.0  # exponent of the cosine that bounds "down": larger, less of the shoulders
# A fade is this many times as wide as the displacement where it begins. Larger values squeeze the
# background less and move more of it.
_FADE: Final = 6.2
_FADE_DOWN: Final = 8.5  # the same straight down, where collar and shoulders follow a part
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
_BROWS: Final = 0.25  # it begins this far up from the eye line to the top of the forehead
_CROWN: Final = 1.25  # top of a forehead that nobody marked, in radii of the outline's ends
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
# A face that moves alone needs room beside its outline where a landmark moves more than this, in
# landmark spacings: none up to the first value, all from the second.
_STEEP: Final = (0.6, 0.9)
_ROOM: Final = 5.0  # width of that room, in moves; larger: less squeezed, more background moves
_DEPTH: Final = 0.4  # the rho from which it moves the face; larger: a steeper cheek
# Protected places up to this far from a landmark attract the pivot, in eyes-to-chin distances.
_ATTRACTED: Final = 0.5
# The pivot's own weight against a protected line as long as the eyes-to-chin distance.
_OWN_WEIGHT: Final = 0.25
_SAMPLES: Final = 20  # of such a line
_DIRECTIONS: Final = 73  # in which the ends of the displaced region are sampled
_TURN: Final = 2.0 * np.pi
_STEPS: Final = 3  # of a fixed-point iteration, each ten times nearer to the solution


@dataclass(frozen=True, eq=False)
class HeadDisplacement:
    """The displacement that one head asks of its control points, lens correction included."""

    face: Face  # after lens correction
    pairs: FacePairs  # the landmarks, their targets and the pivot
    middle_px: Array  # (2,): about which the face is shaped, before the warp
    photo: Box  # nothing moves across its edge
    shape: Shape | None  # what is requested of the face beside its warp distance
    neighbours_px: Array  # (M, 3): points of people beside, who don't go along (`PersonMask`)
    lens: LensCorrection = NO_LENS
    which: int = 0  # index of the face in `lens`
    others: tuple[OtherHead, ...] = ()  # other heads, near

    @cached_property
    def around_px(self) -> Array:
        """Corners (x, y) of a box outside which nothing moves, (2, 2), px; ignores the photo."""
        boxes = [head.around_px for head in self.lens.heads[self.which : self.which + 1]]
        if self.strength:
            boxes.append(self._around_head_px)
        return np.array([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]])

    @cached_property
    def _around_head_px(self) -> Array:
        """The same for the head without lens correction."""
        angles = np.linspace(-np.pi, np.pi, _DIRECTIONS)
        far = np.maximum(sum(self._keep_and_fade(angles)), sum(self._hair_keep_and_fade(angles)))
        far = far * self._rim.radius_px(angles)
        edge = self._rim.center_px + far[:, None] * _ways(angles, across(self.face))
        return np.array([edge.min(axis=0), edge.max(axis=0)])

    @property
    def corners_px(self) -> Array:
        """Corners of the part of that box in the photo; (2, 2)."""
        return np.clip(self.around_px, *edges_px(self.photo))

    def at(self, points: npt.ArrayLike) -> Array:
        """Return the backward displacement at points of shape (N, 2), px, same shape."""
        points = np.asarray(points, np.float64)
        moved = self._head_at(points) if self.strength else np.zeros_like(points)
        if self.lens.heads:
            moved = moved + self.lens.part_at(self.which, points + moved, self.neighbours_px)
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
        moved = self._moved(inside) * self.free(inside)[:, None]
        room = np.maximum(0.0, np.minimum(inside - low, high - inside))
        moved = limited(moved, EDGE_SLOPE * self.strength * room)
        return np.where((points < low) | (points > high), -moved, moved)

    def is_near(self, hull: Array) -> bool:
        """Return whether some of a hull of shape (K, 2) is near what surrounds the face."""
        far = (_APART + _ALL) * self.face.anchor.spacing_px
        low, high = np.clip(self._around_head_px, *edges_px(self.photo))
        return bool((hull.max(axis=0) > low - far).all() and (hull.min(axis=0) < high + far).all())

    @cached_property
    def features(self) -> tuple[Array, Array, Array]:
        """Points round eyes and mouth, (M, 2), where they go, and how much they give way, (M,).

        Each feature is shifted by the displacement of its middle, and all are scaled alike. Without
        a displacement of the head, the points are those of lens correction, if any: the corners.
        """
        head_moves = self.shape is not None or self.pairs.head_share
        if not head_moves and not self.lens.heads:
            return NOBODY, NOBODY, np.zeros(0)
        if not head_moves:
            source, target = (
                np.vstack([face.eyes, face.mouth])
                for face in (self.lens.heads[self.which].face, self.face)
            )
            return source, target, np.full(len(source), _TOLERANCE)
        eyes, mouth = self.face.eyes, self.face.mouth
        rings = [_ring(eyes[:2], _EYE), _ring(eyes[2:], _EYE), _ring(mouth, _MOUTH)]
        source = np.vstack(rings)
        middles = np.array([ring.mean(axis=0) for ring in rings])
        shown = self._shown(middles)
        scale = 1.0 - _SHRINK * abs(self.pairs.head_share)
        target = np.vstack(
            [
                there + scale * (ring - middle)
                for ring, middle, there in zip(rings, middles, shown, strict=True)
            ]
        )
        rho, _ = self._rim.at(target)
        near = smoothstep((rho - _NEAR[0]) / (_NEAR[1] - _NEAR[0]))
        return source + self.lens.at(source), target, _TOLERANCE / np.maximum(1.0 - near, 1e-6)

    def _shown(self, points: Array) -> Array:
        """Return where points of shape (N, 2) are shown, px: ``x + d(x) = point``."""
        return inverted(self._head_at, points, _STEPS)

    @cached_property
    def _rim(self) -> _FaceBoundary:
        return _FaceBoundary.of(self.face, self.pairs, self.middle_px, self.shape)

    @property
    def strength(self) -> float:
        """How far the head and its shape move, as a share of the distance to the pivot."""
        shape = self.shape
        parts = () if shape is None else (shape.aside, shape.down, shape.hairline, *shape.zones)
        return abs(self.pairs.head_share) + float(np.abs([0.0, *parts]).max())

    def _keep_and_fade(self, angles: Array) -> tuple[Array, Array]:
        """Return in directions of shape (N,) the rho where a fade begins, and its width in rho."""
        rim = self._rim
        up = smoothstep(np.interp(angles, rim.angles, rim.upwards))
        down = np.clip(np.cos(angles), 0.0, 1.0) ** _NARROW
        return self._faded(angles, 1.0 + (_KEEP_UP - 1.0) * up + (_KEEP_DOWN - 1.0) * down)

    def _hair_keep_and_fade(self, angles: Array) -> tuple[Array, Array]:
        """Return the same for the move of the hairline."""
        rim = self._rim
        if not rim.hairline_px.any():
            return np.ones_like(angles), np.zeros_like(angles)
        up = np.interp(angles, rim.angles, rim.upwards) / _HAIR
        return self._faded(angles, 1.0 + (_KEEP_UP - 1.0) * smoothstep(up))

    def _faded(self, angles: Array, keep: Array) -> tuple[Array, Array]:
        rim, size = self._rim, HeadFrame.of(self.face).height_px
        down = np.clip(np.cos(angles), 0.0, 1.0) ** _NARROW
        radius = rim.radius_px(angles)
        ends = rim.center_px + (keep * radius)[:, None] * _ways(angles, rim.across)
        moves = rim.moved_px(angles, rim.moves_px + rim.hairline_px)
        wide = np.hypot(*(_similarity(self.pairs, ends) + keep[:, None] * moves).T)
        wide *= _FADE + (_FADE_DOWN - _FADE) * down
        least = (_LEAST_FADE + _SIDE_FADE * np.abs(np.sin(angles)) ** 3) * size
        least *= _SOFT + (1.0 - _SOFT) * self.strength / _WIDE
        return keep, (wide**4 + least**4) ** 0.25 / radius

    def _moved(self, points: Array) -> Array:
        rim = self._rim
        rho, angles = rim.at(points)
        keep, fade = self._keep_and_fade(angles)
        outside = 1.0 - ramp((rho - keep) / fade)
        moved = _similarity(self.pairs, points) * outside[:, None]
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
        keep, fade = self._hair_keep_and_fade(angles)
        # The hairline's move is that of places before the warp.
        hair = _hairline(self.face, self.middle_px, self.shape, points)
        hair = _hairline(self.face, self.middle_px, self.shape, points + hair)
        return np.asarray(moved + hair * (1.0 - ramp((rho - keep) / fade))[:, None])

    def free(self, points: Array) -> Array:
        """Return 0 near what must not move, 1 far from it, at points of shape (N, 2).

        Within its own head nothing gives way, except to heads in front: nothing moves within
        these.
        """
        unit = self.face.anchor.spacing_px
        outside = beyond(points, head_corners(self.face)) / unit
        face = smoothstep(beyond(points, face_corners(self.face)) / (_TOUCHED * unit))
        beside = smoothstep((away_px(points, self.neighbours_px) / unit - _APART) / _ALL)
        front = max((one.ahead for one in self.others if one.still), default=0.0)
        free = 1.0 - (1.0 - beside) * _mixed(smoothstep(outside / _TOUCHED), 1.0, front)
        rise = (_LEAST_RISE + _RISE * self.strength) * unit
        for one in self.others:
            clear = smoothstep((beyond(points, one.face_px) / unit - _APART) / _ALL)
            # A face that stays shows up to this head's own face, others up to its hair.
            own = face if one.still else smoothstep(outside / _ALL)
            free *= 1.0 - (1.0 - clear) * _mixed(own, 1.0, one.ahead)
            if one.ahead:
                free *= _mixed(1.0, smoothstep(beyond(points, one.head_px) / rise), one.ahead)
        return np.asarray(free)


class OutlineDisplacement(HeadDisplacement):
    """Room beside the outline of a face that moves alone, for the steep part of its moves."""

    @classmethod
    def steep(cls, pairs: FacePairs, spacing_px: float) -> FacePairs:
        """Return pairs with the part of each move that needs room."""
        length = np.hypot(*pairs.displacement_px.T) / spacing_px
        share = smoothstep((length - _STEEP[0]) / (_STEEP[1] - _STEEP[0]))
        moves = share[:, None] * pairs.displacement_px
        return dataclasses.replace(pairs, source_px=pairs.target_px + moves)

    @property
    def strength(self) -> float:
        """How far the outline moves, as a share of its distance to the middle."""
        moves = np.hypot(*self.pairs.displacement_px.T)
        return float(moves.max() / self._rim.radii_px.mean())

    def _keep_and_fade(self, angles: Array) -> tuple[Array, Array]:
        width = _ROOM * np.hypot(*self._rim.moved_px(angles, self._rim.moves_px).T)
        return np.ones_like(angles), np.maximum(width, 1e-6) / self._rim.radius_px(angles)

    def _moved(self, points: Array) -> Array:
        rho, angles = self._rim.at(points)
        keep, fade = self._keep_and_fade(angles)
        within, outside = (rho - _DEPTH) / (1.0 - _DEPTH), 1.0 - ramp((rho - keep) / fade)
        share = np.where(rho < 1.0, smoothstep(within), outside)
        return self._rim.moved_px(angles, self._rim.moves_px) * share[:, None]


@dataclass(frozen=True, slots=True, eq=False)
class _FaceBoundary:
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
    def of(cls, face: Face, pairs: FacePairs, middle: Array, shape: Shape | None) -> _FaceBoundary:
        right, share = across(face), pairs.head_share
        center = middle + share * (pairs.center_px - middle)
        rest = pairs.displacement_px - _similarity(pairs, pairs.target_px)
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
            hairline = _hairline(face, middle, shape, forehead)
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


def giving_way(
    pairs: Sequence[FacePairs], surrounds: Sequence[HeadDisplacement | None]
) -> tuple[FacePairs, ...]:
    """Return pairs that follow heads in front where these hide a landmark or touch it."""
    found = []
    for k, (pair, head) in enumerate(zip(pairs, surrounds, strict=True)):
        if head is None or not any(one.ahead for one in head.others):
            found.append(pair)
            continue
        points = pair.target_px
        rest = (one for j, one in enumerate(surrounds) if j != k and one is not None)
        moved = sum((one.at(points) for one in rest), np.zeros_like(points))
        moves = _mixed(moved, pair.displacement_px, head.free(points)[:, None])
        found.append(dataclasses.replace(pair, target_px=pair.source_px - moves))
    return tuple(found)


def near_fixed(
    pairs: Sequence[FacePairs], faces: Sequence[Face], strokes: Strokes, still: Sequence[Face] = ()
) -> tuple[FacePairs, ...]:
    """Move pivots towards protected places and heads in front nearby, and all targets alike.

    A head that shrinks about such a place moves little there and keeps its shape. Targets placed by
    hand stay.
    """
    if not pairs or not (strokes or still or len(pairs) > 1):
        return tuple(pairs)
    sizes, found = [HeadFrame.of(face).height_px for face in faces], []
    step_px, heads = min(sizes) / _SAMPLES, (*faces, *still)
    protected = [sampled(strokes, step_px)] if strokes else []
    rings = [Stroke(np.vstack([ring := head_corners(one), ring[:1]])) for one in heads]
    edges = [(one, sampled([ring], step_px)) for one, ring in zip(heads, rings, strict=True)]
    for pair, face, size in zip(pairs, faces, sizes, strict=True):
        front = [edge * (1.0, 1.0, ahead(one, face), 1.0) for one, edge in edges]
        every = np.vstack([*protected, *front])
        reach = every[:, 3:] + _ATTRACTED * size
        low, high = face.points.min(axis=0) - reach, face.points.max(axis=0) + reach
        near = every[((every[:, :2] > low) & (every[:, :2] < high)).all(axis=1)]
        places, (lengths, radii) = near[:, :2], near[:, 2:].T
        away = (away_px(places, face.points) - radii) / (_ATTRACTED * size)
        weights = lengths / size * smoothstep(1.0 - away)
        shift = weights @ (places - pair.center_px) / (_OWN_WEIGHT + weights.sum())
        moved = pair.target_px + pair.head_share * shift
        if face.targets is not None:
            moved = np.where(np.isnan(face.targets), moved, pair.target_px)
        center = pair.center_px + (shift if pair.head_share else 0.0)
        found.append(dataclasses.replace(pair, target_px=moved, center_px=center))
    return tuple(found)


def surrounds_of(
    faces: Sequence[Face],
    pairs: Sequence[FacePairs],
    recipes: Sequence[Recipe],
    photo: Box,
    neighbours_px: Sequence[Array] = (),
    lens: LensCorrection = NO_LENS,
    still: Sequence[Face] = (),
) -> tuple[HeadDisplacement | None, ...]:
    """Return the displacement of each head; None where landmarks alone move, or nothing does.

    `faces` and `pairs` are those after the correction by `lens`. `neighbours_px` are points of
    people beside each face, who don't go along (`Held.neighbours`); `still` are their faces.
    """
    found: list[HeadDisplacement | None] = []
    everyone = [(one, face_corners(one)) for one in (*faces, *still)]
    for k, (face, pair, recipe) in enumerate(zip(faces, pairs, recipes, strict=True)):
        beside = neighbours_px[k] if neighbours_px else NOBODY
        kind, shape, middle = HeadDisplacement, Shape.of(face, recipe), shape_center(face, recipe)
        if recipe.scope == "face":
            kind, shape = OutlineDisplacement, None
            room = OutlineDisplacement.steep(pair, face.anchor.spacing_px)
            pair = room if recipe.guard else dataclasses.replace(pair, source_px=pair.target_px)
        head = kind(face, pair, middle, photo, shape, beside, lens, k)
        if head.strength:
            others = tuple(
                OtherHead(ring, head_corners(one), ahead(one, face), j >= len(faces))
                for j, (one, ring) in enumerate(everyone)
                if j != k and head.is_near(ring)
            )
            head = dataclasses.replace(head, others=others)
        found.append(head if head.strength or lens.heads else None)
    return tuple(found)


def forehead_pairs(face: Face, recipe: Recipe, pairs: FacePairs) -> tuple[Array, Array]:
    """Return the rim of the forehead and where it goes if nothing is in its way, (13, 2), px.

    Of shape (0, 2) where the face alone moves, or nobody marked the forehead.
    """
    if face.forehead is None or recipe.scope == "face":
        return np.zeros((0, 2)), np.zeros((0, 2))
    photo, shape = Box(-(2**30), -(2**30), 2**30, 2**30), Shape.of(face, recipe)
    head = HeadDisplacement(face, pairs, shape_center(face, recipe), photo, shape, NOBODY)
    return face.forehead, head._shown(face.forehead)


def _similarity(pairs: FacePairs, points: Array) -> Array:
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
    return np.asarray(center + far[:, None] * _ways(turn, right))


def _hairline(face: Face, middle: Array, shape: Shape, points: Array) -> Array:
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


def _mixed(one: Array | float, other: Array | float, share: Array | float) -> Array:
    """Return `one` at a share of 0, `other` at 1, and values between."""
    return np.asarray(one + share * (other - one))


def _ways(angles: Array, right: Array) -> Array:
    """Return unit vectors, (N, 2), in directions from straight down, radians."""
    below = np.array([-right[1], right[0]])
    return np.asarray(np.outer(np.sin(angles), right) + np.outer(np.cos(angles), below))


def _ring(corners: Array, shape: Array) -> Array:
    """Return points round a feature whose two corners are given, px."""
    half = (corners[1] - corners[0]) / 2.0
    aside = np.array([-half[1], half[0]])
    return np.asarray(corners.mean(axis=0) + shape @ np.stack([half, aside]))


def _seen_from(points: Array, center: Array, right: Array) -> tuple[Array, Array]:
    """Return directions from straight down, radians, and distances, px, of points (N, 2)."""
    degrees, far = directions(points, center, right)
    return np.radians(degrees), far
