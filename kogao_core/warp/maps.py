"""Where each pixel of a run of blocks is read: eq. (1) as a few small matrix products.

All products of a lattice have the same shape whatever is worked on: BLAS may round another shape
otherwise, and a pixel's bytes would depend on its neighbours' work.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box
from kogao_core.warp.lattice import Grid, Lattice

Float32 = npt.NDArray[np.float32]
Integers = npt.NDArray[np.int64]

# Columns whose map is one product: about as many as four cells, so that it is 8 control points
# deep. They divide a strip.
SPANS_PX: Final = (512, 256, 128, 64)
# Rows of a product: 32 x 8 x 512 or 32 x 68 x 64 are too few for OpenBLAS to wake threads, from
# 2^18 on, with which rounding could change.
ROWS_PX: Final = 32


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """Runs of blocks, and from where each one's map is counted.

    Single precision is exact to 1/8192 px only near that origin.
    """

    # Int (N, 4): left, top, right, bottom of each: one block's height, and within one strip.
    edges: Integers
    # Int (N, 4): of the part of the source that each may read; it is mapped from its corner.
    views: Integers
    block_px: int  # height of a block


class LatticeMap:
    """The displacement of one lattice on runs of blocks."""

    def __init__(
        self,
        lattice: Lattice,
        image: Box,
        block_px: int,
        everywhere: bool,
        before: LatticeMap | None = None,
    ) -> None:
        self.lattice, self._everywhere = lattice, everywhere
        grid = lattice.grid
        span_px = next((n for n in SPANS_PX if n <= 4 * grid.spacing_px), SPANS_PX[-1])
        left, top, right, bottom = np.clip(lattice.reach_px, 0, (image.right, image.bottom) * 2)
        ends = (
            ((0, image.right), (0, image.bottom)) if everywhere else ((left, right), (top, bottom))
        )
        keys = [
            (grid, axis, size, int(low // size), int(-(-high // size)))
            for axis, size, (low, high) in zip((0, 1), (span_px, block_px), ends, strict=True)
        ]
        known = {axis.key: axis for axis in before.axes} if before is not None else {}
        self.axes: tuple[_Axis, ...] = tuple(known.get(key) or _Axis(*key) for key in keys)

    def prepare(self, runs: Runs) -> None:
        """Gather the control points that each run's spans need."""
        along_x, along_y = self.axes
        left, top, right, _ = runs.edges.T
        first = np.maximum(left // along_x.size_px, along_x.start)
        count = np.minimum(-(-right // along_x.size_px), along_x.end) - first
        band = top // along_y.size_px
        count = np.where((band >= along_y.start) & (band < along_y.end), count, 0).clip(0)
        ends = np.cumsum(count)
        run = np.repeat(np.arange(len(count)), count)
        span = (first + count - ends)[run] + np.arange(len(run))
        self._parts = list(zip((ends - count).tolist(), ends.tolist(), strict=True))
        self._first_spans = first.tolist()
        nodes = along_x.nodes(span), along_y.nodes(band[run])
        self._phi = np.empty((len(run), 2, nodes[1].shape[1], nodes[0].shape[1]), np.float32)
        for axis, phi in enumerate(self._at_nodes(*nodes)):
            if self._everywhere:
                # Linear precision: nodes that hold their own coordinates reproduce the identity.
                place = self.lattice.grid.node_px(nodes[axis], axis) - runs.views[run, axis, None]
                phi += place[:, :, None] if axis else place[:, None, :]
            self._phi[:, axis] = phi

    def _at_nodes(self, i: Integers, j: Integers) -> Array:
        """Return the control points of columns i (N, I) and rows j (N, J), (2, N, J, I)."""
        rows, columns = self.lattice.shape
        stored = np.zeros((2, rows + 2, columns + 2))
        stored[:, 1:-1, 1:-1] = self.lattice.components
        i = np.minimum(np.maximum(i - (self.lattice.first[0] - 1), 0), columns + 1)
        j = np.minimum(np.maximum(j - (self.lattice.first[1] - 1), 0), rows + 1)
        at = j[:, :, None] * (columns + 2) + i[:, None, :]
        return stored.reshape(2, -1).take(at, axis=1)

    def on(self, number: int, run: Box, out: Float32, add: bool) -> None:
        """Write a run's displacement, or with the identity its map, to `out`; or add it.

        `out` float32 (2, block, strip).
        """
        begin, end = self._parts[number]
        if begin == end:
            return
        along_x, along_y = self.axes
        first, spans, size = self._first_spans[number], end - begin, along_x.size_px
        strip_px = out.shape[2] // size
        by = along_y.weights[run.top // along_y.size_px - along_y.start]
        bx = along_x.weights[first - along_x.start : first - along_x.start + spans]
        start = first % strip_px * size
        part = out[:, :, start : start + spans * size]
        # Spans, components and bands of rows are products of their own.
        rows = by.T @ self._phi[begin:end]
        left = rows.reshape(spans, 2, -1, ROWS_PX, rows.shape[3])
        into = np.empty(part.shape, np.float32) if add else part
        view = into.reshape(2, -1, ROWS_PX, spans, size).transpose(3, 0, 1, 2, 4)
        np.matmul(left, bx[:, None, None], out=view)
        if add:
            part += into


class _Axis:
    """The weights, eq. (2), of the control points that reach pieces of an axis."""

    def __init__(self, grid: Grid, axis: int, size_px: int, start: int, end: int) -> None:
        self.key = (grid, axis, size_px, start, end)
        self.size_px, self.start, self.end = size_px, start, end
        self._first, weights = grid.weights(np.arange(start, end) * size_px, size_px, axis)
        self.weights = weights.astype(np.float32)

    def nodes(self, pieces: Integers) -> Integers:
        """Return the nodes that reach each of some pieces, shape (N, nodes)."""
        return np.asarray(
            self._first[pieces - self.start][:, None] + np.arange(self.weights.shape[1])
        )
