"""A rectilinear lens stretches what lies off its axis; a head comes out as if aimed at.

A sphere at an angle t from the axis is drawn 1 / cos t longer away from the middle than across. Had
the camera been aimed at the head, the picture would be another by the homography ``K R K^-1`` for
all that is far enough (Hartley and Zisserman 2004, 8.4): where that shows the head, at the size
that it has across, is a displacement for all of it, hair and ears included. The control points take
it before the landmarks are fitted on top, as they do what surrounds a face (`surround`). Beyond the
head it fades: neck, shoulders and background take up the difference. A head's place is free: it
is chosen so that what is beside it, other heads and the photo's edge, is stretched the least.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, ramp
from kogao_core.base.language import Text
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across
from kogao_core.photo.optics import FILM_MM
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.field import shown_by
from kogao_core.warp.frame import edges_px
from kogao_core.warp.protection import Protection, away_px
from kogao_core.warp.surround import Surround

# A head with its hair is a circle, in landmark spacings: so far above the middle of eyes and mouth,
# and so large.
_ABOVE: Final = 1.5
_RADIUS: Final = 7.0
_FADE: Final = 2.5  # in radii of that circle: what is beyond it takes up the difference
# Where heads overlap a point goes with the nearer one by this power of the distance; between them
# its share goes from one to the other over all the gap.
_SHARP: Final = 8
_RIM: Final = 0.02
_GAP: Final = 1.5
_EDGE: Final = 0.3  # in the same: so near to the photo's edge what crosses it fades at the nearest
# From so many radii on from the photo's edge a head's rim stays more and more, and not that edge.
_NEAR_EDGE: Final = 1.5
# In radii from middle to middle: so near, heads go together with this weight; so far, not at all.
_CLOSE: Final = 2.0
_ALONE: Final = 3.0
_TOGETHER: Final = 12.0
_KEPT: Final = 10.0  # and this for its own place at the photo's edge
_LEAST_DEPTH: Final = 0.2  # of the distance to the picture's plane; what is nearer is far outside
_STEPS: Final = 12  # of a fixed point that comes five times nearer with each
_SLACK: Final = 0.01
STRETCH_SEEN_PERCENT: Final = 1.0  # that is worth a look
# What an adult measures, m: between the outer corners of the eyes, and from the eyes down to the
# mouth. By the size of their irises, 112 of 118 people are within a tenth.
_ADULT_M: Final = np.array([0.087, 0.068])
_WITHIN: Final = 0.1
_NOSE_M: Final = 0.04  # its tip before the eyes' corners; the face is widest as far behind them
_NATURAL_M: Final = 1.5  # from so far a nose looks as people know it
NOSE_SEEN_PERCENT: Final = 5.0  # that is worth saying


def focal_px(focal_mm: float, photo: Box) -> float:
    """Return a 35-mm equivalent focal length in px of a photo: by the diagonals."""
    return focal_mm * float(np.hypot(photo.width, photo.height)) / FILM_MM


def stretch_percent(face: Face, focal_mm: float, photo: Box) -> float:
    """Return how much longer a lens draws a face away from the middle than across, %."""
    off = np.asarray(face.anchor.origin_px) - edges_px(photo).mean(axis=0)
    return 100.0 * (float(np.hypot(np.hypot(*off) / focal_px(focal_mm, photo), 1.0)) - 1.0)


def distance_m(face: Face, focal_mm: float, photo: Box) -> float:
    """Return how far the camera was from a face, if it is an adult's, m: by the angles it fills.

    A head that is turned is seen less wide, one that nods less high: what shows more of it counts.
    """
    ends = np.array([face.eyes[[0, 3]], [face.eye_center, face.mouth_center]])
    rays = np.dstack(
        [ends - edges_px(photo).mean(axis=0), np.full((2, 2), focal_px(focal_mm, photo))]
    )
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    return float((_ADULT_M / np.linalg.norm(rays[:, 0] - rays[:, 1], axis=1)).min())


def distance_range_m(distance: float) -> tuple[float, float]:
    """Return between which distances nearly all adults are who seem so far away."""
    return distance * (1.0 - _WITHIN), distance * (1.0 + _WITHIN)


def nose_percent(distance: float) -> float:
    """Return how much larger, beside the face's width, a nose looks than from 1.5 m, %."""
    near, natural = ((d + _NOSE_M) / max(d - _NOSE_M, _NOSE_M) for d in (distance, _NATURAL_M))
    return 100.0 * (near / natural - 1.0)


