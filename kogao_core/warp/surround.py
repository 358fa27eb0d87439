"""What surrounds a face goes along with it: ears, temples, hair, neck; eyes and mouth keep shape.

The paper's lattice brings the displacement from whole to nothing within two spacings beside the
outline, so ears and temples are stretched. Here the control points take a displacement over the
whole head *before* the landmarks are fitted on top: it stays one spline, and each landmark goes
exactly where it did (`docs/decisions/43`). It is given in polar form round the centre, by ``rho``,
the distance there over the distance of the edge of the face in that direction, after the warp:

- outside, whole up to `keep` (the rim of the ears travels with the cheek), then fading to nothing
  at `out`; above the outline's ends towards a smaller share;
- inside, with the features kept, heights shrink evenly, so a line from temple to temple stays
  straight, and widths from the outline inwards to nothing.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, ramp, smoothstep
from kogao_core.faces.face import FOREHEAD_POINTS, Face
from kogao_core.faces.reshape import across
from kogao_core.faces.targets import Pairs
from kogao_core.faces.zones import Shape, directions
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.field import shown_by
from kogao_core.warp.frame import edges_px
from kogao_core.warp.protection import Protection, away_px


@dataclass(frozen=True, slots=True)
class Reach:
    """How far outside the face all goes along (`keep`), in rho, and how softly that ends (`fade`).

    At the sides, straight up, and straight down. A fade is multiplied by the softness that the
    warp distance needs. `top` is the share that the top of the forehead goes of what the outline's
    ends go.
    """

    keep: float
    fade: float
    keep_up: float
    fade_up: float
    keep_down: float
    fade_down: float
    top: float

    def mixed(self, other: Reach, share: float) -> Reach:
        """Return the reach a share of the way to another."""
        ends = ((getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return Reach(*(a + share * (b - a) for a, b in ends))


# Chosen by looking at faces at 4 to 10 %, and by what `docs/decisions/43` measures.
NATURAL: Final = Reach(1.2, 1.0, 1.08, 0.8, 1.05, 0.8, top=0.5)
WHOLE: Final = Reach(1.6, 1.5, 1.5, 1.2, 1.05, 1.2, top=1.0)
# In mean radii of the face: a fade's width where nothing moves, and more for each share of it that
# things move. So a small warp reaches no farther than it must, and a large one is no steeper.
_FADE: Final = (0.1, 5.0)
NATURAL_PERCENT: Final = 50.0  # of `Recipe.head_follows`: `NATURAL`; above it grows to `WHOLE`
# Without anything outside, what the features need fades out so far beside the face.
_SHORT: Final = 0.35
_INNER: Final = 0.6  # within this rho widths stay
_CROWN: Final = 1.25  # an unknown forehead's top, in radii of the outline's ends
# Of the mean radius: so far inside the photo all goes along, at its edge nothing.
_EDGE: Final = 0.6
# In landmark spacings: so near to other faces and protected places nothing, so much farther all.
_APART: Final = 1.0
_ALL: Final = 3.0
# A ring of points round each feature, in half its width along and across it.
_EYE: Final = np.array(
    [(-1.15, 0), (-0.5, 0.55), (0.5, 0.55), (1.15, 0), (0.5, -0.55), (-0.5, -0.55)]
)
_MOUTH: Final = np.array([(-1, 0), (-0.4, 0.3), (0.4, 0.3), (1, 0), (0.4, -0.3), (-0.4, -0.3)])
# Features get smaller by this share of what the face does: so they keep off its edge.
_SHRINK: Final = 0.4
# How little a feature gives way to the outline, and from which rho on it does so more and more.
_SLACK: Final = 0.01
_NEAR: Final = (0.75, 1.0)
_DIRECTIONS: Final = 73  # in which the ends of what moves are sought
_TURN: Final = 2.0 * np.pi
_STEPS: Final = 3  # of a fixed point that comes ten times nearer with each


@dataclass(frozen=True, eq=False)
class Surround:
    """The displacement that one face asks of the control points round it."""

    face: Face  # what surrounds it
    pairs: Pairs  # where its landmarks go
    follows: float  # `Recipe.head_follows` as a share: 0 nothing outside the face, 1 the whole head
    keeps_features: bool  # whether eyes and mouth keep their shape
    photo: Box  # nothing moves across its edge
    protection: Protection  # places that must not move
    neighbours_px: Array = dataclasses.field(default_factory=lambda: np.zeros((0, 2)))
    hulls: tuple[Array, ...] = ()  # (K, 2): of other faces, corners in order, px
    shape: Shape | None = None  # what is asked of the face beside its warp distance

    @cached_property
    def around_px(self) -> Array:
        """Least and greatest (x, y) of places that move, (2, 2), px; the photo's edge is no end."""
        angles = np.linspace(-np.pi, np.pi, _DIRECTIONS)
        keep, fade = self._keep_and_fade(angles)
        rho = np.maximum(keep + fade, 1.0 + _SHORT)
        far = rho * self._rim.radius_px(angles)
        edge = self.pairs.center_px + far[:, None] * _ways(angles, across(self.face))
        return np.array([edge.min(axis=0), edge.max(axis=0)])

    @property
    def corners_px(self) -> Array:
        """The same, as far as it lies in the photo; (2, 2)."""
        return np.clip(self.around_px, *edges_px(self.photo))

    def at(self, points: npt.ArrayLike) -> Array:
        """Return the backward displacement at points of shape (N, 2), px, same shape."""
        points = np.asarray(points, np.float64)
        moved = self._polar(points) * self._free(points)[:, None]
        low, high = edges_px(self.photo)
        inside = np.minimum(points - low, high - points) + 0.5  # where the outermost pixels end
        return np.asarray(moved * ramp(inside / (_EDGE * float(self._rim.radii_px.mean()))))

    def is_near(self, hull: Array) -> bool:
        """Return whether some of a hull of shape (K, 2) is near what surrounds the face."""
        far = (_APART + _ALL) * self.face.anchor.spacing_px
        low, high = self.corners_px
        return bool((hull.max(axis=0) > low - far).all() and (hull.min(axis=0) < high + far).all())

    @cached_property
    def features(self) -> tuple[Array, Array, Array]:
        """Points round eyes and mouth, (M, 2), where they go, and how much they give way, (M,).

        Each feature is shifted by as much as its middle, and all are scaled alike; none where
        features aren't kept.
        """
        if not self.keeps_features:
            return np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0)
        eyes, mouth = self.face.eyes, self.face.mouth
        rings = [_ring(eyes[:2], _EYE), _ring(eyes[2:], _EYE), _ring(mouth, _MOUTH)]
        source = np.vstack(rings)
        middles = np.array([ring.mean(axis=0) for ring in rings])
        shown = self._shown(middles)
        scale = 1.0 - _SHRINK * float(np.abs(_end_shares(self.pairs, self.shape)).mean())
        target = np.vstack(
            [
                there + scale * (ring - middle)
                for ring, middle, there in zip(rings, middles, shown, strict=True)
            ]
        )
        rho, _ = self._rim.at(target)
        near = smoothstep((rho - _NEAR[0]) / (_NEAR[1] - _NEAR[0]))
        return source, target, _SLACK / np.maximum(1.0 - near, 1e-6)

    def _shown(self, points: Array) -> Array:
        """Return where points of shape (N, 2) are shown, px: ``x + d(x) = point``."""
        return shown_by(self.at, points, _STEPS)

    @cached_property
    def _reach(self) -> Reach:
        beyond = max(0.0, 100.0 * self.follows / NATURAL_PERCENT - 1.0)
        return NATURAL.mixed(WHOLE, beyond / (100.0 / NATURAL_PERCENT - 1.0))

    @cached_property
    def _softness(self) -> float:
        """Width of a fade in mean radii of the face."""
        rim = self._rim
        moved = np.hypot(*(rim.moves_px + rim.hairline_px).T).max() / float(rim.radii_px.mean())
        return float(_FADE[0] + _FADE[1] * moved)

    @cached_property
    def _rim(self) -> _Rim:
        return _Rim.of(self.face, self.pairs, self._reach.top, self.shape)

    def _keep_and_fade(self, angles: Array) -> tuple[Array, Array]:
        """Return in directions of shape (N,) where a fade begins, and how wide it is, rho."""
        reach, up = self._reach, smoothstep(self._rim.up(angles))
        down = np.clip(np.cos(angles), 0.0, 1.0) ** 2
        keep = reach.keep + (reach.keep_up - reach.keep) * up
        fade = reach.fade + (reach.fade_up - reach.fade) * up
        keep = keep + (reach.keep_down - reach.keep) * down
        fade = fade + (reach.fade_down - reach.fade) * down
        return keep, fade * self._softness

    def _polar(self, points: Array) -> Array:
        rim = self._rim
        rho, angles = rim.at(points)
        keep, fade = self._keep_and_fade(angles)
        amount = min(1.0, 100.0 * self.follows / NATURAL_PERCENT)
        fading = 1.0 - ramp((rho - keep) / fade)
        outside = amount * fading
        inner = smoothstep((rho - _INNER) / (1.0 - _INNER))
        if self.keeps_features:
            outside = outside + (1.0 - amount) * (1.0 - ramp((rho - 1.0) / _SHORT))
            wide, high = inner, np.ones_like(rho)
        else:
            wide = high = amount * inner
        right = across(self.face)
        below = np.array([-right[1], right[0]])
        moved = rim.displacement_px(angles) * rho[:, None]
        is_inside = rho < 1.0
        aside = (moved @ right) * np.where(is_inside, wide, outside)
        downwards = (moved @ below) * np.where(is_inside, high, outside)
        whole = np.outer(aside, right) + np.outer(downwards, below)
        if not rim.hairline_px.any():
            return whole
        # The hairline takes what is above it along, whatever else follows.
        hairline = rim.hairline(angles) * (rho * np.where(is_inside, inner, fading))[:, None]
        return np.asarray(whole + hairline)

    def _free(self, points: Array) -> Array:
        """Return 0 near what must not move, 1 far from it."""
        away = away_px(points, self.protection, self.neighbours_px)
        for hull in self.hulls:
            away = np.minimum(away, _beyond(points, hull))
        return smoothstep((away / self.face.anchor.spacing_px - _APART) / _ALL)


