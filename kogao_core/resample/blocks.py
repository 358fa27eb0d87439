"""Section 4: compute the source position of each pixel by eq. (1), and resample runs of blocks.

Positions are computed by matrix products that are exact: weights and control points have so few
bits that no sum rounds. So the bytes of a pixel depend neither on its neighbours nor on the
processor, whose BLAS adds in an order of its own. Positions are relative to the corner of a small
view of the source, where single precision is exact to 1/8192 px.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.threads import parallel_for
from kogao_core.field.field import Field, fade
from kogao_core.field.protection import axes, share
from kogao_core.paper.basis import ORDER, basis
from kogao_core.paper.lattice import Grid, Lattice

Float32 = npt.NDArray[np.float32]
Integers = npt.NDArray[np.int64]

# Candidate widths of one matrix product, px. About four cells wide, the product has 8 control
# points per axis. Each width divides a strip.
SPANS_PX: Final = (512, 256, 128, 64)
# Bits of a weight and of a control point in a product; with both, a double (53 bits) is exact.
_WEIGHT_BITS: Final = 24
_POINT_BITS: Final = 29
# Most pixels per call of cv2.remap: above 98,000, OpenCV starts threads that compete with ours.
CALL_PX: Final = 2**16
BLOCK_HEIGHT_PX: Final = 128  # height of the blocks that are resampled or skipped
SMALL_BLOCK_HEIGHT_PX: Final = 64  # block height in small images
_SMALL_IMAGE_PX: Final = 2_000_000  # largest area of a small image
_THREAD_PX: Final = 400_000  # pixels per thread: starting a thread costs about as much
_MARGIN_PX: Final = 256  # source pixels around a strip; doubled until no displacement is longer
KERNEL_REACH_PX: Final = 8  # source pixels around a block, twice the reach of Lanczos 4
# Pixels that a kernel adds along each axis, and the most error of their sum in single precision.
# The products are together at most 420 and 1,020 levels.
_SUMS: Final = {cv2.INTER_CUBIC: (4, 2.0**-11), cv2.INTER_LANCZOS4: (8, 2.0**-9)}
_COLUMNS: Final = 64  # of patches round uncertain pixels, in one picture
_TOGETHER: Final = 2**16  # uncertain pixels
_STEPS: Final = 32  # positions per px of cv2.remap
_NOWHERE: Final = np.zeros((4, 0), np.int64)
_DEPTHS: Final = {"uint8": cv2.CV_8U, "uint16": cv2.CV_16U, "float32": cv2.CV_32F}


class LatticeMap:
    """The displacement of one lattice on runs of blocks."""

    def __init__(
        self, lattice: Lattice, image: Box, block_px: int, farthest_px: float, everywhere: bool
    ) -> None:
        """Prepare weights; `farthest_px`: of a position from the corner of its view."""
        self.lattice, self._everywhere = lattice, everywhere
        grid = lattice.grid
        farthest_px += 2 * ORDER * grid.spacing_px
        self._step_px = 2.0 ** (np.ceil(np.log2(farthest_px)) - _POINT_BITS)
        span_px = next((n for n in SPANS_PX if n <= 4 * grid.spacing_px), SPANS_PX[-1])
        left, top, right, bottom = np.clip(lattice.reach_px, 0, (image.right, image.bottom) * 2)
        ends = (
            ((0, image.right), (0, image.bottom)) if everywhere else ((left, right), (top, bottom))
        )
        self.axes = tuple(
            _Axis(grid, axis, size, int(low // size), int(-(-high // size)))
            for axis, size, (low, high) in zip((0, 1), (span_px, block_px), ends, strict=True)
        )

    def prepare(self, edges: Integers, views: Integers) -> None:
        """Gather the control points that the spans of each run need.

        `edges` int (N, 4): left, top, right, bottom of each run, one block high and within one
        strip. `views` int (N, 4): the part of the source that the run may read.
        """
        along_x, along_y = self.axes
        left, top, right, _ = edges.T
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
        self._phi = self._at_nodes(*nodes).swapaxes(0, 1)
        for axis in (0, 1) if self._everywhere else ():
            # Linear precision: control points equal to their coordinates give the identity.
            place = self.lattice.grid.node_px(nodes[axis], axis) - views[run, axis, None]
            self._phi[:, axis] += place[:, :, None] if axis else place[:, None, :]
        self._phi = self._rounded(self._phi)

    def _rounded(self, px: Array) -> Array:
        """Return control points with so few bits that a product with weights is exact."""
        return np.asarray(np.rint(px / self._step_px) * self._step_px)

    def _at_nodes(self, i: Integers, j: Integers) -> Array:
        """Return the control points of columns i (N, I) and rows j (N, J), (2, N, J, I)."""
        rows, columns = self.lattice.shape
        stored = np.zeros((2, rows + 2, columns + 2))
        stored[:, 1:-1, 1:-1] = self.lattice.components
        i = np.minimum(np.maximum(i - (self.lattice.first[0] - 1), 0), columns + 1)
        j = np.minimum(np.maximum(j - (self.lattice.first[1] - 1), 0), rows + 1)
        at = j[:, :, None] * (columns + 2) + i[:, None, :]
        return stored.reshape(2, -1).take(at, axis=1)

    def on(self, number: int, run: Box, out: Float32, spare: Array, add: bool) -> None:
        """Write the displacement (or the map) of a run to `out`, or add it to `out`.

        `out` float32 (2, block, strip); `spare`: room for doubles, of this shape.
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
        # One matrix product per span and component.
        rows = self._rounded(by.T @ self._phi[begin:end])
        exact = spare[:, :, : spans * size]
        view = exact.reshape(2, -1, spans, size).transpose(2, 0, 1, 3)
        np.matmul(rows, bx[:, None], out=view)
        if add:
            part += exact
        else:
            part[...] = exact


