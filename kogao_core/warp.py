"""Backward resampling into a result, in place and in fixed tiles.

A pixel's bytes depend only on the source, the control points near it and its tile's fixed place,
never on which other tiles are worked on: a partial update equals a full one bit for bit.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.domain import Cells, Domain
from kogao_core.field import Field, fade
from kogao_core.geometry import Box, Image
from kogao_core.lattice import ORDER, Lattice, basis
from kogao_core.recipe import Interpolation
from kogao_core.threads import default_threads, pool

TILE_WIDTH_PX: Final = 256
TILE_HEIGHT_PX: Final = 128
_MARGIN_PX: Final = 256  # source pixels kept round a tile; doubled while a pull is longer
_KERNEL_REACH_PX: Final = 8
# OpenBLAS multiplies rows x depth x columns of this many with more than one thread.
_ONE_BLAS_THREAD: Final = 2**18 - 1
_FLAGS: Final[dict[Interpolation, int]] = {
    "bilinear": cv2.INTER_LINEAR,
    "cubic": cv2.INTER_CUBIC,
    "lanczos4": cv2.INTER_LANCZOS4,
}
_DTYPES: Final = (np.uint8, np.uint16, np.float32)
_MAX_CHANNELS: Final = 4

Float32 = npt.NDArray[np.float32]
Tile = tuple[int, int]  # (row, column) in the tile grid


class Canvas:
    """A result buffer over one source; tiles that are no longer warped get their source back.

    Parameters
    ----------
    source : array of shape (H, W) or (H, W, C)
        uint8, uint16 or float32 with 1 to 4 channels; never written to.

    Raises
    ------
    ValueError
        If depth, channels or size can't be warped.
    """

    def __init__(self, source: Image) -> None:
        _check(source)
        self.source = source
        self.image = Box.of(source)
        self.pixels = np.array(source, order="C")
        self._warped: set[Tile] = set()
        self._job: _Job | None = None

    def pull(
        self, field: Field, domain: Domain, interpolation: Interpolation, threads: int | None = None
    ) -> list[Box]:
        """Resample the tiles of `domain` from the source; return the boxes that may differ now."""
        active = self._tiles(domain)
        job = _Job(self.source, self.pixels, field, _FLAGS[interpolation])
        stale, kept = self._warped - active, self._warped & active
        if self._job is not None and job.resembles(self._job):
            todo = active - (kept - self._touched(_changes(self._job.field, field)))
        else:
            todo = active
        for tile in stale:
            rows, columns = self._box(tile).slices
            self.pixels[rows, columns] = self.source[rows, columns]
        _spread(job, [self._box(tile) for tile in sorted(todo)], threads or default_threads())
        self._warped, self._job = active, job
        return [self._box(tile) for tile in sorted(todo | stale)]

    def _tiles(self, domain: Domain) -> set[Tile]:
        if domain.name == "image":
            return {(row, column) for row, column in np.ndindex(self._tile_counts)}
        return self._touched(domain.cells)

    @property
    def _tile_counts(self) -> tuple[int, int]:
        return -(-self.image.height // TILE_HEIGHT_PX), -(-self.image.width // TILE_WIDTH_PX)

    def _touched(self, regions: Iterable[Cells]) -> set[Tile]:
        """Return the tiles that share a pixel with an active cell."""
        rows, columns = self._tile_counts
        hit = np.zeros((rows, columns), bool)
        for cells in regions:
            over_rows = _overlaps(cells.edges_px(1), rows, TILE_HEIGHT_PX, self.image.height)
            over_columns = _overlaps(cells.edges_px(0), columns, TILE_WIDTH_PX, self.image.width)
            hit |= over_rows @ cells.active @ over_columns.T
        return {(row, column) for row, column in np.argwhere(hit).tolist()}

    def _box(self, tile: Tile) -> Box:
        top, left = tile[0] * TILE_HEIGHT_PX, tile[1] * TILE_WIDTH_PX
        return Box(left, top, left + TILE_WIDTH_PX, top + TILE_HEIGHT_PX).clipped(self.image)


def _changes(before: Field, after: Field) -> list[Cells]:
    """Return the cells whose control points differ; the fields' grids are equal."""
    changes = [b.minus(a) for a, b in zip(before.lattices, after.lattices, strict=True)]
    return [Cells(change, change.cell_bound_px > 0.0) for change in changes]


def _check(source: Image) -> None:
    if source.dtype not in _DTYPES:
        raise ValueError(f"pixels must be uint8, uint16 or float32, got {source.dtype}")
    if source.ndim not in (2, 3) or (
        source.ndim == 3 and not 1 <= source.shape[2] <= _MAX_CHANNELS
    ):
        raise ValueError(f"pixels must have shape (H, W) or (H, W, 1..4), got {source.shape}")
    if 0 in source.shape:
        raise ValueError("the image is empty")


def _overlaps(
    edges_px: npt.NDArray[np.int64], tiles: int, size_px: int, end_px: int
) -> npt.NDArray[np.bool_]:
    """Return which cells (columns) share pixels with which tiles (rows) along one axis."""
    start = np.arange(tiles)[:, None] * size_px
    end = np.minimum(start + size_px, end_px)
    low, high = edges_px[:-1], edges_px[1:]
    return np.asarray((low < end) & (high > start) & (low < high))