@dataclass(frozen=True, slots=True, eq=False)
class _Rim:
    """The closed edge of a face after the warp, by ascending direction, and how far it moved.

    Directions are from straight down, in radians; `upwards` is 0 at the outline's ends and below,
    1 at the top of the forehead.
    """

    center_px: Array
    across: Array
    angles: Array
    radii_px: Array
    moves_px: Array
    hairline_px: Array  # what the top of the forehead moves by itself
    upwards: Array

    @classmethod
    def of(cls, face: Face, pairs: Pairs, top: float, shape: Shape | None) -> _Rim:
        center, right = pairs.center_px, across(face)
        forehead = _forehead(face, center)
        height = 1.0 - np.abs(2.0 * np.linspace(0.0, 1.0, FOREHEAD_POINTS + 2)[1:-1] - 1.0)
        less = 1.0 - (1.0 - top) * smoothstep(height)
        share, away = _end_shares(pairs, shape) * less, forehead - center
        moves, hairline = share[:, None] * away, np.zeros_like(away)
        if shape is not None:
            # Of parts of the outline the forehead follows in width alone.
            moves = moves + less[:, None] * shape.scaled(
                away, aside=_between(*shape.zones[[0, -1]])
            )
            below = shape.axes[1]
            hairline = np.outer(shape.hairline * smoothstep(height) * (away @ below), below)
        rim = np.vstack([pairs.target_px, forehead - moves - hairline])
        angles, radii = _seen_from(rim, center, right)
        order = np.argsort(angles, kind="stable")
        order = np.concatenate([order[-1:], order, order[:1]])  # once round, and a step on
        angles = angles[order] + np.concatenate([[-_TURN], np.zeros(len(rim)), [_TURN]])
        moves = np.vstack([pairs.displacement_px, moves])[order]
        hairline = np.vstack([np.zeros_like(pairs.target_px), hairline])[order]
        upwards = np.concatenate([np.zeros(len(pairs.target_px)), height])[order]
        radii = np.maximum(radii[order], 1e-3 * max(1e-9, float(radii.max())))
        return cls(center, right, angles, radii, moves, hairline, upwards)

    def at(self, points: Array) -> tuple[Array, Array]:
        """Return rho and direction, radians, of points of shape (N, 2)."""
        angles, far = _seen_from(points, self.center_px, self.across)
        return far / self.radius_px(angles), angles

    def radius_px(self, angles: Array) -> Array:
        """Return how far the rim is from the centre in directions of shape (N,)."""
        return self._round(angles, self.radii_px)

    def displacement_px(self, angles: Array) -> Array:
        """Return the backward displacement of the rim in directions of shape (N,); (N, 2), px."""
        return np.stack([self._round(angles, move) for move in self.moves_px.T], axis=-1)

    def hairline(self, angles: Array) -> Array:
        """Return what the hairline adds to that."""
        return np.stack([self._round(angles, move) for move in self.hairline_px.T], axis=-1)

    def up(self, angles: Array) -> Array:
        """Return `upwards` in directions of shape (N,)."""
        return self._round(angles, self.upwards)

    def _round(self, angles: Array, values: Array) -> Array:
        return np.interp(angles, self.angles, values)


