"""Backward resampling into a result, in place and in fixed blocks.

A pixel's bytes depend only on the source, the control points near it and its block's fixed place,
never on which other blocks are worked on: a partial update equals a full one bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Final, assert_never

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.domain import Cells, Domain, Mask
from kogao_core.field import Field, fade
from kogao_core.geometry import Box, Image
from kogao_core.lattice import ORDER, Grid, Lattice, basis
from kogao_core.settings import Interpolation
from kogao_core.threads import default_threads, share_out

BLOCK_WIDTH_PX: Final = 16  # what is worked on or left alone
BLOCK_HEIGHT_PX: Final = 128
SMALL_BLOCK_HEIGHT_PX: Final = 64  # of images up to this many pixels:
_SMALL_IMAGE_PX: Final = 2_000_000
SPAN_PX: Final = 256  # columns whose map is one matrix product
# Pixels resampled by one call at most: OpenCV spreads calls of more than 98,000 over threads of its
# own, which compete with ours.
_CALL_PX: Final = 2**16
_THREAD_PX: Final = 400_000  # waking another thread costs about as much as warping this many
_MARGIN_PX: Final = 256  # source pixels kept round a strip; doubled while a displacement is longer
_KERNEL_REACH_PX: Final = 8
# OpenBLAS multiplies rows x depth x columns of this many with more than one thread.
_ONE_BLAS_THREAD: Final = 2**18 - 1
_DTYPES: Final = (np.uint8, np.uint16, np.float32)
_MAX_CHANNELS: Final = 4

Float32 = npt.NDArray[np.float32]


class Canvas:
    """A result buffer over one source; blocks no longer warped get their source back.

    After an exception in the middle of `warp` the pixels hold a part of it; the next call puts all
    of them right.

    Parameters
    ----------
    source : array of shape (H, W) or (H, W, C)
        uint8, uint16 or float32 with 1 to 4 channels; never written to.

    Raises
    ------
    ValueError
        If depth, channels or size can't be warped.

    Examples
    --------
    >>> import numpy as np
    >>> import kogao_core as kogao
    >>> from kogao_core.warp import Canvas
    >>> face = kogao.template_face((240, 180), 200)
    >>> photo = np.zeros((360, 480), np.uint8)
    >>> canvas = Canvas(photo)
    >>> first = kogao.render(photo, [face], kogao.Recipe(percent=6), canvas=canvas)
    >>> later = kogao.render(photo, [face], kogao.Recipe(percent=7), canvas=canvas)
    >>> later.pixels is first.pixels is canvas.pixels
    True
    """

    def __init__(self, source: Image) -> None:
        _check(source)
        self.source = source
        self.image = Box.of(source)
        self.pixels = np.array(source, order="C")
        small = self.image.area <= _SMALL_IMAGE_PX
        self._block = (SMALL_BLOCK_HEIGHT_PX if small else BLOCK_HEIGHT_PX), BLOCK_WIDTH_PX
        self.strip_px = _CALL_PX // self._block[0]
        shape = [-(-a // b) for a, b in zip(source.shape, self._block, strict=False)]
        self._warped: Mask = np.zeros(shape, bool)
        self._job: _Job | None = None

    def warp(
        self, field: Field, domain: Domain, interpolation: Interpolation, threads: int | None = None
    ) -> list[Box]:
        """Resample the blocks of `domain` from the source; return the boxes that may differ now."""
        active = self._blocks(domain)
        job = _Job(self, field, _flag(interpolation), self._job)
        stale, todo = self._warped & ~active, active
        if self._job is not None and job.resembles(self._job):
            todo = active & ~(self._warped & ~self._touched(_changes(self._job.field, field)))
        given_back, redone = self._runs(stale), self._runs(todo)
        # Whatever is raised from here on, the next call does all these blocks again.
        self._warped, self._job = self._warped | active, None
        for box in given_back:
            self.pixels[box.slices] = self.source[box.slices]
        _spread(job, redone, threads or default_threads())
        self._warped, self._job = active, job
        return redone + given_back

    def _blocks(self, domain: Domain) -> Mask:
        if domain.name == "image":
            return np.ones_like(self._warped)
        return self._touched(domain.cells)

    def _touched(self, regions: Iterable[Cells]) -> Mask:
        """Return the blocks that share a pixel with an active cell."""
        rows, columns = self._warped.shape
        hit = np.zeros_like(self._warped)
        for cells in regions:
            over_rows = _overlaps(cells.edges_px(1), rows, self._block[0], self.image.height)
            over_columns = _overlaps(cells.edges_px(0), columns, self._block[1], self.image.width)
            hit |= over_rows @ cells.active @ over_columns.T
        return hit

    def _runs(self, blocks: Mask) -> list[Box]:
        """Return the boxes of neighbouring blocks in a row, cut where strips end."""
        (height, width), image = self._block, self.image
        boxes = []
        for row in np.flatnonzero(blocks.any(axis=1)).tolist():
            top, bottom = row * height, min((row + 1) * height, image.bottom)
            edges = width * np.flatnonzero(np.diff(blocks[row], prepend=False, append=False))
            for left, end in edges.reshape(-1, 2).tolist():
                right = left
                while right < end:
                    left, right = right, min(end, (right // self.strip_px + 1) * self.strip_px)
                    boxes.append(Box(left, top, min(right, image.right), bottom))
        return boxes


def _flag(interpolation: Interpolation) -> int:
    match interpolation:
        case "bilinear":
            return cv2.INTER_LINEAR
        case "cubic":
            return cv2.INTER_CUBIC
        case "lanczos4":
            return cv2.INTER_LANCZOS4
        case unknown:
            assert_never(unknown)


def _changes(before: Field, after: Field) -> list[Cells]:
    """Return the cells whose control points differ; the fields' grids are equal."""
    changes = [b.minus(a) for a, b in zip(before.lattices, after.lattices, strict=True)]
    return [Cells(change, change.reached) for change in changes]


