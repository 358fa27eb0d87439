"""Backward resampling into a result, in place and in fixed blocks.

A pixel's bytes depend only on the source, the control points near it and its block's fixed place,
never on which other blocks are worked on: a partial update equals a full one bit for bit. Pictures
of another size, larger ones or a reduced copy, are resampled once, too.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from math import ceil
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.threads import default_threads, share_out
from kogao_core.recipe.settings import Interpolation
from kogao_core.warp.domain import Cells, Domain, Mask, cells_beyond
from kogao_core.warp.field import Field
from kogao_core.warp.resample import CALL_PX, KERNEL_REACH_PX, Job, block_height_px, spread

FLAGS: Final[dict[Interpolation, int]] = {
    "bilinear": cv2.INTER_LINEAR,
    "cubic": cv2.INTER_CUBIC,
    "lanczos4": cv2.INTER_LANCZOS4,
}
BLOCK_WIDTH_PX: Final = 16  # what is worked on or left alone
# Where the displacement changes by less, few pixels are read elsewhere, and only those are
# resampled. To find them costs as much as to resample all of them bilinearly.
_FAINT_PX: Final = {cv2.INTER_LINEAR: 0.0, cv2.INTER_CUBIC: 2.0**-8, cv2.INTER_LANCZOS4: 2.0**-7}
_STRIP_ROWS: Final = 256  # of a smaller picture: bounds the memory
_COPY_PX: Final = 400_000  # copied at a time: enough to be worth waking another thread
_DTYPES: Final = (np.uint8, np.uint16, np.float32)
_MAX_CHANNELS: Final = 4
_TILE_PX: Final = 512  # of the photo, about: a tile and its maps fit into the processor's cache


class Canvas:
    """A result buffer over one source; blocks no longer warped get their source back.

    After an exception in the middle of `warp` the pixels hold a part of it; the next call puts all
    of them right.
    """

    def __init__(self, source: Image) -> None:
        _check(source)
        self.source = source
        self.image = Box.of(source)
        self.pixels = _copied(source)
        self._block_px = block_height_px(self.image)
        shape = -(-self.image.height // self._block_px), -(-self.image.width // BLOCK_WIDTH_PX)
        self._warped: Mask = np.zeros(shape, bool)
        self._job: Job | None = None

    def warp(
        self, field: Field, domain: Domain, interpolation: Interpolation, threads: int | None = None
    ) -> list[Box]:
        """Resample the blocks of `domain` from the source; return the boxes that may differ now."""
        active = self._blocks(domain)
        before, flag = self._job, FLAGS[interpolation]
        job = Job(self.source, self.pixels, field, flag, before)
        todo, faint, stale = active, np.zeros_like(active), self._warped & ~active
        if before is not None and job.resembles(before):
            known, lattices = active & self._warped, (before.field.lattices, field.lattices)
            changes = [now.minus(was) for was, now in zip(*lattices, strict=True)]
            touched = known & self._touched(Cells(change, change.reached) for change in changes)
            if _FAINT_PX[flag]:
                strong = (cells_beyond(one, self.image, _FAINT_PX[flag]) for one in changes)
                faint = touched & ~self._touched(strong)
            todo = active & ~known | touched & ~faint
        given_back, redone, checked = (self._runs(blocks) for blocks in (stale, todo, faint))
        # Whatever is raised from here on, the next call does all these blocks again.
        self._warped, self._job = self._warped | active, None
        for box in given_back:
            self.pixels[box.slices] = self.source[box.slices]
        spread(job, redone, threads or default_threads(), before, checked)
        self._warped, self._job = active, job
        return redone + checked + given_back

    def _blocks(self, domain: Domain) -> Mask:
        if domain.name == "image":
            return np.ones_like(self._warped)
        return self._touched(domain.cells)

    def _touched(self, regions: Iterable[Cells]) -> Mask:
        """Return the blocks that share a pixel with an active cell."""
        rows, columns = self._warped.shape
        hit = np.zeros_like(self._warped)
        for cells in regions:
            down, over_rows = _overlaps(cells.edges_px(1), rows, self._block_px, self.image.height)
            along, over_columns = _overlaps(
                cells.edges_px(0), columns, BLOCK_WIDTH_PX, self.image.width
            )
            hit[down, along] |= (over_rows @ cells.active.astype(np.float32) @ over_columns.T) > 0.0
        return hit

    def _runs(self, blocks: Mask) -> list[Box]:
        """Return the boxes of neighbouring blocks in a row, cut where strips end."""
        if not blocks.any():
            return []
        edged = np.zeros((blocks.shape[0], blocks.shape[1] + 2), np.int8)
        edged[:, 1:-1] = blocks
        edges = np.diff(edged)
        row, first = np.nonzero(edges > 0)
        left = first * BLOCK_WIDTH_PX
        right = np.minimum(np.nonzero(edges < 0)[1] * BLOCK_WIDTH_PX, self.image.right)
        strip_px = CALL_PX // self._block_px
        strip = left // strip_px
        count = -(-right // strip_px) - strip
        run = np.repeat(np.arange(len(row)), count)
        strip = np.arange(len(run)) + (strip - np.cumsum(count) + count)[run]
        left = np.maximum(left[run], strip * strip_px)
        right = np.minimum(right[run], (strip + 1) * strip_px)
        top = row[run] * self._block_px
        bottom = np.minimum(top + self._block_px, self.image.bottom)
        return [Box(*edge) for edge in np.stack([left, top, right, bottom], axis=1).tolist()]


def warp_alike(picture: Image, field: Field, domain: Domain, kind: Interpolation) -> Image:
    """Return a picture of all that the domain's image shows, of any size, warped as that one.

    The field is asked where the picture's own pixels lie, so they are resampled once.
    """
    _check(picture)
    size, bounds = Box.of(picture), domain.bounds
    if size == domain.image:  # in a third of the time
        canvas = Canvas(picture)
        canvas.warp(field, domain, kind)
        return canvas.pixels
    scale = np.array([domain.image.width / size.width, domain.image.height / size.height])
    left, top = (np.array([bounds.left, bounds.top]) // scale).astype(int)
    right, bottom = np.ceil(np.array([bounds.right, bounds.bottom]) / scale).astype(int)
    warped = picture.copy()
    columns = np.arange(left, min(right, size.right))
    for start in range(top, min(bottom, size.bottom), _STRIP_ROWS):
        rows = np.arange(start, min(start + _STRIP_ROWS, bottom, size.bottom))
        xs, ys = ((at + 0.5) * by - 0.5 for at, by in zip((columns, rows), scale, strict=True))
        along_x, along_y = field.on_grid(xs, ys) / scale[:, None, None]
        warped[rows[0] : rows[-1] + 1, left : columns[-1] + 1] = cv2.remap(
            picture,
            (along_x + columns).astype(np.float32),
            (along_y + rows[:, None]).astype(np.float32),
            FLAGS[kind],
            borderMode=cv2.BORDER_REPLICATE,
        )
    return warped


def _copied(source: Image) -> Image:
    """Return a copy in the order of its rows; fresh memory is what takes time, so threads share."""
    copy = np.empty(source.shape, source.dtype)
    rows = max(1, _COPY_PX // max(1, source.shape[1]))

    def fill(top: int) -> None:
        copy[top : top + rows] = source[top : top + rows]

    share_out(range(0, len(source), rows), lambda: fill, default_threads())
    return copy


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
) -> tuple[slice, npt.NDArray[np.float32]]:
    """Return the blocks that cells reach along one axis, and 1 where the two share pixels, else 0.

    Blocks are rows, cells columns.
    """
    first = min(max(int(edges_px[0]) // size_px, 0), blocks)
    reached = slice(first, max(first, min(-(-int(edges_px[-1]) // size_px), blocks)))
    start = np.arange(reached.start, reached.stop)[:, None] * size_px
    end = np.minimum(start + size_px, end_px)
    low, high = edges_px[:-1], edges_px[1:]
    return reached, ((low < end) & (high > start) & (low < high)).astype(np.float32)


def size_of(image: Box, longest_px: int) -> tuple[int, int]:
    """Return width and height of a picture reduced to a longer side; its own if that is enough."""
    share = min(1.0, longest_px / max(image.width, image.height)) if longest_px else 1.0
    return max(1, round(image.width * share)), max(1, round(image.height * share))


def reduced(
    source: Image, field: Field, moving: Box, size: tuple[int, int], flag: int, threads: int | None
) -> Image:
    """Return the warped photo as a smaller picture, of a size (width, height), in one resampling.

    Each pixel is the mean of places spread evenly over it, as many as there are px of the photo,
    each read where the field says. Nothing is rounded to pixels in between.
    `moving` is where the field moves anything; `flag` is OpenCV's interpolation.
    """
    image, (width, height) = Box.of(source), size
    result = np.empty((height, width, *source.shape[2:]), source.dtype)
    fine = ceil(max(image.width / width, image.height / height))
    step = max(1, _TILE_PX // fine)
    tiles = [
        Box(left, top, min(left + step, width), min(top + step, height))
        for top, left in product(range(0, height, step), range(0, width, step))
    ]

    def draw(tile: Box) -> None:
        xs = _places(tile.left, tile.right, fine, image.width / width)
        ys = _places(tile.top, tile.bottom, fine, image.height / height)
        reach = Box(int(xs[0]), int(ys[0]), int(xs[-1]) + 1, int(ys[-1]) + 1)
        there = np.array(np.broadcast_arrays(xs, ys[:, None]))
        if reach.clipped(moving).area:
            there += field.on_grid(xs, ys)
        low = np.clip(there.min(axis=(1, 2)) - KERNEL_REACH_PX, 0, None).astype(int)
        high = (there.max(axis=(1, 2)) + KERNEL_REACH_PX + 1).astype(int)
        # At the photo's edge at least one pixel is left to be repeated.
        low = np.minimum(low, (image.width - 1, image.height - 1))
        seen = source[low[1] : max(high[1], 1), low[0] : max(high[0], 1)].astype(np.float32)
        at = (there - low[:, None, None]).astype(np.float32)
        read = cv2.remap(seen, at[0], at[1], flag, borderMode=cv2.BORDER_REPLICATE)
        mean = cv2.resize(read, (tile.width, tile.height), interpolation=cv2.INTER_AREA)
        if source.dtype != np.float32:
            mean = np.clip(np.rint(mean), 0, np.iinfo(source.dtype).max)
        result[tile.slices] = mean.reshape(result[tile.slices].shape)

    share_out(tiles, lambda: draw, threads or default_threads())
    return result


def _places(first: int, end: int, fine: int, scale: float) -> Array:
    """Return where the parts of some pixels lie in the photo, px; their centres."""
    parts = np.arange(first * fine, end * fine) + 0.5
    return np.asarray(parts / fine * scale - 0.5)