def surrounds_of(
    faces: Sequence[Face],
    pairs: Sequence[Pairs],
    recipes: Sequence[Recipe],
    photo: Box,
    protection: Protection,
    neighbours_px: Sequence[Array] = (),
) -> tuple[Surround | None, ...]:
    """Return what surrounds each face; None where its recipe asks for the paper's field.

    `neighbours_px` are points of people beside each face, who don't go along (`Held.neighbours`).
    """
    hulls = [_hull(face) for face in faces] if len(faces) > 1 else []
    found: list[Surround | None] = []
    for k, (face, pair, recipe) in enumerate(zip(faces, pairs, recipes, strict=True)):
        follows, keeps = recipe.head_follows / 100.0, recipe.keep_features
        shape = Shape.of(face, recipe)
        hairline = shape is not None and shape.hairline != 0.0
        if not hairline and (not (follows or keeps) or not pair.displacement_px.any()):
            found.append(None)
            continue
        others_px = neighbours_px[k] if neighbours_px else np.zeros((0, 2))
        around = photo, protection, others_px
        surround = Surround(face, pair, follows, keeps, *around, shape=shape)
        others = (hull for other, hull in enumerate(hulls) if other != k)
        near = tuple(hull for hull in others if surround.is_near(hull))
        found.append(dataclasses.replace(surround, hulls=near))
    return tuple(found)