class _Axis:
    """Weights of eq. (2) of the control points that reach pieces of an axis."""

    def __init__(self, grid: Grid, axis: int, size_px: int, start: int, end: int) -> None:
        self.size_px, self.start, self.end = size_px, start, end
        coords = np.arange(start * size_px, end * size_px).reshape(-1, size_px)
        cell, s = grid.locate(coords, axis)
        self._first = cell[:, 0] - 1
        # The same number of nodes for every piece.
        count = int((size_px - 1) / grid.spacing_px) + 1 + ORDER
        weights = np.zeros((*cell.shape, count))
        node = (cell - cell[:, :1])[..., None] + np.arange(ORDER)
        exact = np.rint(basis(s) * 2.0**_WEIGHT_BITS) / 2.0**_WEIGHT_BITS
        exact[..., 1] += 1.0 - exact.sum(axis=-1)  # their sum stays 1
        np.put_along_axis(weights, node, exact, axis=2)
        self.weights = np.ascontiguousarray(weights.swapaxes(1, 2))

    def nodes(self, pieces: Integers) -> Integers:
        """Return the nodes that reach each piece, shape (N, nodes)."""
        return np.asarray(
            self._first[pieces - self.start][:, None] + np.arange(self.weights.shape[1])
        )


def block_height_px(image: Box) -> int:
    """Return the block height of an image; each strip of `CALL_PX` has the same height."""
    return SMALL_BLOCK_HEIGHT_PX if image.area <= _SMALL_IMAGE_PX else BLOCK_HEIGHT_PX


