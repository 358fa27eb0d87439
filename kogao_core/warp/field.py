"""The displacement field of all faces together: displacement, Jacobian, residual."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, smoothstep
from kogao_core.faces.targets import Pairs
from kogao_core.warp.lattice import Lattice, basis, basis_slope, matrices
from kogao_core.warp.protection import NO_FALLOFF, Falloff

_INVERSION_STEPS: Final = 64
_INVERTED_PX: Final = 1e-4
_MOST_AHEAD: Final = 32.0  # how many times the last moves one goes: in a fold they say little
_LEAST_CHANGE: Final = 1e-30


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """Backward displacement ``d(x)``: the output at x shows the source at ``x + d(x)``."""

    lattices: tuple[Lattice, ...]  # one per face; displacements add up
    # Displacements shorter than this vanish and come back smoothly until twice as long (section 4.2
    # without its step); 0 leaves the spline as it is.
    fade_px: float = 0.0
    falloff: Falloff = NO_FALLOFF  # hard edges towards which the displacement fades out

    @property
    def is_plain(self) -> bool:
        """True when the displacement is the spline and nothing else."""
        return self.fade_px <= 0.0 and not self.falloff.strokes

    def at(self, points_px: npt.ArrayLike) -> Array:
        """Return the displacement at points of shape (N, 2), px. Result: backward, px."""
        points = np.asarray(points_px, np.float64)
        displacement: Array = np.zeros_like(points)
        near = [(a, at) for a in self.lattices if len(at := np.flatnonzero(a.reaches(points)))]
        weights = matrices([lattice.window_at(*points[at].T) for lattice, at in near])
        for (lattice, at), ((bx, by),) in zip(near, weights, strict=True):
            displacement[at] += lattice.mixed_at(bx, by)
        if self.is_plain:
            return displacement
        factor, _ = self.falloff.at(points)
        share = factor * fade(np.hypot(*displacement.T), self.fade_px)
        return np.asarray(displacement * share[:, None])

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        """Return the displacement on the grid ``ys x xs``, shape (2, len(ys), len(xs)), px.

        `xs_px`, `ys_px` (N,) and (M,). Result (2, M, N): x and y component, px.
        """
        displacement = self._spline(xs_px, ys_px)
        if self.is_plain:
            return displacement
        factor, _ = self.falloff.on_grid(xs_px, ys_px)
        return np.asarray(displacement * factor * fade(np.hypot(*displacement), self.fade_px))

    def det_jacobian(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        """Return det(I + dd/dx) on the tensor grid, shape (len(ys), len(xs)); <= 0 is a fold.

        `xs_px`, `ys_px` (N,) and (M,). Result (M, N).
        """
        return det_of(*self.slopes(xs_px, ys_px))

    def slopes(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the derivatives of the displacement along x and along y on the tensor grid.

        Without a fade those of several fields, each with its lattices, add up. `xs_px`, `ys_px`
        (N,) and (M,). `along_x`, `along_y` (2, M, N): of its x and y component, px per px.
        """
        along_x, along_y = self._spline_slopes(xs_px, ys_px)
        if not self.is_plain:
            displacement = self._spline(xs_px, ys_px)
            if self.fade_px > 0.0:
                along_x, along_y = self._faded_slopes(displacement, along_x, along_y)
                displacement = displacement * fade(np.hypot(*displacement), self.fade_px)
            factor, (rise_x, rise_y) = self.falloff.on_grid(xs_px, ys_px)
            along_x, along_y = (
                factor * along_x + rise_x * displacement,
                factor * along_y + rise_y * displacement,
            )
        return along_x, along_y

    def _spline(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        total: Array = np.zeros((2, np.size(ys_px), np.size(xs_px)))
        for lattice, part, ((bx, by),) in self._weights(xs_px, ys_px, (basis,)):
            total[:, *part] += lattice.mixed(bx, by)
        return total

    def _spline_slopes(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> tuple[Array, Array]:
        along_x, along_y = np.zeros((2, 2, np.size(ys_px), np.size(xs_px)))
        for lattice, part, ((bx, by), (slope_x, slope_y)) in self._weights(
            xs_px, ys_px, (basis, basis_slope)
        ):
            h = lattice.grid.spacing_px
            along_x[:, *part] += lattice.mixed(slope_x / h, by)
            along_y[:, *part] += lattice.mixed(bx, slope_y / h)
        return along_x, along_y

    def _weights(
        self,
        xs_px: npt.ArrayLike,
        ys_px: npt.ArrayLike,
        kinds: Sequence[Callable[[Array], Array]],
    ) -> Iterator[tuple[Lattice, tuple[slice, slice], list[tuple[Array, Array]]]]:
        """Yield the lattices that reach a grid, with the rows and columns, and `matrices` there."""
        xs, ys = np.asarray(xs_px, np.float64), np.asarray(ys_px, np.float64)
        if any((axis[1:] < axis[:-1]).any() for axis in (xs, ys)):
            raise ValueError("the coordinates of a grid must ascend; ask for places by Field.at")
        near = []
        for lattice in self.lattices:
            left, top, right, bottom = lattice.reach_px
            rows = slice(*np.searchsorted(ys, [top, bottom]))
            columns = slice(*np.searchsorted(xs, [left, right]))
            if rows.start < rows.stop and columns.start < columns.stop:
                near.append((lattice, (rows, columns)))
        windows = [lattice.window_at(xs[columns], ys[rows]) for lattice, (rows, columns) in near]
        for (lattice, part), weights in zip(near, matrices(windows, kinds), strict=True):
            yield lattice, part, weights

    def _faded_slopes(
        self, displacement: Array, along_x: Array, along_y: Array
    ) -> tuple[Array, Array]:
        # (f(|d|) d)' = f d' + f'(|d|) |d|' d
        length = np.hypot(displacement[0], displacement[1])
        factor, slope = fade(length, self.fade_px), _fade_slope(length, self.fade_px)
        unit = displacement / np.where(length > 0.0, length, 1.0)
        grown_x = factor * along_x + slope * (unit * along_x).sum(axis=0) * displacement
        grown_y = factor * along_y + slope * (unit * along_y).sum(axis=0) * displacement
        return grown_x, grown_y


def det_of(along_x: Array, along_y: Array) -> Array:
    """Return det(I + D) of slopes D.

    `along_x`, `along_y` (2, ...) px. Result: of their shape without the first axis.
    """
    return np.asarray((1.0 + along_x[0]) * (1.0 + along_y[1]) - along_x[1] * along_y[0])


def fade(length_px: Array, threshold_px: float) -> Array:
    """Return the smoothstep of displacement lengths over [T, 2T]; 1 everywhere when T = 0.

    Result: 0 to 1, of the shape of `length_px`.
    """
    if threshold_px <= 0.0:
        return np.ones_like(length_px)
    return smoothstep(length_px / threshold_px - 1.0)


def _fade_slope(length_px: Array, threshold_px: float) -> Array:
    t = np.clip(length_px / threshold_px - 1.0, 0.0, 1.0)
    return np.asarray(6.0 * t * (1.0 - t) / threshold_px)


class Displacing(Protocol):
    """A backward displacement: a `Field`, or a rival's."""

    def at(self, points_px: Array, /) -> Array:
        """Return the displacement at points of shape (N, 2), px."""


def shown_at(field: Displacing, source_px: Array, start_px: Array | None = None) -> Array:
    """Return where the output shows points of the source: solves ``x + d(x) = source``.

    Result (N, 2).
    """
    x = np.array(source_px if start_px is None else start_px, np.float64)
    left, miss, move = np.arange(len(x)), np.zeros_like(x), np.zeros_like(x)
    for turn in range(_INVERSION_STEPS):
        last, miss = miss, source_px[left] - field.at(x[left]) - x[left]
        move = _accelerated(miss, last, move) if turn else miss
        x[left] += move
        far = np.abs(miss).max(axis=1) >= _INVERTED_PX
        if not far.any():
            break
        left, miss, move = left[far], miss[far], move[far]
    return x


def shown_by(displacement: Callable[[Array], Array], points: Array, steps: int) -> Array:
    """Return where points of shape (N, 2) are shown, px: ``x + d(x) = point``, in so many steps."""
    shown = points
    for _ in range(steps):
        shown = points - displacement(shown)
    return shown


def _accelerated(miss: Array, last: Array, move: Array) -> Array:
    """Return the next moves of points that missed by `last` and moved (Anderson 1965, depth 1).

    Moved by what it missed alone, a point near a fold would hardly come nearer, or never.
    """
    change = miss - last
    share = (change * miss).sum(axis=1) / np.maximum((change**2).sum(axis=1), _LEAST_CHANGE)
    return np.asarray(miss - np.clip(share, -_MOST_AHEAD, 1.0)[:, None] * (move + change))


@dataclass(frozen=True, slots=True)
class Residual:
    """How far the displacement at the targets is from the one asked for there, px.

    And between them, from that of the curve through them. Where a landmark lands, which `shown_at`
    tells, is up to 4 % nearer to its target, for there the displacement is another.
    """

    mean_px: float
    max_px: float
    contour_mean_px: float
    contour_max_px: float


def residual(field: Field, pairs: Sequence[Pairs]) -> Residual:
    """Compare the field with what the landmarks, and the curve through them, ask for.

    Result: all zeros without a face.
    """
    if not pairs:
        return Residual(0.0, 0.0, 0.0, 0.0)
    wanted = [np.hstack([p.target_px, p.displacement_px]) for p in pairs]
    asked = np.concatenate([*wanted, *(_curve(each) for each in wanted)])
    missed = np.linalg.norm(field.at(asked[:, :2]) - asked[:, 2:], axis=1)
    points, between = np.split(missed, [sum(len(each) for each in wanted)])
    return Residual(
        float(points.mean()), float(points.max()), float(between.mean()), float(between.max())
    )


def _curve(points: Array, per_step: int = 8) -> Array:
    """Sample the Catmull-Rom curve through points of shape (N, dimensions)."""
    before = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    a, b, c, d = before[:-3], before[1:-2], before[2:-1], before[3:]
    t = (np.arange(per_step) / per_step)[:, None, None]
    curve = 0.5 * (
        2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3
    )
    return np.asarray(curve.transpose(1, 0, 2).reshape(-1, points.shape[1]))
