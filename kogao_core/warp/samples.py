"""det J at 8 x 8 samples in each lattice cell, where bounds leave room for a small one."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from itertools import compress
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.warp.field import Field, det_of
from kogao_core.warp.lattice import ORDER, Lattice, basis, basis_slope, meet

SAMPLES_PER_CELL: Final = 8
_PLACES: Final = (np.arange(SAMPLES_PER_CELL) + 0.5) / SAMPLES_PER_CELL
# Every sample is the same mixture of the 4 x 4 control points that reach its cell.
_ALONG_X: Final = np.kron(basis(_PLACES), basis_slope(_PLACES)).T
_ALONG_Y: Final = np.kron(basis_slope(_PLACES), basis(_PLACES)).T

Slopes = tuple[Array, Array]
"""Derivatives along x and along y, each of the x and the y component."""


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
