"""Does the warp fold? Measured everywhere, and proven where that is possible.

Measured is det J at 8 x 8 samples in each lattice cell, where bounds leave room for a small one.
The paper takes the one-to-one property for granted (section 1); it holds only while control points
move little (Choi and Lee, 2000).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import compress, product
from math import comb
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.warp.field import Field, det_of
from kogao_core.warp.lattice import ORDER, Lattice, basis, basis_slope, groups, meet
from kogao_core.warp.protection import Falloff

SAMPLES_PER_CELL: Final = 8
_PLACES: Final = (np.arange(SAMPLES_PER_CELL) + 0.5) / SAMPLES_PER_CELL
# Every sample is the same mixture of the 4 x 4 control points that reach its cell.
_ALONG_X: Final = np.kron(basis(_PLACES), basis_slope(_PLACES)).T
_ALONG_Y: Final = np.kron(basis_slope(_PLACES), basis(_PLACES)).T

Slopes = tuple[Array, Array]
"""Derivatives along x and along y, each of the x and the y component."""
# Choi and Lee (2000): control points that move less than this many spacings can't fold a lattice.
INJECTIVE_BOUND: Final = 0.48
_HALVINGS: Final = 2
# Between samples det J can be a little smaller than at them, so measured fields keep a distance.
LEAST_MEASURED_DET: Final = 0.05
# The fade f(|d|) d has slope (f I + f' |d| u u') D; f + f' |d| is largest at |d| = 1.64 T.
_FADE_STRETCH: Final = 2.972


def least_dets(field: Field, lattice: Lattice, below: float = np.inf) -> Array:
    """Return the smallest det J of a field at the samples in each cell of one of its lattices.

    Result (J + 3, I + 3): infinite in cells where there is neither the smallest, one `below`, nor
    one of 0 or less.
    """
    others = [a for a in field.lattices if a is not lattice and meet(a, lattice)]
    field = dataclasses.replace(field, lattices=(lattice, *others))
    every = np.ones_like(lattice.reached)
    if not field.is_plain:
        return _in_cells(field, lattice, every)
    if not others:
        return _alone(lattice, every).reshape(every.shape)
    spans = lattice.cell_spans_px
    added = np.sum([a.most_in(a.steepest, spans) for a in others], axis=0)
    slope = lattice.steepest + added
    if not (open_ := _may_fall(slope, below)).any():
        return np.full(slope.shape, np.inf)
    # |det(M + E) - det M| <= |M| |E| + |E|^2 / 2, of a slope E that the others add.
    alone, room = _alone(lattice, open_), ((np.sqrt(2.0) + slope) * added)[open_]
    below = max(0.0, min(below, float((alone + room).min())))
    open_[open_] = alone - room <= below
    return _in_cells(field, lattice, open_)


def largest_det(field: Field) -> float:
    """Return the largest det J at the samples in each cell of all lattices, or 1 without one.

    The map goes backward: above 1 the picture is compressed, below 1 it is stretched.
    """
    most = 1.0
    for lattice in field.lattices:
        h = lattice.grid.spacing_px
        xs, ys = ((span[0][:, None] + h * _PLACES).ravel() for span in lattice.cell_spans_px)
        most = max(most, float(field.det_jacobian(xs, ys).max()))
    return most


class Shrinking:
    """Samples near a lattice at which det J may be small while some displacements shrink.

    Slopes shrink with their displacement, so at each sample det J is a quadratic in its share.
    """

    def __init__(
        self, field: Field, lattice: Lattice, members: Collection[int], below: float
    ) -> None:
        near = [k for k, a in enumerate(field.lattices) if meet(a, lattice)]
        self.shrinks = np.array([k in members for k in near])
        lattices, spans = [field.lattices[k] for k in near], lattice.cell_spans_px
        most = np.stack([a.most_in(a.steepest, spans) for a in lattices])
        cells = _block(_may_fall(most.sum(axis=0), below) | (not field.is_plain))
        places = _places_px(lattice, cells)
        still, shrinking = (
            dataclasses.replace(field, lattices=tuple(compress(lattices, which))).slopes(*places)
            for which in (~self.shrinks, self.shrinks)
        )
        terms = _det_by_share(still, shrinking)
        at = np.nonzero(_least_of(*terms) < below)
        self._terms = [term[at] for term in terms]
        rows, columns = (
            part.start + index // SAMPLES_PER_CELL for part, index in zip(cells, at, strict=True)
        )
        self._most = most[:, rows, columns]

    def dets(self, share: float) -> Array:
        """Return det J at each sample, shape (N,)."""
        still, linear, square = self._terms
        return np.asarray(still + share * (linear + share * square))

    def steepest(self, share: float) -> Array:
        """Return bounds of the slopes of lattices in each sample's cell, shape (lattices, N)."""
        return np.where(self.shrinks, share, 1.0)[:, None] * self._most


