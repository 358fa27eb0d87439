"""Does the warp fold? Measured everywhere, and proven where that is possible.

The paper takes the one-to-one property for granted (section 1); it holds only while control points
move little (Choi and Lee, 2000).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import comb
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.warp.bezier import halves
from kogao_core.warp.falloff import Falloff
from kogao_core.warp.field import Field
from kogao_core.warp.lattice import Lattice, groups
from kogao_core.warp.samples import least_dets

# Choi and Lee (2000): control points that move less than this many spacings can't fold a lattice.
INJECTIVE_BOUND: Final = 0.48
_HALVINGS: Final = 2
# Between samples det J can be a little smaller than at them, so measured fields keep a distance.
LEAST_MEASURED_DET: Final = 0.05
# The fade f(|d|) d has slope (f I + f' |d| u u') D; f + f' |d| is largest at |d| = 1.64 T.
_FADE_STRETCH: Final = 2.972


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
    """Return True when the control points prove that no determinant is 0 or less.

    Where faces' lattices reach into each other there is a proof only while all slopes together stay
    below 1. Result: false says that there is no proof, not that it folds.
    """
    return edges_are_safe(field) and not any(_unproven(field))


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
    left, right = (half @ coefficients for half in halves(coefficients.shape[1]))
    stacked = np.concatenate([left, right])
    return np.concatenate([stacked @ half.T for half in halves(coefficients.shape[2])])
