"""Does the warp fold? Measured everywhere, and proven where that is possible.

The paper takes the one-to-one property for granted (section 1); it holds only while control points
move little (Choi and Lee, 2000).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import comb
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.field import Field
from kogao_core.geometry import Array
from kogao_core.lattice import ORDER, Lattice, groups

# Choi and Lee (2000): control points that move less than this many spacings can't fold a lattice.
INJECTIVE_BOUND: Final = 0.48
SAMPLES_PER_CELL: Final = 8
_HALVINGS: Final = 2
# The fade f(|d|) d has slope (f I + f' |d| u u') D; f + f' |d| is largest at |d| = 1.64 T.
_FADE_STRETCH: Final = 2.972

# One segment of a uniform cubic B-spline as a Bezier curve.
_TO_BEZIER: Final = np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6.0


@dataclass(frozen=True, slots=True)
class OneToOne:
    """Whether the warp folds.

    Parameters
    ----------
    min_det : float
        Smallest Jacobian determinant found on a grid of 8 x 8 samples per lattice cell.
    certified : bool
        True when no determinant anywhere, sampled or not, can be 0 or less.
    folded_cells : tuple of (left, top, width, height)
        Lattice cells with a sampled determinant <= 0, px.
    """

    min_det: float
    certified: bool
    folded_cells: tuple[tuple[float, float, float, float], ...]

    @property
    def folds(self) -> bool:
        """True when at least one cell is folded."""
        return bool(self.folded_cells)


def check_one_to_one(field: Field) -> OneToOne:
    """Measure det J in all lattice cells that a non-zero control point reaches, and certify it."""
    lowest, folded = 1.0, []
    for lattice in field.lattices:
        det = _sampled_det(field, lattice)
        lowest = min(lowest, float(det.min()))
        h, (ox, oy) = lattice.grid.spacing_px, lattice.grid.origin_px
        i0, j0 = lattice.first_cell
        for j, i in np.argwhere(det <= 0.0).tolist():
            folded.append((ox + h * (i0 + i), oy + h * (j0 + j), h, h))
    return OneToOne(lowest, lowest > 0.0 and certify(field), tuple(folded))


def _sampled_det(field: Field, lattice: Lattice) -> Array:
    """Return the smallest sampled det J of each cell of `lattice`, shape of its cells."""
    (i0, j0), (rows, columns) = lattice.first_cell, lattice.cell_bound_px.shape
    steps = (np.arange(SAMPLES_PER_CELL) + 0.5) / SAMPLES_PER_CELL
    h, (ox, oy) = lattice.grid.spacing_px, lattice.grid.origin_px
    xs = ox + h * ((i0 + np.arange(columns))[:, None] + steps).ravel()
    ys = oy + h * ((j0 + np.arange(rows))[:, None] + steps).ravel()
    det = field.det_jacobian(xs, ys)
    shape = (rows, SAMPLES_PER_CELL, columns, SAMPLES_PER_CELL)
    return np.asarray(det.reshape(shape).min(axis=(1, 3)))


def certify(field: Field) -> bool:
    """Return True when the control points prove that no determinant is 0 or less.

    Where faces' lattices reach into each other there is a proof only while all slopes together
    stay below 1.
    """
    if not fade_is_safe(field):
        return False
    for group in groups(field.lattices):
        lattices = [field.lattices[k] for k in group]
        if len(group) == 1 and not _lattice_is_safe(lattices[0]):
            return False
        if len(group) > 1 and sum(_steepest(_bezier(a), a) for a in lattices) >= 1.0:
            return False
    return True


def _lattice_is_safe(lattice: Lattice) -> bool:
    short = INJECTIVE_BOUND * lattice.grid.spacing_px
    return float(lattice.magnitude_px.max()) < short or lower_bound(lattice) > 0.0


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
        cells = [_bezier(lattice) for lattice in fine]
        if len(group) == 1:
            cells = [_within(cells[0], 2.0 * field.fade_px)]
        slope = sum(_steepest(bezier, a) for bezier, a in zip(cells, fine, strict=True))
        if slope * _FADE_STRETCH >= 1.0:
            return False
    return True


def _within(bezier: Array, length_px: float) -> Array:
    """Return the cells in which the pull may be shorter than `length_px`."""
    # Elsewhere all control points go further one common way, and so does every mixture of them.
    toward = bezier.mean(axis=(2, 3))
    toward /= np.maximum(np.linalg.norm(toward, axis=1, keepdims=True), 1e-12)
    least = np.einsum("nc,ncji->nji", toward, bezier).min(axis=(1, 2))
    return np.asarray(bezier[least <= length_px])


def _steepest(bezier: Array, lattice: Lattice) -> float:
    """Bound the slope of the pull over cells, px per px."""
    along_x, along_y = _slopes(bezier, lattice)
    entries = [np.abs(slope).max(axis=(2, 3)) for slope in (along_x, along_y)]
    return float(np.sqrt(sum((entry**2).sum(axis=1) for entry in entries)).max(initial=0.0))


def lower_bound(lattice: Lattice) -> float:
    """Return a number that no det J of the lattice's field falls below.

    In each cell det J is a polynomial of degree 5 x 5; in Bernstein form it is nowhere smaller
    than its smallest coefficient. Cells that this doesn't settle are quartered.
    """
    coefficients = _det_bernstein(lattice)  # of the cells where anything moves; elsewhere it is 1
    bound = coefficients.min(axis=(1, 2))
    settled = float(bound[bound > 0.0].min(initial=1.0))
    for _ in range(_HALVINGS):
        coefficients = _quartered(coefficients[bound <= 0.0])
        bound = coefficients.min(axis=(1, 2))
        settled = min(settled, float(bound[bound > 0.0].min(initial=1.0)))
    return min(settled, float(bound.min(initial=1.0)))


def _det_bernstein(lattice: Lattice) -> Array:
    """Return the Bernstein coefficients of det J in cells, shape (cells, 6, 6), rows along y."""
    along_x, along_y = _slopes(_bezier(lattice), lattice)
    return np.asarray(
        _product(1.0 + along_x[:, 0], 1.0 + along_y[:, 1]) - _product(along_x[:, 1], along_y[:, 0])
    )


def _bezier(lattice: Lattice) -> Array:
    """Return the Bezier control points of the pull in every cell that isn't zero: (N, 2, 4, 4)."""
    phi = np.pad(lattice.phi, ((ORDER - 1,) * 2, (ORDER - 1,) * 2, (0, 0)))
    blocks = np.lib.stride_tricks.sliding_window_view(phi, (ORDER, ORDER), axis=(0, 1))
    return np.asarray(_TO_BEZIER @ blocks[lattice.cell_bound_px > 0.0] @ _TO_BEZIER.T)


def _slopes(bezier: Array, lattice: Lattice) -> tuple[Array, Array]:
    """Return the Bezier coefficients of the derivatives along x and y, px per px."""
    slope = 3.0 / lattice.grid.spacing_px
    return slope * np.diff(bezier, axis=3), slope * np.diff(bezier, axis=2)


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


def _halves(count: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    left = np.array([[comb(j, i) / 2.0**j for i in range(count)] for j in range(count)])
    return left, left[::-1, ::-1]