def distance_note(distance: float) -> str:
    """Return how far away the camera was, and what that makes of a nose where it is seen."""
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
    """The displacement that takes the lens' stretch out of one head."""

    face: Face
    focal_px: float
    photo: Box
    share: float = 1.0  # how much of the stretch is taken out
    company: float = 0.0  # how near others are, 0 to 1
    aside_px: Array = dataclasses.field(default_factory=lambda: np.zeros(2))  # what they ask

    @cached_property
    def center_px(self) -> Array:
        """The middle of the circle that the head fills where it is shown."""
        right = across(self.face)
        above = _ABOVE * self.face.anchor.spacing_px * np.array([right[1], -right[0]])
        return np.asarray(self.face.anchor.origin_px + above + self.aside_px)

    @property
    def radius_px(self) -> float:
        """The circle's radius."""
        return _RADIUS * self.face.anchor.spacing_px

    @cached_property
    def around_px(self) -> Array:
        """Corners of a box outside which all is 0, (2, 2)."""
        far = (1.0 + _FADE) * self.radius_px
        return np.array([self.center_px - far, self.center_px + far])

    @cached_property
    def room_px(self) -> float:
        """How far from the head's middle the photo ends, away from the photo's middle."""
        low, high = edges_px(self.photo)
        way = np.maximum(np.abs(self.face.anchor.origin_px - (low + high) / 2.0), 1e-9)
        far = float(np.hypot(*way))
        return max(0.0, float(((high - low) / 2.0 * far / way).min()) - far)

    @cached_property
    def _aimed(self) -> tuple[Array, Array]:
        """The homography from the head as it is shown to where it is, (3, 3); its shift, (2,), px.

        Alone, it goes outwards so far that what is beside it is stretched alike on either side; in
        company, so far that its rim stays. The photo's edge stays where that is nearer.
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
        stays = alone + (rim - alone) * self.company
        shift = stays - f * np.tan(np.arctan2(far + stays, f) - angle) / np.cos(angle)
        scale = np.diag([np.cos(angle), np.cos(angle), 1.0])
        lens = np.diag([f, f, 1.0])
        back = _shift(middle) @ lens @ turn @ np.linalg.inv(lens) @ scale @ _shift(-origin)
        return np.asarray(back), self.share * shift * way

    def undistorted(self, points: npt.ArrayLike) -> Array:
        """Return the backward displacement of the head at points of shape (N, 2), px."""
        homography, shift = self._aimed
        shift = shift + self.aside_px
        points = np.asarray(points, np.float64) - shift
        seen = np.column_stack([points, np.ones(len(points))]) @ homography.T
        back = seen[:, :2] / np.maximum(seen[:, 2:], _LEAST_DEPTH) - points
        return np.asarray(self.share * back - shift)

    def rho(self, points: Array) -> Array:
        """Return the distance of points of shape (N, 2) from the head's middle, in its radii."""
        away = points - self.center_px
        return np.asarray(np.hypot(away[:, 0], away[:, 1]) / self.radius_px)

    def kept_inside(self, points: Array) -> Array:
        """Return the same, less what crosses the photo's edges.

        It is taken off beside the head, or within its rim where that is near the edge.
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
class Heads:
    """The heads of a photo: where they meet each point goes with the nearer one."""

    heads: tuple[Head, ...] = ()

    @classmethod
    def of(cls, faces: Sequence[Face], recipe: Recipe, photo: Box) -> Heads:
        """Return those of faces; none where the recipe leaves the lens alone.

        One that goes by the photo must have been `settled` before.
        """
        if isinstance(recipe.lens, str):
            return cls()
        focal = focal_px(recipe.lens, photo)
        shares = (recipe.of_face(face.recipe).lens_amount / 100.0 for face in faces)
        heads = [Head(f, focal, photo, s) for f, s in zip(faces, shares, strict=True)]
        return cls(_beside_each_other(heads))

    def part_at(
        self, which: int, points: Array, away_px: Callable[[Array], Array] | None = None
    ) -> Array:
        """Return what one head asks of points of shape (N, 2), same shape, px.

        Whole on the head, fading to nothing beyond it, and so far from what must not move.
        """
        head = self.heads[which]
        rho = head.rho(points)
        mine, share = _apart(rho), 1.0 - ramp((rho - 1.0) / _FADE)
        share /= 1.0 + sum(mine / _apart(other.rho(points)) for other in self._near(which))
        if away_px is not None:
            beside = np.maximum(rho - 1.0, 0.0) * head.radius_px
            share *= ramp(1.0 / (1.0 + beside / np.maximum(away_px(points), 1e-9)))
        return head.kept_inside(points) * share[:, None]

    def _near(self, which: int) -> list[Head]:
        """Return the others that come near one."""
        head = self.heads[which]
        apart = (float(np.hypot(*(one.center_px - head.center_px))) for one in self.heads)
        return [
            other
            for k, (other, far) in enumerate(zip(self.heads, apart, strict=True))
            if k != which and far < (1.0 + _FADE) * (head.radius_px + other.radius_px)
        ]

    def at(self, points: Array) -> Array:
        """Return what all heads ask of points of shape (N, 2) together, same shape, px."""
        total = np.zeros_like(points)
        for which, head in enumerate(self.heads):
            near = head.rho(points) < 1.0 + _FADE
            if near.any():
                total[near] += self.part_at(which, points[near])
        return total

    @cached_property
    def faces(self) -> list[Face]:
        """The faces as the lens' correction alone shows them; their lattices stay."""
        faces = [head.face for head in self.heads]
        parts = [part for face in faces for part in _parts(face)]
        if not parts:
            return []
        ends = np.cumsum([len(part) for part in parts])[:-1]
        moved = iter(np.split(shown_by(self.at, np.vstack(parts), _STEPS), ends))
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

    def around(
        self,
        surrounds: Sequence[Surround | None],
        protection: Protection,
        neighbours_px: Sequence[Array],
    ) -> tuple[Lensed | Surround | None, ...]:
        """Return what each face asks for with what surrounds it, which is of the faces shown."""
        if not self.heads:
            return tuple(surrounds)
        beside = neighbours_px or [np.zeros((0, 2))] * len(surrounds)
        return tuple(
            Lensed(self, which, surround, protection, near)
            for which, (surround, near) in enumerate(zip(surrounds, beside, strict=True))
        )


