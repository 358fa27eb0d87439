"""Eq. (1): the control lattice of a uniform cubic B-spline; sums of lattices."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box
from kogao_core.paper import bounds
from kogao_core.paper.basis import ORDER, basis, basis_slope

MIN_SPACING_PX: Final = 1.0  # least lattice spacing, px
# Control points are multiples of 1/4096 px, so that a drag of one landmark leaves distant control
# points exactly unchanged.
QUANTUM_PX: Final = 2.0**-12


@dataclass(frozen=True, slots=True)
class Grid:
    """Positions of lattice nodes: node (i, j) is at ``origin + spacing * (i, j)``, px."""

    origin_px: tuple[float, float]  # position (x, y) of node (0, 0)
    spacing_px: float  # distance h between neighbouring nodes

    def locate(self, coords_px: npt.ArrayLike, axis: int) -> tuple[npt.NDArray[np.int64], Array]:
        """Return the cell [u] of each coordinate and the fraction s = u - [u]; axis 0 is x.

        Result: in the shape of `coords_px`: cells, and fractions from 0 up to 1.
        """
        u = (np.asarray(coords_px, np.float64) - self.origin_px[axis]) / self.spacing_px
        cell = np.floor(u)
        return cell.astype(np.int64), np.asarray(u - cell, np.float64)

    def nodes_px(self, first: int, count: int, axis: int) -> Array:
        """Return the coordinates of `count` nodes from index `first`; axis 0 is x.

        Result (count,) px.
        """
        return self.node_px(np.arange(first, first + count), axis)

    def node_px(self, index: npt.NDArray[np.int64], axis: int) -> Array:
        """Return the coordinate of each node; axis 0 is x, px, in the shape of `index`."""
        return np.asarray(self.origin_px[axis] + self.spacing_px * index.astype(np.float64))


@dataclass(frozen=True, eq=False)
class Lattice:
    """Control points of the displacement field of one face. Nodes that are not stored are zero."""

    grid: Grid  # node positions
    first: tuple[int, int]  # node index (i, j) of ``phi[0, 0]``; i runs along x, j along y
    phi: Array  # (J, I, 2): displacement (x, y) of each control point, px

    @property
    def shape(self) -> tuple[int, int]:
        """Stored control points (rows, columns)."""
        return self.phi.shape[0], self.phi.shape[1]

    def at(self, points_px: npt.ArrayLike) -> Array:
        """Evaluate eq. (1) at points of shape (N, 2). Return displacements (N, 2), px.

        ``sum over k, l of B_k(s) B_l(t) phi[j + l, i + k]`` as two products of matrices; `by` and
        `bx` hold B_l(t) and B_k(s) in the columns of their nodes.
        """
        points = np.asarray(points_px, np.float64)
        bx, by = self.weights_at(points[:, 0], points[:, 1])
        rows = by @ self.phi.reshape(len(self.phi), -1)
        return np.asarray((bx[:, None] @ rows.reshape(len(by), *self.phi.shape[1:]))[:, 0])

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        """Evaluate eq. (1) on the tensor grid ``ys x xs``.

        `xs_px`, `ys_px` (N,) and (M,). Result (2, M, N): x and y component of the displacement, px.
        """
        return self.mixed(*self.weights_at(xs_px, ys_px))

    def weights_at(
        self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike, weigh: Callable[[Array], Array] = basis
    ) -> tuple[Array, Array]:
        """Return the weights of the stored nodes at coordinates along x (X,) and along y (Y,).

        `weigh`: `basis` or `basis_slope`. Result: shapes (X, columns) and (Y, rows).
        """
        found = []
        for axis, coords_px in enumerate((xs_px, ys_px)):
            cell, s = self.grid.locate(coords_px, axis)
            count = self.shape[1 - axis]
            # Give nodes outside the stored ones columns as well, and cut these off at the end.
            column = np.clip(cell - (self.first[axis] + 1), -ORDER, count) + ORDER
            weights: Array = np.zeros((len(cell), count + 2 * ORDER))
            np.put_along_axis(weights, column[:, None] + np.arange(ORDER), weigh(s), axis=1)
            found.append(weights[:, ORDER:-ORDER])
        return found[0], found[1]

    def mixed(self, bx: Array, by: Array) -> Array:
        """Return weighted sums (2, M, N) of control points on a tensor grid, from `weights_at`."""
        return np.asarray(by @ self.components @ bx.T)

    @cached_property
    def components(self) -> Array:
        """`phi` of shape (2, J, I)."""
        return np.ascontiguousarray(self.phi.transpose(2, 0, 1))

    def window(self, first: tuple[int, int], shape: tuple[int, int]) -> Array:
        """Cut `shape` (rows, columns) control points from node `first`; zeros outside.

        Result (rows, columns, 2) px.
        """
        cut = np.zeros((*shape, 2))
        j0, i0 = first[1] - self.first[1], first[0] - self.first[0]
        rows = slice(max(0, j0), max(0, min(self.shape[0], j0 + shape[0])))
        columns = slice(max(0, i0), max(0, min(self.shape[1], i0 + shape[1])))
        if rows.start < rows.stop and columns.start < columns.stop:
            cut[rows.start - j0 : rows.stop - j0, columns.start - i0 : columns.stop - i0] = (
                self.phi[rows, columns]
            )
        return cut

    def within(self, image: Box) -> Lattice:
        """Return the lattice without control points that don't reach `image`.

        Returns `self` if every stored control point reaches the image.
        """
        columns = self._reaching(image.left, image.right, 0)
        rows = self._reaching(image.top, image.bottom, 1)
        first, shape = (columns.start, rows.start), (len(rows), len(columns))
        if (first, shape) == (self.first, self.shape):
            return self
        return Lattice(self.grid, first, self.window(first, shape))

    def _reaching(self, start_px: int, stop_px: int, axis: int) -> range:
        """Return the stored nodes along an axis that reach a span of pixels; at least one."""
        cells, _ = self.grid.locate([start_px, stop_px - 1], axis)
        first, end = int(cells[0]) - 1, int(cells[1]) + ORDER - 1
        mine = range(self.first[axis], self.first[axis] + self.shape[1 - axis])
        first = max(first, mine.start)
        return range(first, max(first + 1, min(end, mine.stop)))

    def plus(self, other: Lattice) -> Lattice:
        """Return the sum of two fields over the nodes of both, on the finer of their grids.

        The grids must differ only by halvings.
        """
        if other.grid.spacing_px > self.grid.spacing_px:
            return self.plus(other.refined())
        if self.grid.spacing_px > other.grid.spacing_px:
            return self.refined().plus(other)
        first = (min(self.first[0], other.first[0]), min(self.first[1], other.first[1]))
        last_i = max(self.first[0] + self.shape[1], other.first[0] + other.shape[1])
        last_j = max(self.first[1] + self.shape[0], other.first[1] + other.shape[0])
        shape = (last_j - first[1], last_i - first[0])
        return Lattice(self.grid, first, self.window(first, shape) + other.window(first, shape))

    def minus(self, other: Lattice) -> Lattice:
        """Return the difference of two fields; see `plus`."""
        return self.plus(other.scaled(-1.0))

    def scaled(self, factor: float) -> Lattice:
        """Return the field with every displacement multiplied by `factor`."""
        return Lattice(self.grid, self.first, factor * self.phi)

    @cached_property
    def magnitude_px(self) -> Array:
        """Length of each control point's displacement, shape (J, I), px."""
        return np.asarray(np.hypot(self.phi[..., 0], self.phi[..., 1]))

    @cached_property
    def bezier(self) -> Array:
        """Bezier points of the displacement in each cell that a stored node reaches, px.

        Shape (J + 3, I + 3, 2, 4, 4): cell row, cell column, component, points along y and x.
        Entry [0, 0] belongs to `first_cell`.
        """
        return bounds.bezier(self.phi)

    @cached_property
    def bound_px(self) -> Array:
        """Upper bound of each cell's displacement, (J + 3, I + 3), px (convex hull property)."""
        return bounds.longest(self.bezier)

    @cached_property
    def least_px(self) -> Array:
        """Lower bound of each cell's displacement, (J + 3, I + 3), px; 0 if directions differ."""
        return bounds.shortest(self.bezier)

    @property
    def slopes(self) -> tuple[Array, Array]:
        """Bezier points of the derivatives along x and y in each cell, px per px."""
        return bounds.slopes(self.bezier, self.grid.spacing_px)

    @cached_property
    def steepest(self) -> Array:
        """Upper bound of the slope of each cell's displacement, (J + 3, I + 3), px per px."""
        return bounds.steepest(*self.slopes)

    @cached_property
    def reached(self) -> npt.NDArray[np.bool_]:
        """The cells that a non-zero control point reaches, shape (J + 3, I + 3)."""
        return bounds.reached(self.phi)

    @property
    def first_cell(self) -> tuple[int, int]:
        """Index (i, j) of the first cell that a stored node reaches."""
        return self.first[0] - 2, self.first[1] - 2

    @cached_property
    def cell_spans_px(self) -> tuple[Array, Array]:
        """Start and end of each column of cells along x, and of each row along y, px."""
        (i, j), (rows, columns) = self.first_cell, self.reached.shape
        x, y = self.grid.nodes_px(i, columns + 1, 0), self.grid.nodes_px(j, rows + 1, 1)
        return np.stack([x[:-1], x[1:]]), np.stack([y[:-1], y[1:]])

    @cached_property
    def reach_px(self) -> tuple[float, float, float, float]:
        """Rectangle (left, top, right, bottom) outside which the field is zero, px."""
        (i0, j0), (rows, columns) = self.first_cell, (n + ORDER - 1 for n in self.shape)
        h, (ox, oy) = self.grid.spacing_px, self.grid.origin_px
        return ox + h * i0, oy + h * j0, ox + h * (i0 + columns), oy + h * (j0 + rows)

    @property
    def box(self) -> Box:
        """Pixels of the rectangle `reach_px`."""
        left, top, right, bottom = self.reach_px
        return Box(math.floor(left), math.floor(top), math.ceil(right) + 1, math.ceil(bottom) + 1)

    def reaches(self, points_px: Array) -> npt.NDArray[np.bool_]:
        """Return whether the field may be non-zero at each point, (N, 2). Result: bool (N,)."""
        left, top, right, bottom = self.reach_px
        x, y = points_px.T
        return np.asarray((x > left) & (x < right) & (y > top) & (y < bottom))

    def most_in(self, values: Array, spans_px: tuple[Array, Array]) -> Array:
        """Return the maximum of cell values in each rectangle of a grid; 0 outside all cells.

        `values` (..., J + 3, I + 3): one value per cell. `spans_px` (2, columns) and (2, rows):
        start and end of the rectangles. Result (..., rows, columns).
        """
        rows, columns = values.shape[-2:]
        found = np.zeros((*values.shape[:-2], rows + 2, columns + 2))
        found[..., 1:-1, 1:-1] = values
        for axis, end in ((1, rows + 1), (0, columns + 1)):
            cells, _ = self.grid.locate(spans_px[axis], axis)
            low, high = np.minimum(np.maximum(cells - (self.first_cell[axis] - 1), 0), end)
            most = found.take(low, -1 - axis)
            for k in range(1, int((high - low).max(initial=0)) + 1):
                np.maximum(most, found.take(np.minimum(low + k, high), -1 - axis), out=most)
            found = most
        return found

    def refined(self) -> Lattice:
        """Return the field on a grid of half the spacing (Lee, Wolberg, Shin 1997, 3.4)."""
        rows = _refined_axis(self.phi, 0)
        phi = _refined_axis(rows, 1)
        first = (2 * self.first[0] - 2, 2 * self.first[1] - 2)
        return Lattice(Grid(self.grid.origin_px, self.grid.spacing_px / 2.0), first, phi)


