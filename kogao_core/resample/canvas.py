"""Section 4: backward resampling into a result buffer, in fixed blocks.

The bytes of a pixel depend only on the source, the control points nearby and the fixed position of
its block. A partial update therefore equals a full update bit for bit. Reduced copies and pictures
of another size are also resampled only once.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from math import ceil
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, Image, check_image
from kogao_core.base.threads import default_threads, parallel_for
from kogao_core.field.field import Field
from kogao_core.paper.domain import Cells, Domain, Mask
from kogao_core.recipe.settings import Interpolation
from kogao_core.resample.blocks import (
    CALL_PX,
    Job,
    block_height_px,
    channels_at,
    cut,
    resample,
    settle,
    spread,
    write_channels,
)

FLAGS: Final[dict[Interpolation, int]] = {
    "bilinear": cv2.INTER_LINEAR,
    "cubic": cv2.INTER_CUBIC,
    "lanczos4": cv2.INTER_LANCZOS4,
}
BLOCK_WIDTH_PX: Final = 16  # width of the blocks that are resampled or skipped
_STRIP_ROWS: Final = 256  # rows per step for a picture of another size, to limit memory
_TILE_PX: Final = 512  # side of a tile in the photo: the tile and its maps fit into the CPU cache


class Canvas:
    """A result buffer for one source. Blocks that no longer move get their source pixels back.

    If `warp` raises an exception, the pixels are partly updated; the next call repairs them.
    """

    def __init__(self, source: Image) -> None:
        check_image(source)
        self.source = source
        self.image = Box.of(source)
        self.pixels = source.copy()
        self._block_px = block_height_px(self.image)
        shape = -(-self.image.height // self._block_px), -(-self.image.width // BLOCK_WIDTH_PX)
        self._warped: Mask = np.zeros(shape, bool)
        self._job: Job | None = None

    def warp(
        self, field: Field, domain: Domain, interpolation: Interpolation, threads: int | None = None
    ) -> list[Box]:
        """Resample the blocks of `domain` from the source. Return the boxes that may differ."""
        everywhere = domain.name == "image"
        active = np.ones_like(self._warped) if everywhere else self._touched(domain.cells)
        before = self._job
        job = Job(self.source, self.pixels, field, FLAGS[interpolation])
        todo = active
        if before is not None and job.terms == before.terms:
            lattices = zip(before.field.lattices, field.lattices, strict=True)
            changes = [now.minus(was) for was, now in lattices]
            todo = active & ~self._warped
            todo |= active & self._touched(Cells(change, change.reached) for change in changes)
        given_back, redone = self._runs(self._warped & ~active), self._runs(todo)
        # If an exception follows, the next call resamples all these blocks again.
        self._warped, self._job = self._warped | active, None
        for box in given_back:
            self.pixels[box.slices] = self.source[box.slices]
        spread(job, redone, threads or default_threads())
        self._warped, self._job = active, job
        return redone + given_back

    def _touched(self, regions: Iterable[Cells]) -> Mask:
        """Return the blocks that share a pixel with an active cell."""
        rows, columns = self._warped.shape
        hit = np.zeros_like(self._warped)
        for cells in regions:
            top, bottom = _overlapped(cells.edges_px(1), rows, self._block_px, self.image.height)
            left, right = _overlapped(cells.edges_px(0), columns, BLOCK_WIDTH_PX, self.image.width)
            # Sums over all cells above and to the left.
            sums = np.pad(cells.active.astype(np.int64), ((1, 0), (1, 0))).cumsum(0).cumsum(1)
            across = sums[bottom] - sums[top]
            hit |= across[:, right] > across[:, left]
        return hit

    def _runs(self, blocks: Mask) -> list[Box]:
        """Return the boxes of adjacent blocks in a row, split at the ends of strips."""
        strip = CALL_PX // self._block_px // BLOCK_WIDTH_PX
        boxes = []
        for row in np.flatnonzero(blocks.any(axis=1)).tolist():
            top = row * self._block_px
            for first in range(0, blocks.shape[1], strip):
                part = np.pad(blocks[row, first : first + strip].astype(np.int8), 1)
                edges = BLOCK_WIDTH_PX * (first + np.flatnonzero(np.diff(part))).reshape(-1, 2)
                for left, right in edges.tolist():
                    box = Box(left, top, right, top + self._block_px)
                    boxes.append(box.clipped(self.image))
        return boxes


def warp_alike(picture: Image, field: Field, domain: Domain, kind: Interpolation) -> Image:
    """Warp a picture of another size, such as a gain map, like the domain's image.

    The field is evaluated at the pixels of the picture, so each pixel is resampled once.
    """
    check_image(picture)
    size, bounds = Box.of(picture), domain.bounds
    if size == domain.image:  # a canvas takes a third of the time
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
        at = field.on_grid(xs, ys) / scale[:, None, None]
        at += np.broadcast_arrays(columns, rows[:, None])
        out = warped[rows[0] : rows[-1] + 1, left : columns[-1] + 1]
        settle(picture, FLAGS[kind], out, resample(picture, at, FLAGS[kind], out))
    return warped


def _overlapped(
    edges_px: npt.NDArray[np.int64], blocks: int, size_px: int, end_px: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the first cell, and the one after the last, that each block overlaps along an axis."""
    start = np.arange(blocks) * size_px
    end = np.minimum(start + size_px, end_px)
    first = np.searchsorted(edges_px, start, "right") - 1
    after = np.searchsorted(edges_px, end, "left")
    return first.clip(0, len(edges_px) - 1), after.clip(0, len(edges_px) - 1)


def size_of(image: Box, longest_px: int) -> tuple[int, int]:
    """Return (width, height) of an image reduced to `longest_px`; never enlarged. 0: no limit."""
    share = min(1.0, longest_px / max(image.width, image.height)) if longest_px else 1.0
    return max(1, round(image.width * share)), max(1, round(image.height * share))


def reduced(
    source: Image, field: Field, moving: Box, size: tuple[int, int], flag: int, threads: int | None
) -> Image:
    """Return the warped photo reduced to `size` (width, height), in one resampling.

    Each pixel is the mean of evenly spaced samples, one per photo pixel along each axis. Each
    sample is read at its displaced position, without rounding in between. `moving`: box with all
    non-zero displacements. `flag`: OpenCV interpolation.
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
        size = tile.width, tile.height
        part, _, there = cut(source, there)
        means = [
            np.asarray(cv2.resize(channel, size, interpolation=cv2.INTER_AREA))
            for channel in channels_at(part, there, flag)
        ]
        write_channels(means, result[tile.slices])

    parallel_for(tiles, lambda: draw, threads or default_threads())
    return result


def _places(first: int, end: int, fine: int, scale: float) -> Array:
    """Return the centres of the samples of pixels `first` to `end` in the photo, px."""
    parts = np.arange(first * fine, end * fine) + 0.5
    return np.asarray(parts / fine * scale - 0.5)