class _Job:
    """One warp: everything its tiles share."""

    def __init__(self, source: Image, result: Image, field: Field, flag: int) -> None:
        self.source, self.result, self.flag, self.field = source, result, flag, field
        self.image = Box.of(source)
        self.maps = [_LatticeMap(lattice, self.image) for lattice in field.lattices]
        self.margin_px = _MARGIN_PX
        longest = sum(float(lattice.magnitude_px.max()) for lattice in field.lattices)
        while self.margin_px < longest + _KERNEL_REACH_PX:
            self.margin_px *= 2

    def resembles(self, other: _Job) -> bool:
        """Return True when equal control points give equal bytes in both jobs."""
        return self._terms == other._terms

    @property
    def _terms(self) -> tuple[object, ...]:
        grids = tuple(lattice.grid for lattice in self.field.lattices)
        return self.flag, self.margin_px, self.field.fade_px, grids

    def run(self, box: Box) -> None:
        view = box.grown(self.margin_px).clipped(self.image)
        map_x, map_y = self._map(box, (view.left, view.top))
        rows, columns = box.slices
        cv2.remap(
            self.source[view.slices],
            map_x,
            map_y,
            self.flag,
            dst=self.result[rows, columns],
            borderMode=cv2.BORDER_REPLICATE,
        )

    def _map(self, box: Box, origin: tuple[int, int]) -> Float32:
        """Return where each pixel of `box` is read, relative to `origin`: (2, height, width)."""
        if self.field.fade_px > 0.0 or not self.maps:
            return self._faded_map(box, origin)
        # Always the first lattice: which one carries the identity decides how that is rounded.
        first, *others = self.maps
        total = first.on(box, origin)
        for other in others:
            if other.reaches(box):
                total += other.on(box)
        return total

    def _faded_map(self, box: Box, origin: tuple[int, int]) -> Float32:
        total = np.zeros((2, box.height, box.width), np.float32)
        for lattice_map in self.maps:
            if lattice_map.reaches(box):
                total += lattice_map.on(box)
        total *= fade(np.hypot(total[0], total[1]), self.field.fade_px)
        total[0] += np.arange(box.left, box.right) - origin[0]
        total[1] += (np.arange(box.top, box.bottom) - origin[1])[:, None]
        return total


class _LatticeMap:
    """Eq. (1) at every pixel of a tile, as two small matrix products in single precision."""

    def __init__(self, lattice: Lattice, image: Box) -> None:
        self.lattice = lattice
        self._axes = [_axis(lattice, size, k) for k, size in enumerate((image.right, image.bottom))]
        self._weights: dict[tuple[int, int, int], tuple[int, Float32]] = {}

    def reaches(self, box: Box) -> bool:
        """Return False when the pull on `box` is all zeros, which needn't be added."""
        left, top, right, bottom = self.lattice.reach_px
        return left < box.right and box.left < right and top < box.bottom and box.top < bottom

    def on(self, box: Box, origin: tuple[int, int] | None = None) -> Float32:
        """Return the pull on `box`, or with `origin` the absolute map seen from there."""
        first_i, bx = self._axis_weights(box.left, box.right, 0)
        first_j, by = self._axis_weights(box.top, box.bottom, 1)
        phi = self.lattice.window((first_i, first_j), (by.shape[1], bx.shape[1]))
        if origin is not None:
            # Linear precision: nodes that hold their own coordinates reproduce the identity map.
            grid = self.lattice.grid
            phi[..., 0] += grid.nodes_px(first_i, bx.shape[1], 0) - origin[0]
            phi[..., 1] += (grid.nodes_px(first_j, by.shape[1], 1) - origin[1])[:, None]
        planes = np.ascontiguousarray(phi.transpose(2, 0, 1), np.float32)
        return _product(by @ planes, bx.T)

    def _axis_weights(self, start_px: int, stop_px: int, axis: int) -> tuple[int, Float32]:
        # Tiles of a row or column share their weights; threads may at worst compute them twice.
        key = (start_px, stop_px, axis)
        if key not in self._weights:
            cells, values = (part[start_px:stop_px] for part in self._axes[axis])
            weights = np.zeros((len(cells), int(cells[-1] - cells[0]) + ORDER), np.float32)
            np.put_along_axis(weights, (cells - cells[0])[:, None] + np.arange(ORDER), values, 1)
            self._weights[key] = int(cells[0]) - 1, weights
        return self._weights[key]


def _product(left: Float32, right: Float32) -> Float32:
    """Multiply in blocks of rows so small that BLAS keeps them in one thread.

    Otherwise the bits, and with them a pixel, would depend on how many threads BLAS has just then.
    """
    result = np.empty((*left.shape[:-1], right.shape[1]), np.float32)
    step = max(1, _ONE_BLAS_THREAD // right.size)
    for top in range(0, left.shape[-2], step):
        rows = slice(top, top + step)
        np.matmul(left[:, rows], right, out=result[:, rows])
    return result


def _axis(lattice: Lattice, size_px: int, axis: int) -> tuple[npt.NDArray[np.int64], Float32]:
    """Return the cell of every pixel along an axis and its four weights, eq. (2)."""
    cells, s = lattice.grid.locate(np.arange(size_px), axis)
    return cells, basis(s).astype(np.float32)


def _spread(job: _Job, boxes: Iterable[Box], threads: int) -> None:
    # Each thread takes the next tile when it is done with one; a future per tile costs more than
    # the tile.
    waiting = deque(boxes)

    def work() -> None:
        while True:
            try:
                box = waiting.popleft()
            except IndexError:
                return
            job.run(box)

    helpers = [pool(threads).submit(work) for _ in range(min(threads, len(waiting)) - 1)]
    work()
    for helper in helpers:
        helper.result()