def _check(source: Image) -> None:
    if source.dtype not in _DTYPES:
        raise ValueError(f"pixels must be uint8, uint16 or float32, got {source.dtype}")
    if source.ndim not in (2, 3) or (
        source.ndim == 3 and not 1 <= source.shape[2] <= _MAX_CHANNELS
    ):
        raise ValueError(f"pixels must have shape (H, W) or (H, W, 1..4), got {source.shape}")
    if 0 in source.shape:
        raise ValueError("the image is empty")


def _overlaps(edges_px: npt.NDArray[np.int64], blocks: int, size_px: int, end_px: int) -> Mask:
    """Return which cells (columns) share pixels with which blocks (rows) along one axis."""
    start = np.arange(blocks)[:, None] * size_px
    end = np.minimum(start + size_px, end_px)
    low, high = edges_px[:-1], edges_px[1:]
    return np.asarray((low < end) & (high > start) & (low < high))


class _Job:
    """One warp: everything its runs of blocks share."""

    def __init__(self, canvas: Canvas, field: Field, flag: int, before: _Job | None) -> None:
        self.source, self.result, self.image = canvas.source, canvas.pixels, canvas.image
        self.strip_px, self.field, self.flag = canvas.strip_px, field, flag
        known = {m.lattice.grid: m.axes for m in before.maps} if before is not None else {}
        self.maps: list[_LatticeMap] = [
            _LatticeMap(lattice, known.get(lattice.grid) or _axes(lattice.grid, self.image))
            for lattice in field.lattices
        ]
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
        field = self.field
        return self.flag, self.margin_px, field.fade_px, field.falloff.strokes, grids

    def run(self, box: Box, buffer: Float32) -> None:
        """Resample `box`, a run of blocks; `buffer` has room for the map of a strip."""
        left = box.left // self.strip_px * self.strip_px
        strip = Box(left, box.top, left + self.strip_px, box.bottom).clipped(self.image)
        view = strip.grown(self.margin_px).clipped(self.image)
        spans = Box(
            box.left // SPAN_PX * SPAN_PX,
            box.top,
            min(-(-box.right // SPAN_PX) * SPAN_PX, self.image.right),
            box.bottom,
        )
        total = buffer[: 2 * spans.area].reshape(2, spans.height, spans.width)
        self._map(strip, spans, (view.left, view.top), total)
        columns = slice(box.left - spans.left, box.right - spans.left)
        cv2.remap(
            self.source[view.slices],
            total[0, :, columns],
            total[1, :, columns],
            self.flag,
            dst=self.result[box.slices],
            borderMode=cv2.BORDER_REPLICATE,
        )

    def _map(self, strip: Box, box: Box, origin: tuple[int, int], total: Float32) -> None:
        """Write to `total` where each pixel of `box` is read, relative to `origin`."""
        plain = self.field.is_plain and self.maps
        if plain:
            # Always the first lattice: which one carries the identity decides how that is rounded.
            self.maps[0].on(strip, box, total, origin)
        else:
            total[:] = 0.0
        for lattice_map in self.maps[1:] if plain else self.maps:
            if lattice_map.reaches(box):
                extra = np.empty_like(total)
                lattice_map.on(strip, box, extra)
                total += extra
        if not plain:
            xs, ys = np.arange(box.left, box.right), np.arange(box.top, box.bottom)
            factor, _ = self.field.falloff.on_grid(xs, ys)
            total *= factor * fade(np.hypot(total[0], total[1]), self.field.fade_px)
            total[0] += xs - origin[0]
            total[1] += (ys - origin[1])[:, None]


class _LatticeMap:
    """Eq. (1) at every pixel of a run, as small matrix products in single precision."""

    def __init__(self, lattice: Lattice, axes: Sequence[_Axis]) -> None:
        self.lattice, self.axes = lattice, axes

    def reaches(self, box: Box) -> bool:
        """Return False when the displacement on `box` is all zeros, which needn't be added."""
        left, top, right, bottom = self.lattice.reach_px
        return left < box.right and box.left < right and top < box.bottom and box.top < bottom

    def on(self, strip: Box, box: Box, out: Float32, origin: tuple[int, int] | None = None) -> None:
        """Write the displacement on `box`, whole spans of `strip`; with `origin`, the map from it.

        Products have the same shape whatever the box: BLAS may round another shape otherwise.
        """
        along_x, along_y = self.axes
        first_i, last_i = along_x.nodes(strip.left, strip.right)
        first_j, by = along_y.weights(box.top, box.bottom)
        phi = self.lattice.window((first_i, first_j), (len(by), last_i - first_i))
        if origin is not None:
            # Linear precision: nodes that hold their own coordinates reproduce the identity map.
            grid = self.lattice.grid
            phi[..., 0] += grid.nodes_px(first_i, phi.shape[1], 0) - origin[0]
            phi[..., 1] += (grid.nodes_px(first_j, phi.shape[0], 1) - origin[1])[:, None]
        rows = by.T @ np.ascontiguousarray(phi.transpose(2, 0, 1), np.float32)
        for left in range(box.left, box.right, SPAN_PX):
            right = min(left + SPAN_PX, box.right)
            first, bx = along_x.weights(left, right)
            part = rows[:, :, first - first_i : first - first_i + len(bx)]
            _multiply(part, bx, out[:, :, left - box.left : right - box.left])


def _multiply(left: Float32, right: Float32, out: Float32) -> None:
    """Multiply in blocks of rows so small that BLAS keeps them in one thread.

    Otherwise the bits, and with them a pixel, would depend on how many threads BLAS has just then.
    """
    step = max(1, _ONE_BLAS_THREAD // right.size)
    for top in range(0, left.shape[-2], step):
        rows = slice(top, top + step)
        np.matmul(left[:, rows], right, out=out[:, rows])


class _Axis:
    """The cell of every pixel along an axis and its four weights, eq. (2)."""

    def __init__(self, grid: Grid, size_px: int, axis: int) -> None:
        self._cells, s = grid.locate(np.arange(size_px), axis)
        self._values = basis(s).astype(np.float32)
        self._weights: dict[int, tuple[int, Float32]] = {}

    def nodes(self, start_px: int, stop_px: int) -> tuple[int, int]:
        """Return the first node that reaches these pixels, and the one after the last."""
        return int(self._cells[start_px]) - 1, int(self._cells[stop_px - 1]) + ORDER - 1

    def weights(self, start_px: int, stop_px: int) -> tuple[int, Float32]:
        """Return the first node and a matrix of the weights of all, shape (nodes, pixels)."""
        # Runs share their weights; threads may at worst compute them twice.
        known = self._weights.get(start_px)
        if known is None:
            first, end = self.nodes(start_px, stop_px)
            weights = np.zeros((end - first, stop_px - start_px), np.float32)
            places = self._cells[start_px:stop_px] - 1 - first + np.arange(ORDER)[:, None]
            np.put_along_axis(weights, places, self._values[start_px:stop_px].T, 0)
            known = self._weights[start_px] = first, weights
        return known


def _axes(grid: Grid, image: Box) -> tuple[_Axis, _Axis]:
    return _Axis(grid, image.right, 0), _Axis(grid, image.bottom, 1)


def _spread(job: _Job, boxes: Sequence[Box], threads: int) -> None:
    def hand() -> Callable[[Box], None]:
        buffer = np.empty(2 * _CALL_PX, np.float32)
        return lambda box: job.run(box, buffer)

    share_out(boxes, hand, min(threads, 1 + sum(box.area for box in boxes) // _THREAD_PX))
