"""Check whether the warp folds: measure everywhere, and prove where possible.

The measurement samples det J at 8 x 8 points in each lattice cell; cells with a sufficient lower
bound are skipped. The paper assumes a one-to-one map (section 1), which holds only while control
points move little (Choi and Lee, 2000).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import comb
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.field.field import Field
from kogao_core.field.protection import slope_bound
from kogao_core.paper.lattice import Lattice, groups, meet

SAMPLES_PER_CELL: Final = 8  # samples of det J per cell and axis; larger: surer, slower
_PLACES: Final = (np.arange(SAMPLES_PER_CELL) + 0.5) / SAMPLES_PER_CELL

# Choi and Lee (2000): a lattice can't fold if all control points move less than this, in spacings.
INJECTIVE_BOUND: Final = 0.48
_HALVINGS: Final = 2  # subdivisions of a cell for a tighter bound
# Least accepted sampled det J: between samples, det J can be a little smaller.
LEAST_MEASURED_DET: Final = 0.05
# The fade f(|d|) d has slope (f I + f' |d| u u') D; f + f' |d| is largest at |d| = 1.64 T.
_FADE_STRETCH: Final = 2.972


def least_dets(field: Field, lattice: Lattice, below: float = np.inf) -> Array:
    """Return the smallest det J of a field at the samples in each cell of one of its lattices.

    Result (J + 3, I + 3). Cells that can't fall below `below` may be skipped; they are infinite.
    """
    others = [a for a in field.lattices if a is not lattice and meet(a, lattice)]
    field = dataclasses.replace(field, lattices=(lattice, *others))
    spans = lattice.cell_spans_px
    slope = lattice.steepest + sum(a.most_in(a.steepest, spans) for a in others)
    # A slope bound s below 1 leaves det J at least (1 - s)^2.
    low = (slope >= 1.0) | ((1.0 - slope) ** 2 < below)
    if not field.is_plain:
        low = np.ones_like(low)
    least, (rows, columns) = np.full(low.shape, np.inf), _block(low)
    det = field.det_jacobian(*_samples_px(lattice, rows, columns))
    down, along = (size // SAMPLES_PER_CELL for size in det.shape)
    each = det.reshape(down, SAMPLES_PER_CELL, along, SAMPLES_PER_CELL)
    least[rows, columns] = each.min(axis=(1, 3), initial=np.inf)
    return least


def largest_det(field: Field) -> float:
    """Return the largest det J at the samples in each cell of all lattices, or 1 without one.

    The map is backward: det J > 1 compresses the picture, det J < 1 stretches the picture.
    """
    most = 1.0
    for lattice in field.lattices:
        most = max(most, float(field.det_jacobian(*_samples_px(lattice)).max()))
    return most


def _block(cells: npt.NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the smallest block of rows and columns that contains `cells`."""
    found = (np.flatnonzero(cells.any(axis=axis)) for axis in (1, 0))
    rows, columns = (slice(at[0], at[-1] + 1) if len(at) else slice(0, 0) for at in found)
    return rows, columns


def _samples_px(
    lattice: Lattice, rows: slice = slice(None), columns: slice = slice(None)
) -> tuple[Array, Array]:
    """Return the coordinates of the samples in a block of cells along x and y, px."""
    (left, _), (top, _) = lattice.cell_spans_px
    within = lattice.grid.spacing_px * _PLACES
    return (left[columns, None] + within).ravel(), (top[rows, None] + within).ravel()


@dataclass(frozen=True, slots=True)
class OneToOne:
    """Result of a check for folds."""

    # Smallest Jacobian determinant found on a grid of 8 x 8 samples per lattice cell.
    min_det: float
    certified: bool  # True if a proof excludes det J <= 0 everywhere, also between samples
    # Lattice cells with a sampled determinant <= 0, px.
    folded_cells: tuple[tuple[float, float, float, float], ...]
    # False if the fade of a threshold or of protected regions could fold in bands thinner than the
    # sampling grid: positive samples are then no evidence.
    edges_proven: bool = True
    # False if no sample folds but a fold between samples can't be excluded: for a single lattice
    # without a proof, or for overlapping lattices with a small det J.
    settled: bool = True

    @property
    def folds(self) -> bool:
        """True when at least one cell is folded."""
        return bool(self.folded_cells)


