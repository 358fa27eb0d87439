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
from kogao_core.maps import Float32, LatticeMap, Runs
from kogao_core.settings import Interpolation
from kogao_core.threads import default_threads, share_out

BLOCK_WIDTH_PX: Final = 16  # what is worked on or left alone
BLOCK_HEIGHT_PX: Final = 128
SMALL_BLOCK_HEIGHT_PX: Final = 64  # of images up to this many pixels:
_SMALL_IMAGE_PX: Final = 2_000_000
# Pixels resampled by one call at most: OpenCV spreads calls of more than 98,000 over threads of its
# own, which compete with ours.
_CALL_PX: Final = 2**16
_THREAD_PX: Final = 400_000  # waking another thread costs about as much as warping this many
_MARGIN_PX: Final = 256  # source pixels kept round a strip; doubled while a displacement is longer
_KERNEL_REACH_PX: Final = 8
_DTYPES: Final = (np.uint8, np.uint16, np.float32)
_MAX_CHANNELS: Final = 4


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
            hit |= (over_rows @ cells.active.astype(np.float32) @ over_columns.T) > 0.0
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


def _overlaps(
    edges_px: npt.NDArray[np.int64], blocks: int, size_px: int, end_px: int
) -> npt.NDArray[np.float32]:
    """Return 1 where cells (columns) share pixels with blocks (rows) along one axis, else 0."""
    start = np.arange(blocks)[:, None] * size_px
    end = np.minimum(start + size_px, end_px)
    low, high = edges_px[:-1], edges_px[1:]
    return ((low < end) & (high > start) & (low < high)).astype(np.float32)


class _Job:
    """One warp: everything its runs of blocks share."""

    def __init__(self, canvas: Canvas, field: Field, flag: int, before: _Job | None) -> None:
        self.source, self.result, self.image = canvas.source, canvas.pixels, canvas.image
        self.strip_px, self.field, self.flag = canvas.strip_px, field, flag
        self.block_px = _CALL_PX // self.strip_px
        known = {m.lattice.grid: m for m in before.maps} if before is not None else {}
        # Always the first lattice: which one carries the identity decides how that is rounded.
        self.maps: list[LatticeMap] = [
            LatticeMap(a, self.image, self.block_px, not k and field.is_plain, known.get(a.grid))
            for k, a in enumerate(field.lattices)
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

    def run(self, numbered: tuple[int, Box], total: Float32) -> None:
        """Resample a run of blocks; `total` has room for the map of a strip."""
        number, box = numbered
        view = self._view(box)
        columns = slice(box.left % self.strip_px, box.left % self.strip_px + box.width)
        self._map(number, box, view, total)
        x, y = total[:, : box.height, columns]
        cv2.remap(
            self.source[view.slices],
            x,
            y,
            self.flag,
            dst=self.result[box.slices],
            borderMode=cv2.BORDER_REPLICATE,
        )

    def prepare(self, boxes: Sequence[Box]) -> None:
        """Gather what the maps of these runs are made of."""
        views = [self._view(box) for box in boxes]
        origins = np.array([(view.left, view.top) for view in views], np.int64).reshape(-1, 2)
        for lattice_map in self.maps:
            lattice_map.prepare(Runs(boxes, origins, self.block_px))

    def _view(self, box: Box) -> Box:
        """Return the part of the source that a run may read, and from whose corner it is mapped."""
        left = box.left // self.strip_px * self.strip_px
        strip = Box(left, box.top, left + self.strip_px, box.bottom).clipped(self.image)
        return strip.grown(self.margin_px).clipped(self.image)

    def _map(self, number: int, box: Box, view: Box, total: Float32) -> None:
        """Write to `total` where each pixel of a run is read in `view`."""
        plain = self.field.is_plain and self.maps
        if not plain:
            total[:] = 0.0
        for k, lattice_map in enumerate(self.maps):
            lattice_map.on(number, box, total, add=bool(k or not plain))
        if not plain:
            left = box.left % self.strip_px
            part = total[:, : box.height, left : left + box.width]
            xs, ys = np.arange(box.left, box.right), np.arange(box.top, box.bottom)
            factor, _ = self.field.falloff.on_grid(xs, ys)
            part *= factor * fade(np.hypot(part[0], part[1]), self.field.fade_px)
            part[0] += xs - view.left
            part[1] += (ys - view.top)[:, None]


def _spread(job: _Job, boxes: Sequence[Box], threads: int) -> None:
    job.prepare(boxes)

    def hand() -> Callable[[tuple[int, Box]], None]:
        buffer = np.zeros((2, job.block_px, job.strip_px), np.float32)
        return lambda numbered: job.run(numbered, buffer)

    threads = min(threads, 1 + sum(box.area for box in boxes) // _THREAD_PX)
    share_out(enumerate(boxes), hand, threads)
