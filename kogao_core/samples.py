"""det J at 8 x 8 samples in each lattice cell, where bounds leave room for a small one."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Final

import numpy as np

from kogao_core.field import Field
from kogao_core.geometry import Array
from kogao_core.lattice import ORDER, Lattice, basis, basis_slope, meet

SAMPLES_PER_CELL: Final = 8
_PLACES: Final = (np.arange(SAMPLES_PER_CELL) + 0.5) / SAMPLES_PER_CELL
# Every sample is the same mixture of the 4 x 4 control points that reach its cell.
_ALONG_X: Final = np.kron(basis(_PLACES), basis_slope(_PLACES)).T
_ALONG_Y: Final = np.kron(basis_slope(_PLACES), basis(_PLACES)).T


def least_dets(field: Field, lattice: Lattice, below: float = np.inf) -> Array:
    """Return the smallest det J of a field at the samples in each cell of one of its lattices.

    Parameters
    ----------
    field : Field
        All displacements together.
    lattice : Lattice
        One of the field's.
    below : float
        Cells where every det J is larger need not be told apart.

    Returns
    -------
    array of shape (J + 3, I + 3)
        Infinite in cells where there is neither the smallest, one `below`, nor one of 0 or less.

    Examples
    --------
    >>> import numpy as np
    >>> import kogao_core as kogao
    >>> from kogao_core.samples import least_dets
    >>> face = kogao.template_face((240, 180), 200)
    >>> photo = np.zeros((360, 480), np.uint8)
    >>> field = kogao.render(photo, [face], kogao.Recipe(percent=6)).field
    >>> dets = least_dets(field, field.lattices[0])
    >>> dets.shape == field.lattices[0].reached.shape, bool(0.5 < dets.min() < 1.0)
    (True, True)
    """
    others = [a for a in field.lattices if a is not lattice and meet(a, lattice)]
    field = dataclasses.replace(field, lattices=(lattice, *others))
    if not field.is_plain:
        return _in_cells(field, lattice, (0, 0), lattice.reached.shape)
    if not others:
        return _alone(lattice)
    edges = lattice.cell_edges_px
    spans = np.stack([edges[0][:-1], edges[0][1:]]), np.stack([edges[1][:-1], edges[1][1:]])
    added = np.sum([a.most_in(a.steepest, spans) for a in others], axis=0)
    slope = lattice.steepest + added
    least = np.full(slope.shape, np.inf)
    if not (open_ := (slope >= 1.0) | ((1.0 - slope) ** 2 < below)).any():
        return least
    # |det(M + E) - det M| <= |M| |E| + |E|^2 / 2, of a slope E that the others add.
    alone, room = _alone(lattice), (np.sqrt(2.0) + slope) * added
    below = max(0.0, min(below, float((alone + room)[open_].min())))
    rows, columns = np.nonzero(open_ & (alone - room <= below))
    if len(rows):
        first, end = (rows.min(), columns.min()), (rows.max() + 1, columns.max() + 1)
        least[first[0] : end[0], first[1] : end[1]] = _in_cells(field, lattice, first, end)
    return least


def _alone(lattice: Lattice) -> Array:
    """Return the smallest det J at the samples in each cell, as if there were no other lattice."""
    (i, j), (rows, columns) = lattice.first, lattice.shape
    margin = ORDER - 1
    stored = lattice.window((i - margin, j - margin), (rows + 2 * margin, columns + 2 * margin))
    cells = np.lib.stride_tricks.sliding_window_view(stored, (ORDER, ORDER), (0, 1))
    phi = cells.reshape(-1, ORDER**2) / lattice.grid.spacing_px
    x_x, y_x = (phi @ _ALONG_X).reshape(-1, 2, SAMPLES_PER_CELL**2).swapaxes(0, 1)
    x_y, y_y = (phi @ _ALONG_Y).reshape(-1, 2, SAMPLES_PER_CELL**2).swapaxes(0, 1)
    det = (1.0 + x_x) * (1.0 + y_y) - y_x * x_y
    return np.asarray(det.min(axis=1).reshape(lattice.reached.shape))


def _in_cells(field: Field, lattice: Lattice, first: Sequence[int], end: Sequence[int]) -> Array:
    """Return the smallest det J at the samples in a block of cells, (row, column) `first` on."""
    (ox, oy), h, (i0, j0) = lattice.grid.origin_px, lattice.grid.spacing_px, lattice.first_cell
    rows, columns = np.arange(first[0], end[0]), np.arange(first[1], end[1])
    xs = ox + h * ((i0 + columns)[:, None] + _PLACES).ravel()
    ys = oy + h * ((j0 + rows)[:, None] + _PLACES).ravel()
    det = field.det_jacobian(xs, ys)
    shape = (len(rows), SAMPLES_PER_CELL, len(columns), SAMPLES_PER_CELL)
    return np.asarray(det.reshape(shape).min(axis=(1, 3)))
