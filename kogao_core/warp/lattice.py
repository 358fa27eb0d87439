"""Sections 2.1, 2.2 and 3.3: the control lattice of a uniform cubic B-spline."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box

ORDER = 4  # control points per axis that reach a point: cubic


def basis(s: npt.ArrayLike) -> Array:
    """Return B_0..B_3 of eq. (2) at `s` in [0, 1), shape (..., 4). Result: they sum to 1."""
    s = np.asarray(s, np.float64)
    r = 1.0 - s
    weights: Array = np.empty((*s.shape, ORDER))
    weights[..., 0] = r * r * r
    weights[..., 1] = (3 * s - 6) * s * s + 4
    weights[..., 2] = (3 * r - 6) * r * r + 4
    weights[..., 3] = s * s * s
    weights /= 6.0
    return weights


def basis_slope(s: npt.ArrayLike) -> Array:
    """Return dB_0/ds..dB_3/ds of eq. (2), shape (..., 4). Result: they sum to 0."""
    s = np.asarray(s, np.float64)
    slopes: Array = np.empty((*s.shape, ORDER))
    slopes[..., 0] = -((1.0 - s) ** 2)
    slopes[..., 1] = 3 * s**2 - 4 * s
    slopes[..., 2] = -3 * s**2 + 2 * s + 1
    slopes[..., 3] = s**2
    slopes /= 2.0
    return slopes


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
        """Evaluate eq. (1) at points of shape (N, 2). Return displacements (N, 2), px."""
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
        self,
        xs_px: npt.ArrayLike,
        ys_px: npt.ArrayLike,
        weigh: Callable[[Array], Array] = basis,
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
        # Points are the outer axes in memory: bounds over all cells are then four times as fast.
        points = bezier_along(bezier_along(self.phi).transpose(2, 0, 1, 3)).transpose(2, 0, 4, 3, 1)
        return np.ascontiguousarray(points).transpose(3, 4, 2, 0, 1)

    @cached_property
    def bound_px(self) -> Array:
        """Upper bound of each cell's displacement, (J + 3, I + 3), px (convex hull property)."""
        x, y = self.bezier[:, :, 0], self.bezier[:, :, 1]
        return np.asarray(np.sqrt((x * x + y * y).max(axis=(2, 3))))

    @cached_property
    def least_px(self) -> Array:
        """Lower bound of each cell's displacement, (J + 3, I + 3), px; 0 if directions differ."""
        # Project the Bezier points on their mean direction. The least projection bounds every
        # convex combination, and so every displacement in the cell.
        x, y = np.moveaxis(self.bezier.reshape(*self.reached.shape, 2, ORDER**2), 2, 0)
        toward_x, toward_y = x.mean(axis=2), y.mean(axis=2)
        length = np.maximum(np.hypot(toward_x, toward_y), 1e-12)
        toward_x, toward_y = (toward_x / length)[..., None], (toward_y / length)[..., None]
        return np.asarray(np.maximum(0.0, (x * toward_x + y * toward_y).min(axis=2)))

    @property
    def slopes(self) -> tuple[Array, Array]:
        """Bezier points of the derivatives along x and y in each cell, px per px."""
        per_px = (ORDER - 1) / self.grid.spacing_px
        return per_px * np.diff(self.bezier, axis=4), per_px * np.diff(self.bezier, axis=3)

    @cached_property
    def steepest(self) -> Array:
        """Upper bound of the slope of each cell's displacement, (J + 3, I + 3), px per px."""
        along_x, along_y = (np.abs(slope).max(axis=(3, 4)) for slope in self.slopes)
        return np.asarray(np.sqrt((along_x**2 + along_y**2).sum(axis=2)))

    @cached_property
    def reached(self) -> npt.NDArray[np.bool_]:
        """The cells that a non-zero control point reaches, shape (J + 3, I + 3)."""
        rows, columns = self.shape
        stored = np.zeros((rows + 2 * ORDER - 2, columns + 2 * ORDER - 2), bool)
        stored[ORDER - 1 : 1 - ORDER, ORDER - 1 : 1 - ORDER] = self.phi.any(axis=2)
        along = stored[:-3] | stored[1:-2] | stored[2:-1] | stored[3:]
        return np.asarray(along[:, :-3] | along[:, 1:-2] | along[:, 2:-1] | along[:, 3:])

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
        """Return the same field on the grid of half the spacing (Lee, Wolberg, Shin 1997, 3.4)."""
        rows = _refined_axis(self.phi, 0)
        phi = _refined_axis(rows, 1)
        first = (2 * self.first[0] - 2, 2 * self.first[1] - 2)
        return Lattice(Grid(self.grid.origin_px, self.grid.spacing_px / 2.0), first, phi)


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


def bezier_along(phi: Array) -> Array:
    """Convert B-spline control points along the first axis to Bezier points, for tight bounds.

    `phi` (n, ...). Result (4, n + 3, ...): the four points of each cell.
    """
    p = np.zeros((len(phi) + 6, *phi.shape[1:]))
    p[3:-3] = phi
    twice = 2.0 * p
    thirds = (twice[:-1] + p[1:]) / 3.0, (p[:-1] + twice[1:]) / 3.0
    joints = (thirds[1][:-1] + thirds[0][1:]) / 2.0
    points = np.empty((4, len(phi) + 3, *phi.shape[1:]))
    points[0], points[1] = joints[:-1], thirds[0][1:-1]
    points[2], points[3] = thirds[1][1:-1], joints[1:]
    return points


def _refined_axis(phi: Array, axis: int) -> Array:
    # A cubic B-spline is the sum of five B-splines of half the width, weighted (1 4 6 4 1) / 8.
    phi = np.moveaxis(phi, axis, 0)
    fine = np.zeros((2 * len(phi) + 3, *phi.shape[1:]))
    for offset, weight in enumerate((1.0, 4.0, 6.0, 4.0, 1.0)):
        fine[offset : offset + 2 * len(phi) - 1 : 2] += weight / 8.0 * phi
    return np.moveaxis(fine, 0, axis)