def check_one_to_one(field: Field) -> OneToOne:
    """Measure det J in all lattice cells within reach of non-zero control points, and certify.

    Result: without a face, the smallest det J is 1.
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
    # Without a proof, overlapping lattices are settled if det J exceeds the guard's limit.
    settled = edges and all(len(g) > 1 and lowest >= LEAST_MEASURED_DET for g in unproven)
    return OneToOne(lowest, certified, tuple(folded), edges, settled)


def least_det(field: Field, most: float = 1.0) -> float:
    """Return the smallest sampled det J of the field, at most `most`."""
    for lattice in field.lattices:
        most = min(most, float(least_dets(field, lattice, most).min()))
    return most


def certify(field: Field) -> bool:
    """Return True if the control points prove det J > 0 everywhere; protection is ignored.

    For overlapping lattices the only proof is a total slope below 1. Result: False means that
    there is no proof; the field need not fold.
    """
    return fade_is_safe(field) and not any(_unproven(field))


def _unproven(field: Field) -> Iterator[list[int]]:
    """Yield the groups of lattices that have no proof of positive det J."""
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
    # A slope below 1 can't fold; this settles most cells.
    return lower_bound(lattice, lattice.steepest >= 1.0) > 0.0


def edges_are_safe(field: Field) -> bool:
    """Return True if neither the fade of short displacements nor protection can add a fold."""
    return fade_is_safe(field) and all((slope < 1.0).all() for _, slope in protected_slopes(field))


def protected_slopes(field: Field) -> Iterator[tuple[Lattice, Array]]:
    """Yield each lattice at a quarter of its spacing, and a slope bound per cell, (J + 3, I + 3).

    The bound is 0 in cells without a fade. Without protection, yield no lattice.
    """
    stretch = _FADE_STRETCH if field.fade_px > 0.0 else 1.0
    for group in groups(field.lattices) if field.protection.strokes else ():
        fine = [field.lattices[k].refined().refined() for k in group]
        for lattice in fine:
            spans, side = lattice.cell_spans_px, lattice.grid.spacing_px
            most, slope = lattice.bound_px.copy(), lattice.steepest.copy()
            for other in (one for one in fine if one is not lattice and meet(one, lattice)):
                most += other.most_in(other.bound_px, spans)
                slope += other.most_in(other.steepest, spans)
            corner = np.add(lattice.first_cell, np.argwhere(lattice.reached)[:, ::-1])
            centers = np.asarray(lattice.grid.origin_px + side * (corner + 0.5), np.float64)
            cells = most[lattice.reached], stretch * slope[lattice.reached]
            bound = np.zeros_like(slope)
            bound[lattice.reached] = slope_bound(
                field.protection.strokes, centers, float(np.sqrt(0.5)) * side, *cells
            )
            yield lattice, bound


def fade_is_safe(field: Field) -> bool:
    """Return True if the field's fade can't add a fold.

    In the fade, over [T, 2T], the slope D of the displacement becomes A D with |A| <= 2.972 for
    every T. So ``|D| < 1 / 2.972`` there keeps I + A D invertible.
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
    """Return a lower bound of det J in some cells of a single lattice.

    In each cell det J is a polynomial of degree 5 x 5, bounded from below by the smallest Bernstein
    coefficient. Cells without a positive bound are quartered, `_HALVINGS` times. `cells` bool
    (J + 3, I + 3). Result: at most 1.
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

    `left`, `right` (count, count): matrices to multiply with the control points.
    """
    left = np.array([[comb(j, i) / 2.0**j for i in range(count)] for j in range(count)])
    return left, np.asarray(left[::-1, ::-1])