def _det_by_share(still: Slopes, shrinking: Slopes) -> tuple[Array, Array, Array]:
    """Return a, b, c of ``det(I + S + share D) = a + b share + c share^2`` for slopes S and D."""
    (s_xx, s_yx), (s_xy, s_yy) = still
    (d_xx, d_yx), (d_xy, d_yy) = shrinking
    linear = (1.0 + s_xx) * d_yy + d_xx * (1.0 + s_yy) - s_yx * d_xy - d_yx * s_xy
    return det_of(*still), linear, d_xx * d_yy - d_yx * d_xy


def _least_of(constant: Array, linear: Array, square: Array) -> Array:
    """Return the smallest value of quadratics over 0 to 1."""
    turn = np.clip(-linear / np.where(square > 0.0, 2.0 * square, 1.0), 0.0, 1.0)
    values = [constant + t * (linear + t * square) for t in (0.0, turn, 1.0)]
    return np.asarray(np.minimum.reduce(values))


def _in_cells(field: Field, lattice: Lattice, which: npt.NDArray[np.bool_]) -> Array:
    """Return the smallest det J at the samples in the block of some cells, infinity in the rest."""
    least, cells = np.full(which.shape, np.inf), _block(which)
    least[cells] = _least(field.det_jacobian(*_places_px(lattice, cells)))
    return least


def _may_fall(slope: Array, below: float) -> npt.NDArray[np.bool_]:
    """Return where det J may be less than that, by a bound of its slope."""
    return np.asarray((slope >= 1.0) | ((1.0 - slope) ** 2 < below))