@dataclass(frozen=True, eq=False)
class Lensed:
    """What one face asks of the control points round it: its head's place, and all else."""

    heads: Heads
    which: int
    surround: Surround | None
    protection: Protection
    neighbours_px: Array

    @property
    def around_px(self) -> Array:
        """Corners of a box outside which all is 0, (2, 2)."""
        mine = self.heads.heads[self.which].around_px
        if self.surround is None:
            return mine
        theirs = self.surround.around_px
        return np.stack([np.minimum(mine[0], theirs[0]), np.maximum(mine[1], theirs[1])])

    @property
    def corners_px(self) -> Array:
        """The same, as far as it lies in the photo."""
        return np.clip(self.around_px, *edges_px(self.heads.heads[self.which].photo))

    def at(self, points: npt.ArrayLike) -> Array:
        """Return the backward displacement at points of shape (N, 2), px, same shape."""
        points = np.asarray(points, np.float64)
        around = np.zeros_like(points) if self.surround is None else self.surround.at(points)
        return around + self.heads.part_at(self.which, points + around, self._away_px)

    @cached_property
    def features(self) -> tuple[Array, Array, Array]:
        """Points round eyes and mouth, where they go, and how much they give way: `Surround`'s."""
        if self.surround is not None and self.surround.keeps_features:
            seen, target, slack = self.surround.features
            return seen + self.heads.at(seen), target, slack
        face, shown = self.heads.heads[self.which].face, self.heads.faces[self.which]
        source = np.vstack([face.eyes, face.mouth])
        return source, np.vstack([shown.eyes, shown.mouth]), np.full(len(source), _SLACK)

    def _away_px(self, points: Array) -> Array:
        return away_px(points, self.protection, self.neighbours_px)


def _beside_each_other(heads: Sequence[Head]) -> tuple[Head, ...]:
    """Return heads shifted so that what lies between two that are near comes apart the least.

    Where the gap's middle is, both are to displace alike: least squares, the more a gap counts the
    smaller it is, and a head's own place the nearer it is to the photo's edge.
    """
    near = _nearness(heads)
    heads = [
        dataclasses.replace(head, company=1.0 - float(np.prod(1.0 - row)))
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
    return tuple(dataclasses.replace(h, aside_px=by) for h, by in zip(heads, aside, strict=True))


def _nearness(heads: Sequence[Head]) -> Array:
    """Return how near heads are to each other, 0 to 1, (K, K); 0 to themselves."""
    centers = np.array([head.center_px for head in heads]).reshape(-1, 2)
    radii = np.array([head.radius_px for head in heads])
    apart = centers[:, None] - centers
    far = np.hypot(apart[..., 0], apart[..., 1]) / ((radii[:, None] + radii) / 2.0)
    near = 1.0 - ramp((far - _CLOSE) / (_ALONE - _CLOSE))
    np.fill_diagonal(near, 0.0)
    return np.asarray(near)


def _apart(rho: Array) -> Array:
    """Return how little a point belongs to a head."""
    within = _RIM * np.clip(rho, 0.1, 1.0) ** _SHARP
    return np.asarray(within + np.maximum(rho - 1.0, 0.0) ** _GAP)


def _parts(face: Face) -> list[Array]:
    parts = (face.outline, face.eyes, face.mouth, face.forehead)
    return [part for part in parts if part is not None]


def _shift(by: Array) -> Array:
    return np.array([[1.0, 0.0, by[0]], [0.0, 1.0, by[1]], [0.0, 0.0, 1.0]])
