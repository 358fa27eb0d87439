"""Straight lines stay straight and neighbours stay put: a change of the fit that no landmark feels.

A line may slide along itself, so only what the displacement does across it is asked to vanish: a
row ``n . d = 0`` for each sample, in which x and y meet. At the edge of somebody else both vanish.
The change keeps to the control points of the fit and is nothing at every landmark and protected
place, so the field stays one spline that does to the face what the fit does. Of all such changes it
is the one whose neighbouring control points differ least.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.background.held_rows import HeldRows, away, face_places, rows_of, still_places
from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.face import Face
from kogao_core.warp.field import Field
from kogao_core.warp.fit import Problem, on_quanta, summed
from kogao_core.warp.guard import is_safe
from kogao_core.warp.lattice import Lattice, groups
from kogao_core.warp.one_to_one import least_det

# Before it comes to a fold rows are softened, the nearer to a landmark the more, by this power.
_NEARNESS: Final = 3.0
# A change leaves det J at least so large, and at least this share of what it was without.
_LEAST_DET: Final = 0.5
_LEAST_SHARE: Final = 0.9
# Between landmarks the outline may drift by this share of the largest move; the face beside it by
# the next, and by the one after it where it lies so many lattice spacings from every landmark.
# Corners of eyes and mouth are bounded by the last wherever they lie.
_MOST_DRIFT: Final = 0.1
_MOST_BESIDE: Final = 1.0
_MOST_WITHIN: Final = 0.2
_BESIDE: Final = 1.5
# No place comes to move farther than this many times the most that any did.
_MOST_MOVE: Final = 1.25
# A line that bends by so much more for being held, in lattice spacings, is let go.
_WORSE: Final = 0.01
_ROUNDS: Final = 3
_SAMPLES: Final = 24  # along a line, to see how far it bends
_FIRM, _SOFT = 1e-6, 10.0  # of rows, weight 1 being that of a control point's
_RIGID: Final = 1.0  # of a line's shift and turn as a whole: that soft, it costs nothing
_WITHIN: Final = 10.0  # of a place within the face, on the same scale
_BISECTIONS: Final = 7
_LEAST_RIDGE: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """What a warp leaves as it is where it can."""

    # (N, 2, 2): ends (x, y) of straight lines of the background, px.
    lines: Array = dataclasses.field(default_factory=lambda: np.zeros((0, 2, 2)))
    # (M, 2): for each face, points on the edge of other people, whom it isn't to drag along, px;
    # empty where there are none.
    neighbours: tuple[Array, ...] = ()

    def mapped(self, transform: Affine) -> Held:
        """Return the same in another image's px."""
        lines = transform(self.lines.reshape(-1, 2)).reshape(-1, 2, 2)
        return Held(lines, tuple(transform(points) for points in self.neighbours))


NOTHING_HELD: Final = Held()


def hold(field: Field, problems: Sequence[Problem], faces: Sequence[Face], held: Held) -> Field:
    """Change a field so that lines stay straight and neighbours where they are.

    Where that would squeeze the photo too much, lines and neighbours give way, as little as it
    takes; faces never do. Result: one-to-one where `field` is.
    """
    if not len(held.lines) and not any(len(points) for points in held.neighbours):
        return field
    lattices = list(field.lattices)
    for group in groups([problem.support.empty for problem in problems]):
        among = _Faces([problems[k] for k in group], [faces[k] for k in group])
        for k in group:
            near = held.neighbours[k] if held.neighbours else np.zeros((0, 2))
            if field.lattices[k].phi.any():
                before = dataclasses.replace(field, lattices=(field.lattices[k],))
                one = Held(held.lines, (near,))
                lattices[k] = _held_by(problems[k], among, before, one)
        if len(group) > 1 and any(lattices[k] is not field.lattices[k] for k in group):
            _give_way_together(field, lattices, group)
    return dataclasses.replace(field, lattices=tuple(lattices))


@dataclass(frozen=True, eq=False)
class _Faces:
    """Those whose lattices reach into each other."""

    problems: Sequence[Problem]
    faces: Sequence[Face]

    @cached_property
    def landmarks(self) -> Array:
        """All their landmarks, px."""
        return np.vstack([problem.target_px[: problem.movers] for problem in self.problems])

    @cached_property
    def inside(self) -> Array:
        """Places all over them, px."""
        return np.vstack([face_places(problem) for problem in self.problems])

    @cached_property
    def corners(self) -> Array:
        """Those of eyes and mouths, px."""
        return np.vstack([points for face in self.faces for points in (face.eyes, face.mouth)])


