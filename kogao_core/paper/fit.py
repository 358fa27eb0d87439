"""Sections 2.1, 2.2 and 3.3: control points from pairs, eqs. (3) and (4), and the lattice size.

The paper fits coordinates. Here the control points store the *displacement* ``source - target`` and
are fitted at the targets. The displacement is exactly zero beyond the reach of all landmarks, and
the field is directly the backward map for resampling.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.paper.basis import ORDER, basis
from kogao_core.paper.domain import LOSSLESS_PX
from kogao_core.paper.lattice import MIN_SPACING_PX, Grid, Lattice

MULTILEVEL_STEPS: Final = 3  # halvings of the lattice at most: R, R/2, R/4, R/8


@dataclass(frozen=True, eq=False)
class Problem:
    """The displacements (N, 2) requested from one lattice at the targets (N, 2), both px."""

    grid: Grid
    target_px: Array
    displacement_px: Array
    least_px: float = 0.0  # the finest lattice spacing for `multilevel`

    @cached_property
    def support(self) -> Support:
        """The control points within reach of the problem's points."""
        return Support(self)

    def asking(self, displacement_px: Array) -> Problem:
        """Return the problem with another displacement at the same points."""
        return dataclasses.replace(self, displacement_px=displacement_px)


def spacing_px(ratio: float, distance_px: float, least_px: float = 0.0) -> float:
    """Return the lattice spacing h = R x distance, px (section 3.3, figures 8 and 11).

    The paper names two distances: the warp distance and the landmark spacing. `PAPER` takes the
    landmark spacing (`docs/decisions/03`). Result: at least `MIN_SPACING_PX` and `least_px`.
    """
    return max(MIN_SPACING_PX, least_px, ratio * distance_px)


class Support:
    """The 4 x 4 control points of each of a problem's points, eq. (1), and the array they fill."""

    def __init__(self, problem: Problem) -> None:
        self.grid = problem.grid
        column, s = self.grid.locate(problem.target_px[:, 0], 0)
        row, t = self.grid.locate(problem.target_px[:, 1], 1)
        self.first = (int(column.min()) - 1, int(row.min()) - 1)
        self.shape = (int(np.ptp(row)) + ORDER, int(np.ptp(column)) + ORDER)
        reach = np.arange(ORDER) - 1
        rows = row[:, None, None] + reach[:, None] - self.first[1]
        columns = column[:, None, None] + reach - self.first[0]
        self.weights = basis(t)[:, :, None] * basis(s)[:, None, :]
        self.nodes: npt.NDArray[np.int64] = rows * self.shape[1] + columns

    @property
    def size(self) -> int:
        """Number of control points in the array."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def empty(self) -> Lattice:
        return self.lattice(np.zeros((self.size, 2)))

    def lattice(self, phi: Array) -> Lattice:
        """Return the lattice with these control points, shape (size, 2)."""
        return Lattice(self.grid, self.first, phi.reshape(*self.shape, 2))


def approximate(problem: Problem) -> Lattice:
    """B-spline approximation, eqs. (3) and (4).

    Eq. (3) as printed sums over k and l. The source, Lee, Wolberg and Shin (1997), gives every
    landmark c an own ``phi_c = w_c z_c / sum w_ab^2``, with its displacement z and the weights w of
    the 4 x 4 control points around it. Landmarks that share a control point give
    ``phi = sum w_c^2 phi_c / sum w_c^2``, which minimises eq. (4). Result: close to the
    displacements, but not equal where landmarks share control points.
    """
    support = problem.support
    w2 = support.weights**2
    own = support.weights / w2.sum(axis=(1, 2), keepdims=True)
    total = np.bincount(support.nodes.ravel(), w2.ravel(), support.size)
    phi = np.zeros((support.size, 2))
    for c in (0, 1):
        shares = w2 * own * problem.displacement_px[:, c, None, None]
        phi[:, c] = np.bincount(support.nodes.ravel(), shares.ravel(), support.size)
    return support.lattice(phi / np.where(total > 0.0, total, 1.0)[:, None])


def multilevel(problem: Problem) -> Lattice:
    """Approximate, then approximate the residual on ever finer lattices (refs [8], [12]).

    Result: the sum of all levels, on the finest.
    """
    lattice = approximate(problem)
    for _ in range(MULTILEVEL_STEPS):
        left = problem.displacement_px - lattice.at(problem.target_px)
        if np.abs(left).max() < LOSSLESS_PX or lattice.grid.spacing_px < 2.0 * problem.least_px:
            break
        lattice = lattice.refined()
        detail = approximate(dataclasses.replace(problem, grid=lattice.grid, displacement_px=left))
        lattice = lattice.plus(detail)
    return lattice