class Job:
    """One warp: the data shared by all its runs of blocks."""

    def __init__(self, source: Image, result: Image, field: Field, flag: int) -> None:
        self.source, self.result, self.image = source, result, Box.of(source)
        self.field, self.flag = field, flag
        self.block_px = block_height_px(self.image)
        self.strip_px = CALL_PX // self.block_px
        self.unsure = [_NOWHERE]  # pixels to settle
        self.margin_px = _MARGIN_PX
        longest = sum(float(lattice.magnitude_px.max()) for lattice in field.lattices)
        while self.margin_px < longest + KERNEL_REACH_PX:
            self.margin_px *= 2
        farthest_px = 2 * self.margin_px + self.strip_px
        # The first lattice always includes the identity: the choice decides the rounding.
        self.maps = [
            LatticeMap(a, self.image, self.block_px, farthest_px, not k and field.is_plain)
            for k, a in enumerate(field.lattices)
        ]

    @property
    def terms(self) -> tuple[object, ...]:
        """With equal terms, equal control points give equal bytes."""
        grids = tuple(lattice.grid for lattice in self.field.lattices)
        field = self.field
        return self.flag, self.margin_px, field.fade_px, field.protection.strokes, grids

    def prepare(self, boxes: Sequence[Box]) -> int:
        """Gather the control points of these runs. Return their number of pixels."""
        edges = np.array([(b.left, b.top, b.right, b.bottom) for b in boxes], np.int64)
        edges = edges.reshape(-1, 4)
        views = self._views(edges)
        self._seen = [Box(*view) for view in views.tolist()]
        for lattice_map in self.maps:
            lattice_map.prepare(edges, views)
        return int((edges[:, 2:] - edges[:, :2]).prod(axis=1).sum())

    def _views(self, edges: Integers) -> Integers:
        """Return the part of the source that each run may read; maps are relative to its corner."""
        left, top, _, bottom = edges.T
        strip = left // self.strip_px * self.strip_px
        low = np.stack([strip, top], axis=1) - self.margin_px
        end = self.image.right, self.image.bottom
        high = np.minimum(np.stack([strip + self.strip_px, bottom], axis=1), end) + self.margin_px
        return np.hstack([np.maximum(low, 0), np.minimum(high, end)])

    def run(self, number: int, box: Box, total: Float32, spare: Array) -> None:
        """Resample a run of blocks. `total`, `spare`: (2, `block_px`, `strip_px`)."""
        view, at = self.source[self._seen[number].slices], self._mapped(number, box, total, spare)
        out = self.result[box.slices]
        if self.flag == cv2.INTER_LINEAR:
            x, y = at
            cv2.remap(view, x, y, self.flag, dst=out, borderMode=cv2.BORDER_REPLICATE)
        else:
            seen = self._seen[number]
            corner = box.left, box.top, _STEPS * seen.left, _STEPS * seen.top
            self.unsure.append(resample(view, at, self.flag, out) + np.array([corner]).T)

    def _mapped(self, number: int, box: Box, total: Float32, spare: Array) -> Float32:
        """Write the source positions of a run, relative to its view, to `total`; return them."""
        plain, left = self.field.is_plain and self.maps, box.left % self.strip_px
        part = total[:, : box.height, left : left + box.width]
        if not plain:
            total[:] = 0.0
        for k, lattice_map in enumerate(self.maps):
            lattice_map.on(number, box, total, spare, add=bool(k or not plain))
        if not plain:
            xs, ys = np.arange(box.left, box.right), np.arange(box.top, box.bottom)
            # Not np.hypot, which the C library rounds in its own way.
            part *= fade(np.sqrt(np.square(part).sum(axis=0)), self.field.fade_px)
            part *= share(self.field.protection.strokes, *axes(xs, ys), part)
            part[0] += xs - self._seen[number].left
            part[1] += (ys - self._seen[number].top)[:, None]
        return part


def channels_at(
    picture: Image, at: Array | Float32, flag: int, kind: npt.DTypeLike = np.float64
) -> list[npt.NDArray[Any]]:
    """Return each channel of a picture at the positions `at` (2, h, w), px, by OpenCV's `flag`.

    OpenCV applies cubic kernels to channels of floating point three times as fast as to coloured
    bytes, and rounds no weight. Its weights have 24 bits: in doubles, sums over pixels of up to 16
    bits are exact, on every processor.
    """
    x, y = np.asarray(at, np.float32)
    return [
        np.asarray(cv2.remap(np.asarray(one, kind), x, y, flag, borderMode=cv2.BORDER_REPLICATE))
        for one in cv2.split(picture)
    ]