def forehead_pairs(face: Face, recipe: Recipe, pairs: Pairs) -> tuple[Array, Array]:
    """Return the rim of the forehead and where it goes if nothing is in its way, (13, 2), px.

    Of shape (0, 2) where nothing follows, or nobody saw the forehead.
    """
    follows, shape = recipe.head_follows / 100.0, Shape.of(face, recipe)
    if face.forehead is None or (follows <= 0.0 and not recipe.forehead_height):
        return np.zeros((0, 2)), np.zeros((0, 2))
    photo = Box(-(2**30), -(2**30), 2**30, 2**30)
    surround = Surround(face, pairs, follows, False, photo, Protection(), shape=shape)
    return face.forehead, surround._shown(face.forehead)


def _end_shares(pairs: Pairs, shape: Shape | None) -> Array:
    """Return which share of the way to the centre points of the forehead go, from end to end.

    Without what `shape` asks for.
    """
    away = pairs.source_px - pairs.center_px
    moves = pairs.displacement_px
    if shape is not None:
        moves = moves - shape.inwards(away)
    away, moves = away[[0, -1]], moves[[0, -1]]
    return _between(*(moves * away).sum(axis=1) / np.maximum((away**2).sum(axis=1), 1e-12))


def _between(first: float, last: float) -> Array:
    """Return values for the points of the forehead that pass from one end to the other."""
    along = smoothstep(np.linspace(0.0, 1.0, FOREHEAD_POINTS + 2)[1:-1])
    return np.asarray(first + (last - first) * along)


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