@dataclass(frozen=True, eq=False)
class Spline:
    """The sum of the fields of several lattices, one for each face."""

    lattices: tuple[Lattice, ...]

    @cached_property
    def _reaches_px(self) -> Array:
        """Left, top, right and bottom of the rectangles outside which each field is zero, px."""
        return np.reshape([lattice.reach_px for lattice in self.lattices], (-1, 4)).T

    def at(self, points: Array) -> Array:
        """Return the displacement at points of shape (N, 2), same shape, px."""
        displacement: Array = np.zeros_like(points)
        if not len(points):
            return displacement
        (least_x, least_y), (most_x, most_y) = points.min(axis=0), points.max(axis=0)
        left, top, right, bottom = self._reaches_px
        reaching = (left < most_x) & (right > least_x) & (top < most_y) & (bottom > least_y)
        for k in np.flatnonzero(reaching):
            lattice = self.lattices[k]
            near = np.flatnonzero(lattice.reaches(points))
            if len(near):
                displacement[near] += lattice.at(points[near])
        return displacement

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        """Return the displacement on an ascending grid, (2, M, N), px."""
        total: Array = np.zeros((2, np.size(ys_px), np.size(xs_px)))
        for lattice, part, xs, ys in self._reaching(xs_px, ys_px):
            total[:, *part] += lattice.on_grid(xs, ys)
        return total

    def slopes(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the derivatives along x and along y on a grid, each (2, M, N)."""
        along_x, along_y = np.zeros((2, 2, np.size(ys_px), np.size(xs_px)))
        for lattice, part, xs, ys in self._reaching(xs_px, ys_px):
            (bx, by), h = lattice.weights_at(xs, ys), lattice.grid.spacing_px
            slope_x, slope_y = lattice.weights_at(xs, ys, basis_slope)
            along_x[:, *part] += lattice.mixed(slope_x / h, by)
            along_y[:, *part] += lattice.mixed(bx, slope_y / h)
        return along_x, along_y

    def _reaching(
        self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike
    ) -> Iterator[tuple[Lattice, tuple[slice, slice], Array, Array]]:
        """Yield each lattice that reaches a grid, with rows, columns and coordinates within it."""
        xs, ys = np.asarray(xs_px, np.float64), np.asarray(ys_px, np.float64)
        if any((axis[1:] < axis[:-1]).any() for axis in (xs, ys)):
            raise ValueError("the coordinates of a grid must ascend; ask for places by Field.at")
        for lattice in self.lattices:
            left, top, right, bottom = lattice.reach_px
            rows = slice(*np.searchsorted(ys, [top, bottom]))
            columns = slice(*np.searchsorted(xs, [left, right]))
            if rows.start < rows.stop and columns.start < columns.stop:
                yield lattice, (rows, columns), xs[columns], ys[rows]


def quantised(lattice: Lattice) -> Lattice:
    """Return the lattice with control points rounded to the nearest multiples of `QUANTUM_PX`."""
    phi = np.round(lattice.phi / QUANTUM_PX) * QUANTUM_PX
    return Lattice(lattice.grid, lattice.first, phi)


def groups(lattices: Sequence[Lattice]) -> list[list[int]]:
    """Group lattices that overlap, directly or through others. Return indices per group."""
    found: list[list[int]] = []
    for k, lattice in enumerate(lattices):
        near = [group for group in found if any(meet(lattice, lattices[i]) for i in group)]
        merged = sorted([k, *(index for group in near for index in group)])
        found = [group for group in found if group not in near] + [merged]
    return found


def meet(a: Lattice, b: Lattice) -> bool:
    """Return whether the supports of two lattices overlap."""
    (left, top, right, bottom), (l2, t2, r2, b2) = a.reach_px, b.reach_px
    return left < r2 and l2 < right and top < b2 and t2 < bottom


def _refined_axis(phi: Array, axis: int) -> Array:
    # A cubic B-spline is the sum of five B-splines of half the width, weighted (1 4 6 4 1) / 8.
    phi = np.moveaxis(phi, axis, 0)
    fine = np.zeros((2 * len(phi) + 3, *phi.shape[1:]))
    for offset, weight in enumerate((1.0, 4.0, 6.0, 4.0, 1.0)):
        fine[offset : offset + 2 * len(phi) - 1 : 2] += weight / 8.0 * phi
    return np.moveaxis(fine, 0, axis)