def _held_by(problem: Problem, faces: _Faces, before: Field, held: Held) -> Lattice:
    """Return a face's lattice with all lines held but those that bend more for it."""
    (unheld,), (near,), lines = before.lattices, held.neighbours, held.lines
    for _ in range(_ROUNDS):
        rows = rows_of(problem, faces.landmarks, lines, near)
        if rows is None:
            break
        (lattice,) = _Change(problem, faces, before, rows).firmest().lattices
        worse_px = _bends_px(lattice, lines) - _bends_px(unheld, lines)
        fine = worse_px <= _WORSE * problem.grid.spacing_px
        if fine.all():
            return lattice
        lines = lines[fine]
    return unheld


def _bends_px(lattice: Lattice, lines: Array) -> Array:
    """Return about how far a lattice bends each line, shape (N,), px."""
    t = np.linspace(-1.0, 1.0, _SAMPLES)
    along = lines[:, 1] - lines[:, 0]
    unit = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    points = lines.mean(axis=1)[:, None] + 0.5 * t[:, None] * along[:, None]
    moved = Field((lattice,)).at(points.reshape(-1, 2))
    across = np.stack([-unit[:, 1], unit[:, 0]], axis=-1)[:, None]
    aside = (moved.reshape(points.shape) * across).sum(axis=2)
    # What a shift and a turn leave of it.
    aside = aside - aside.mean(axis=1, keepdims=True) - np.outer(aside @ t / (t @ t), t)
    return np.asarray(np.abs(aside).max(axis=1, initial=0.0))


def _give_way_together(field: Field, lattices: list[Lattice], group: Sequence[int]) -> None:
    """Take changes of faces that reach into each other back as far as they fold together."""
    before = dataclasses.replace(field, lattices=tuple(field.lattices[k] for k in group))
    after = dataclasses.replace(field, lattices=tuple(lattices[k] for k in group))
    limits = _Limits(before)
    if limits.allow(after):
        return

    def mixed(share: float) -> Field:
        parts = (
            on_quanta(a.plus(b.minus(a).scaled(share)))
            for a, b in zip(before.lattices, after.lattices, strict=True)
        )
        return dataclasses.replace(field, lattices=tuple(parts))

    kept = _as_near_as_allowed(before, mixed, limits.allow, 0.0, 1.0)
    for k, lattice in zip(group, kept.lattices, strict=True):
        lattices[k] = lattice


def _as_near_as_allowed(
    kept: Field,
    changed: Callable[[float], Field],
    allows: Callable[[Field], bool],
    allowed: float,
    refused: float,
) -> Field:
    """Return the changed field nearest to the refused one that is allowed, or else `kept`."""
    for _ in range(_BISECTIONS):
        middle = (allowed + refused) / 2.0
        field = changed(middle)
        if allows(field):
            kept, allowed = field, middle
        else:
            refused = middle
    return kept


class _Limits:
    """How far a field may be changed: what it is to stay clear of, and what it was."""

    def __init__(self, before: Field) -> None:
        self._before = before

    @cached_property
    def _least_det(self) -> float:
        return min(_LEAST_DET, _LEAST_SHARE * least_det(self._before))

    @cached_property
    def _was_safe(self) -> bool:
        return is_safe(self._before)

    def allow(self, field: Field) -> bool:
        """Return whether a changed field squeezes and folds no more than it may."""
        det = least_det(field, _LEAST_DET)
        if det < _LEAST_DET and det < self._least_det:
            return False
        return is_safe(field, det) or not self._was_safe