def _block(cells: npt.NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the smallest block of rows and columns that holds some cells."""
    found = (np.flatnonzero(cells.any(axis=axis)) for axis in (1, 0))
    rows, columns = (slice(at[0], at[-1] + 1) if len(at) else slice(0, 0) for at in found)
    return rows, columns


def _alone(lattice: Lattice, which: npt.NDArray[np.bool_]) -> Array:
    """Return the smallest det J at the samples in some cells, shape (N,), of one lattice alone."""
    (i, j), (rows, columns) = lattice.first, lattice.shape
    margin = ORDER - 1
    stored = lattice.window((i - margin, j - margin), (rows + 2 * margin, columns + 2 * margin))
    cells = np.lib.stride_tricks.sliding_window_view(stored, (ORDER, ORDER), (0, 1))
    phi = cells[which].reshape(-1, ORDER**2) / lattice.grid.spacing_px
    along_x, along_y = (
        (phi @ slopes).reshape(-1, 2, SAMPLES_PER_CELL**2).swapaxes(0, 1)
        for slopes in (_ALONG_X, _ALONG_Y)
    )
    return np.asarray(det_of(along_x, along_y).min(axis=1))


def _places_px(lattice: Lattice, cells: tuple[slice, slice]) -> tuple[Array, Array]:
    """Return the coordinates of the samples in a block of cells along x and y, px."""
    (ox, oy), h, (i0, j0) = lattice.grid.origin_px, lattice.grid.spacing_px, lattice.first_cell
    rows, columns = (np.arange(part.start, part.stop) for part in cells)
    xs = ox + h * ((i0 + columns)[:, None] + _PLACES).ravel()
    return xs, oy + h * ((j0 + rows)[:, None] + _PLACES).ravel()


def _least(det: Array) -> Array:
    """Return the smallest of the samples in each cell."""
    rows, columns = (side // SAMPLES_PER_CELL for side in det.shape)
    by_row = det.reshape(rows, SAMPLES_PER_CELL, det.shape[1]).min(axis=1)
    return np.asarray(by_row.reshape(rows, columns, SAMPLES_PER_CELL).min(axis=2))


@dataclass(frozen=True, slots=True)
class OneToOne:
    """Whether the warp folds."""

    # Smallest Jacobian determinant found on a grid of 8 x 8 samples per lattice cell.
    min_det: float
    certified: bool  # true when no determinant anywhere, sampled or not, can be 0 or less
    # Lattice cells with a sampled determinant <= 0, px.
    folded_cells: tuple[tuple[float, float, float, float], ...]
    # False when the fade of a threshold or of a falloff could fold in bands thinner than the
    # samples: then positive samples say little.
    edges_proven: bool = True
    # False when no sample folds but a fold between them can't be ruled out: a lattice that stands
    # alone isn't proven, or lattices that reach into each other come near a fold.
    settled: bool = True

    @property
    def folds(self) -> bool:
        """True when at least one cell is folded."""
        return bool(self.folded_cells)


def check_one_to_one(field: Field) -> OneToOne:
    """Measure det J in all lattice cells that a non-zero control point reaches, and certify it.

    Result: smallest det J 1 without a face.
    """
    lowest, folded = 1.0, []
    for lattice in field.lattices:
        det = least_dets(field, lattice, max(0.0, lowest))
        lowest = min(lowest, float(det.min()))
        h, (ox, oy) = lattice.grid.spacing_px, lattice.grid.origin_px
        i0, j0 = lattice.first_cell
        for j, i in np.argwhere(det <= 0.0).tolist():
            folded.append((ox + h * (i0 + i), oy + h * (j0 + j), h, h))
    edges, unproven = edges_are_safe(field), list(_unproven(field))
    certified = lowest > 0.0 and edges and not unproven
    # Without a proof, lattices that reach into each other keep the guard's distance from a fold.
    settled = edges and all(len(g) > 1 and lowest >= LEAST_MEASURED_DET for g in unproven)
    return OneToOne(lowest, certified, tuple(folded), edges, settled)


def least_det(field: Field, most: float = 1.0) -> float:
    """Return the smallest det J that `check_one_to_one` samples, or `most` if that is smaller."""
    for lattice in field.lattices:
        most = min(most, float(least_dets(field, lattice, most).min()))
    return most


def certify(field: Field) -> bool:
    """Return True when the control points prove that no determinant is 0 or less, falloff aside.

    Where faces' lattices reach into each other there is a proof only while all slopes together stay
    below 1. Result: false says that there is no proof, not that it folds.
    """
    return fade_is_safe(field) and not any(_unproven(field))


def _unproven(field: Field) -> Iterator[list[int]]:
    """Yield the groups of lattices whose control points don't prove that they can't fold."""
    for group in groups(field.lattices):
        lattices = [field.lattices[k] for k in group]
        if len(group) == 1:
            proven = _lattice_is_safe(lattices[0])
        else:
            proven = sum(float(a.steepest.max()) for a in lattices) < 1.0
        if not proven:
            yield group


def _lattice_is_safe(lattice: Lattice) -> bool:
    short = INJECTIVE_BOUND * lattice.grid.spacing_px
    if float(lattice.magnitude_px.max()) < short:
        return True
    # A displacement whose slope is below 1 can't fold; most cells are settled so.
    return lower_bound(lattice, lattice.steepest >= 1.0) > 0.0


def edges_are_safe(field: Field) -> bool:
    """Return True when neither fade nor falloff can fold what doesn't fold without them."""
    return fade_is_safe(field) and falloff_slope(field) < 1.0


def falloff_slope(field: Field) -> float:
    """Return a number that grows as the displacements do; below 1 the falloff is harmless.

    The factor m turns the slope D of the displacement d into ``m D + d grad(m)'``, which can't fold
    while ``m |D| + |d| |grad(m)| < 1`` wherever the factor is at work. Result: 0 without a falloff.
    """
    if not field.falloff.strokes:
        return 0.0
    stretch = _FADE_STRETCH if field.fade_px > 0.0 else 1.0
    slopes = (
        sum(_falloffed_slope(field.lattices[k], field.falloff, stretch) for k in group)
        for group in groups(field.lattices)
    )
    return max(slopes, default=0.0)


def _falloffed_slope(lattice: Lattice, falloff: Falloff, stretch: float) -> float:
    """Bound ``m stretch |D| + |d| |grad(m)|`` over the cells near the falloff."""
    fine = lattice.refined().refined()
    near = fine.reached & _cells_in(fine, falloff.boxes_px)
    side, corner = fine.grid.spacing_px, np.add(fine.first_cell, np.argwhere(near)[:, ::-1])
    centers = np.asarray(fine.grid.origin_px + side * (corner + 0.5))
    factor, steepest = falloff.bounds(centers, float(np.sqrt(0.5)) * side)
    slopes = factor * stretch * fine.steepest[near]
    return float((slopes + steepest * fine.bound_px[near]).max(initial=0.0))


def _cells_in(lattice: Lattice, boxes_px: Array) -> npt.NDArray[np.bool_]:
    """Return the cells that meet one of the boxes (left, top, right, bottom)."""
    (starts_x, ends_x), (starts_y, ends_y) = lattice.cell_spans_px
    inside = np.zeros(lattice.reached.shape, bool)
    for left, top, right, bottom in boxes_px:
        across = (ends_x > left) & (starts_x < right)
        inside |= ((ends_y > top) & (starts_y < bottom))[:, None] & across
    return inside


def fade_is_safe(field: Field) -> bool:
    """Return True when the field's fade can't fold what doesn't fold without it.

    Where the fade is at work, over [T, 2T], it turns the slope D of the displacement into A D,
    and no direction of A stretches by more than 2.972, whatever T; so ``|D| < 1 / 2.972`` there
    keeps I + A D invertible.
    """
    if field.fade_px <= 0.0:
        return True
    for group in groups(field.lattices):
        fine = [field.lattices[k].refined().refined() for k in group]
        short = fine[0].least_px <= 2.0 * field.fade_px if len(group) == 1 else True
        slope = sum(float(a.steepest.max(initial=0.0, where=short)) for a in fine)
        if slope * _FADE_STRETCH >= 1.0:
            return False
    return True


def lower_bound(lattice: Lattice, cells: npt.NDArray[np.bool_]) -> float:
    """Return a number that no det J falls below in some cells of a lattice that stands alone.

    In each cell det J is a polynomial of degree 5 x 5; in Bernstein form it is nowhere smaller than
    its smallest coefficient. Cells that this doesn't settle are quartered. `cells` bool (J + 3, I +
    3). Result: at most 1.
    """
    coefficients = _det_bernstein(*(slope[cells] for slope in lattice.slopes))
    bound = coefficients.min(axis=(1, 2))
    settled = float(bound[bound > 0.0].min(initial=1.0))
    for _ in range(_HALVINGS):
        coefficients = _quartered(coefficients[bound <= 0.0])
        bound = coefficients.min(axis=(1, 2))
        settled = min(settled, float(bound[bound > 0.0].min(initial=1.0)))
    return min(settled, float(bound.min(initial=1.0)))


def _det_bernstein(along_x: Array, along_y: Array) -> Array:
    """Return the Bernstein coefficients of det J in cells, shape (cells, 6, 6), rows along y."""
    return np.asarray(
        _product(1.0 + along_x[:, 0], 1.0 + along_y[:, 1]) - _product(along_x[:, 1], along_y[:, 0])
    )


def _product(a: Array, b: Array) -> Array:
    """Multiply polynomials in Bernstein form, shapes (N, rows, columns)."""
    rows, columns = a.shape[1] + b.shape[1] - 1, a.shape[2] + b.shape[2] - 1
    a, b = a * _binomials(a.shape[1:]), b * _binomials(b.shape[1:])
    total = np.zeros((len(a), rows, columns))
    for j, i in product(range(a.shape[1]), range(a.shape[2])):
        total[:, j : j + b.shape[1], i : i + b.shape[2]] += a[:, j, i, None, None] * b
    return np.asarray(total / _binomials((rows, columns)))


def _binomials(shape: tuple[int, ...]) -> Array:
    rows, columns = ([comb(n - 1, k) for k in range(n)] for n in shape)
    return np.outer(rows, columns).astype(np.float64)


def _quartered(coefficients: Array) -> Array:
    """Split each cell in four by de Casteljau's algorithm, shape (4 N, rows, columns)."""
    left, right = (half @ coefficients for half in _halves(coefficients.shape[1]))
    stacked = np.concatenate([left, right])
    return np.concatenate([stacked @ half.T for half in _halves(coefficients.shape[2])])


def _halves(count: int) -> tuple[Array, Array]:
    """Return de Casteljau's matrices from `count` Bezier points to those of either half.

    `left`, `right` (count, count): to be multiplied with the control points.
    """
    left = np.array([[comb(j, i) / 2.0**j for i in range(count)] for j in range(count)])
    return left, np.asarray(left[::-1, ::-1])