def resample(picture: Image, at: Array | Float32, flag: int, out: Image) -> Integers:
    """Write the pixels of a picture at the positions `at` (2, h, w), px, to `out`.

    Bytes by cubic kernels come from sums in single precision, which are faster. Result int (4, N):
    where their error can decide between two bytes, for `settle`: x and y in `out`, and the
    position in 1/32 px.
    """
    part, corner, at = cut(picture, at)
    if out.dtype != np.uint8 or flag not in _SUMS:
        write_channels(channels_at(part, at, flag), out)
        return _NOWHERE
    rough, upper = channels_at(part, at, flag, np.float32), np.empty_like(out)
    write_channels(rough, out, -_SUMS[flag][1])
    write_channels(rough, upper, _SUMS[flag][1])
    y, x = np.unravel_index(np.flatnonzero(out != upper), out.shape)[:2]
    place = np.rint(at[:, y, x] * _STEPS).astype(np.int64)
    return np.array([x, y, *(place + _STEPS * corner[:, None])])


def settle(picture: Image, flag: int, out: Image, unsure: Integers) -> None:
    """Write exact sums to the pixels that `resample` returned."""
    for first in range(0, unsure.shape[1], _TOGETHER):
        some = unsure[:, first : first + _TOGETHER]
        # As a matrix: OpenCV takes pictures of less than 32,767 columns.
        count, taps = -(-some.shape[1] // _COLUMNS), _SUMS[flag][0]
        x, y, *place = (np.resize(one, (count, _COLUMNS)) for one in some)
        # A patch of the picture for each position: to convert all of it takes longer.
        column, row = (
            (one[..., None] // _STEPS + np.arange(1 - taps // 2, 1 + taps // 2)).clip(0, size - 1)
            for one, size in zip(place, picture.shape[1::-1], strict=True)
        )
        patches = picture[row[..., None], column[..., None, :]].swapaxes(1, 2)
        patches = patches.reshape(taps * count, taps * _COLUMNS, *picture.shape[2:])
        corner = np.meshgrid(taps * np.arange(_COLUMNS), taps * np.arange(count))
        at = np.array(corner) + taps // 2 - 1 + np.array(place) % _STEPS / _STEPS
        exact = np.empty((count, _COLUMNS, *out.shape[2:]), out.dtype)
        write_channels(channels_at(patches, at, flag), exact)
        out[y, x] = exact


def cut(picture: Image, at: Array | Float32) -> tuple[Image, npt.NDArray[np.int64], Float32]:
    """Return the part of a picture that positions (2, h, w) read, its corner, and these in its px.

    `at`: px of the picture. The corner is x and y, px.
    """
    size = np.array(picture.shape[1::-1])
    # At least one pixel at the edge of the picture remains to be replicated.
    low = np.clip(at.min(axis=(1, 2)) - KERNEL_REACH_PX, 0, size - 1).astype(np.int64)
    high = np.clip(at.max(axis=(1, 2)) + KERNEL_REACH_PX + 1, 1, size).astype(int)
    part = np.ascontiguousarray(picture[low[1] : high[1], low[0] : high[0]])
    return part, low, np.asarray(at - low[:, None, None].astype(at.dtype), np.float32)


def write_channels(channels: Sequence[npt.NDArray[Any]], out: Image, more: float = 0.0) -> None:
    """Write channels, each plus `more`, to pixels, rounded to their depth."""
    depth = _DEPTHS[out.dtype.name]
    whole = [cv2.addWeighted(one, 1.0, one, 0.0, more, dtype=depth) for one in channels]
    out[...] = cv2.merge(whole).reshape(out.shape)


def spread(job: Job, boxes: Sequence[Box], threads: int) -> None:
    """Resample the runs of a warp in `threads` threads."""
    area = job.prepare(boxes)

    def hand() -> Callable[[tuple[int, Box]], None]:
        shape = 2, job.block_px, job.strip_px
        buffers = np.zeros(shape, np.float32), np.zeros(shape)
        return lambda numbered: job.run(*numbered, *buffers)

    parallel_for(enumerate(boxes), hand, min(threads, 1 + area // _THREAD_PX))
    settle(job.source, job.flag, job.result, np.hstack(job.unsure))