class _Change:
    """The change of a face's lattice that rows ask for, as firm or as soft as is wanted."""

    def __init__(self, problem: Problem, faces: _Faces, before: Field, rows: HeldRows) -> None:
        self._problem, self._before, self._rows = problem, before, rows
        support, nodes = problem.support, problem.moving_nodes
        fixed = support.design(still_places(problem, faces.landmarks), nodes).weights
        # All rows are in reach: `rows_of` has seen to that.
        asking = support.design(rows.places_px, nodes).weights
        reaches = support.empty.reaches
        all_over, corners = faces.inside[reaches(faces.inside)], faces.corners
        inside = np.vstack([all_over, corners[reaches(corners)]])
        felt_inside = support.design(inside, nodes).weights
        cost = _roughness(nodes, support.shape[1]) + _WITHIN * felt_inside.T @ felt_inside
        smooth = np.linalg.solve(cost, np.vstack([fixed, asking]).T)
        smooth_fixed, smooth_asking = smooth[:, : len(fixed)], smooth[:, len(fixed) :]
        outer, mixed = fixed @ smooth_fixed, fixed @ smooth_asking
        ridge = _LEAST_RIDGE * float(np.trace(outer))
        felt = np.linalg.solve(outer + ridge * np.eye(len(outer)), mixed)
        # What each row changes, once landmarks are let feel nothing of it.
        self._changes = smooth_asking - smooth_fixed @ felt
        self._gram = (asking @ self._changes) * (rows.across @ rows.across.T)
        self._gram += _RIGID * rows.rigid @ rows.rigid.T
        (lattice,) = before.lattices
        self._wanted = -(lattice.at(rows.places_px) * rows.across).sum(axis=1)
        outline = problem.target_px[: problem.movers]
        between = (outline[1:] + outline[:-1]) / 2.0
        self._places = np.vstack([between, inside])
        self._moves_px = lattice.at(self._places)
        within = np.ones(len(inside))
        apart = away(problem, faces.landmarks, all_over)
        within[: len(all_over)] = np.clip(apart / _BESIDE, 0.0, 1.0)
        within = (1.0 - within) * _MOST_BESIDE + within * _MOST_WITHIN
        shares = np.concatenate([np.full(len(between), _MOST_DRIFT), within])
        self._most_drift_px = shares * float(np.abs(lattice.at(outline)).max())
        self._most_px = _MOST_MOVE * _farthest_px(lattice)

    def firmest(self) -> Field:
        """Return the field with the firmest change that leaves photo and outline in shape."""
        limits = _Limits(self._before)

        def allows(field: Field) -> bool:
            return self._spares_face(field) and limits.allow(field)

        changed = self._by(_FIRM)
        if allows(changed):
            return changed
        return _as_near_as_allowed(
            self._before,
            lambda softness: self._by(float(np.exp(softness))),
            allows,
            float(np.log(_SOFT)),
            float(np.log(_FIRM)),
        )

    def _spares_face(self, field: Field) -> bool:
        (after,) = field.lattices
        drifts = np.abs(after.at(self._places) - self._moves_px).max(axis=1)
        return bool((drifts <= self._most_drift_px).all()) and _farthest_px(after) <= self._most_px

    def _by(self, softness: float) -> Field:
        soft = np.diag(softness * self._rows.away**-_NEARNESS)
        strength = np.linalg.solve(self._gram + soft, self._wanted)[:, None] * self._rows.across
        support, (lattice,) = self._problem.support, self._before.lattices
        phi = np.zeros((support.size, 2))
        phi[self._problem.moving_nodes] = self._changes @ strength
        changed = summed(lattice, on_quanta(support.lattice(phi)))
        return dataclasses.replace(self._before, lattices=(changed,))


def _farthest_px(lattice: Lattice) -> float:
    """Return how far the lattice moves what lies on its control points at most, px."""
    rows = np.pad(lattice.phi, ((1, 1), (0, 0), (0, 0)))
    rows = (rows[:-2] + 4.0 * rows[1:-1] + rows[2:]) / 6.0
    both = np.pad(rows, ((0, 0), (1, 1), (0, 0)))
    both = (both[:, :-2] + 4.0 * both[:, 1:-1] + both[:, 2:]) / 6.0
    return float(np.hypot(both[..., 0], both[..., 1]).max())


def _roughness(nodes: npt.NDArray[np.int64], columns: int) -> Array:
    """Return the matrix R of ``phi' R phi``: how much neighbouring control points differ.

    Those beyond `nodes` are zero.
    """
    row, column = np.divmod(nodes, columns)
    apart = np.abs(row[:, None] - row) + np.abs(column[:, None] - column)
    return np.asarray(4.0 * np.eye(len(nodes)) - (apart == 1))
