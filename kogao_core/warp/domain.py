"""Section 4: the reduced warp domain, by control points (4.1) and by threshold (4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Final, assert_never

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe
from kogao_core.recipe.settings import DomainName
from kogao_core.warp.field import Field
from kogao_core.warp.lattice import Lattice, groups, meet

Mask = npt.NDArray[np.bool_]
_LARGEST_CELL_PX: Final = 96  # refine larger cells: the bounds of smaller cells are tighter
_STRIP_PX: Final = 256  # rows evaluated per step, to limit the memory of a mask
_TILE_PX: Final = 16  # side of the tiles that are counted by bounds before by pixel
_LARGEST_COUNTED_PX: Final = 48  # refine larger cells before pixels are counted
_AT_ONCE: Final = 2048  # tiles evaluated per step, to limit memory


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Active cells of one lattice, bool (J + 3, I + 3).

    Cell i contains the pixel centres in ``[origin + h i, origin + h (i + 1))``.
    """

    lattice: Lattice
    active: Mask

    def edges_px(self, axis: int) -> npt.NDArray[np.int64]:
        """Return the first pixel of each cell along `axis` (0 is x), and the end: (n + 1,)."""
        count = self.active.shape[1 - axis] + 1
        edges = self.lattice.grid.nodes_px(self.lattice.first_cell[axis], count, axis)
        return np.ceil(edges).astype(np.int64)

    def at(self, xs: npt.NDArray[np.int64], ys: npt.NDArray[np.int64]) -> Mask:
        """Return which pixels ``ys x xs`` lie in an active cell, shape (len(ys), len(xs))."""
        column = np.searchsorted(self.edges_px(0), xs, "right")
        row = np.searchsorted(self.edges_px(1), ys, "right")
        rows, columns = self.active.shape
        edged = np.zeros((rows + 2, columns + 2), bool)
        edged[1:-1, 1:-1] = self.active
        return edged[row[:, None], column]


@dataclass(frozen=True, slots=True, eq=False)
class Domain:
    """The pixels that a warp resamples."""

    name: DomainName  # rule that selected the cells
    image: Box  # the full image
    cells: tuple[Cells, ...]  # active lattice cells per face; other pixels keep their bytes

    def mask(self, box: Box) -> Mask:
        """Return which pixels of `box` lie in the domain's cells, shape (height, width)."""
        if self.name == "image":
            return np.ones((box.height, box.width), bool)
        mask = np.zeros((box.height, box.width), bool)
        for cells in self.cells:
            mask |= cells.at(np.arange(box.left, box.right), np.arange(box.top, box.bottom))
        return mask

    @property
    def bounds(self) -> Box:
        """Bounding box of the domain, clipped to the image."""
        if self.name == "image":
            return self.image
        boxes = [_bounds(cells) for cells in self.cells if cells.active.any()]
        if not boxes:
            return Box(0, 0, 0, 0)
        lefts, tops, rights, bottoms = zip(*map(astuple, boxes), strict=True)
        return Box(min(lefts), min(tops), max(rights), max(bottoms)).clipped(self.image)


def _bounds(cells: Cells) -> Box:
    columns = np.flatnonzero(cells.active.any(axis=0))
    rows = np.flatnonzero(cells.active.any(axis=1))
    x, y = cells.edges_px(0), cells.edges_px(1)
    return Box(int(x[columns[0]]), int(y[rows[0]]), int(x[columns[-1] + 1]), int(y[rows[-1] + 1]))


def fade_of(recipe: Recipe) -> float:
    """Return the displacement below which the field fades to zero, px; 0 for no fade.

    A threshold up to `LOSSLESS_PX` needs no fade: it leaves no visible seam.
    """
    lossless = recipe.domain != "threshold" or recipe.threshold_px <= LOSSLESS_PX
    return 0.0 if lossless else recipe.threshold_px


def threshold_of(recipe: Recipe, field: Field) -> float:
    """Return the threshold T in use, px: `LOSSLESS_PX` if the guard refused the recipe's fade."""
    return LOSSLESS_PX if fade_of(recipe) > field.fade_px else recipe.threshold_px


def reduce(field: Field, image: Box, name: DomainName) -> Domain:
    """Select the cells to resample. No pixel outside the selected cells changes.

    ``control-points`` keeps the 4 x 4 cells that each non-zero control point reaches; the 3 x 3
    cells of section 4.1 leave a seam. ``threshold`` keeps cells in which a pixel could move by
    more than T, after large cells are refined.
    """
    match name:
        case "image" | "control-points":
            cells = tuple(Cells(lattice, lattice.reached) for lattice in field.lattices)
        case "threshold":
            # Displacements of overlapping faces add up, so each face gets an equal part of the
            # threshold. The factor leaves room for rounding in single precision.
            least_px = 0.99 * max(LOSSLESS_PX, field.fade_px)
            cells = tuple(
                cells_beyond(a, image, least_px / sum(meet(a, b) for b in field.lattices))
                for a in field.lattices
            )
        case unknown:
            assert_never(unknown)
    return Domain(name, image, cells)


def cells_beyond(lattice: Lattice, image: Box, least_px: float) -> Cells:
    """Return the cells of a lattice in which a pixel could move by more than `least_px`."""
    lattice = lattice.within(image)
    while lattice.grid.spacing_px > _LARGEST_CELL_PX:
        lattice = lattice.refined().within(image)
    return Cells(lattice, lattice.bound_px > least_px)


def threshold_mask(field: Field, box: Box, threshold_px: float = LOSSLESS_PX) -> Mask:
    """Return the pixels of `box` that move by more than T (figure 13). Result: bool (H, W)."""
    spline = Field(field.lattices)
    xs = np.arange(box.left, box.right)
    mask = np.zeros((box.height, box.width), bool)
    for top in range(box.top, box.bottom, _STRIP_PX):
        ys = np.arange(top, min(top + _STRIP_PX, box.bottom))
        displacement = spline.on_grid(xs, ys)
        mask[top - box.top : top - box.top + len(ys)] = (
            np.hypot(displacement[0], displacement[1]) > threshold_px
        )
    return mask


def mask_of(field: Field, box: Box, name: DomainName, threshold_px: float = LOSSLESS_PX) -> Mask:
    """Return the pixels of `box` in a domain of section 4. Result: bool (H, W)."""
    match name:
        case "image" | "control-points":
            return reduce(field, box, name).mask(box)
        case "threshold":
            return threshold_mask(field, box, threshold_px)
        case unknown:
            assert_never(unknown)


def pixel_counts(field: Field, image: Box, threshold_px: float) -> dict[DomainName, int]:
    """Count the pixels of the three domains (figures 14 and 15). Result: count per domain name."""
    apart = [[field.lattices[k] for k in group] for group in groups(field.lattices)]
    return {
        "image": image.area,
        "control-points": sum(_reached(group, image) for group in apart),
        "threshold": sum(_moving(group, image, threshold_px) for group in apart),
    }


def _reached(lattices: Sequence[Lattice], image: Box) -> int:
    """Count the pixels in cells that a non-zero control point of any of the lattices reaches."""
    cells = [Cells(lattice, lattice.reached) for lattice in lattices]
    # All pixels between two neighbouring cell edges lie in the same cells.
    x, y = (
        np.sort(np.concatenate([c.edges_px(axis) for c in cells]).clip(start, end))
        for axis, start, end in ((0, image.left, image.right), (1, image.top, image.bottom))
    )
    hit = np.any([c.at(x[:-1], y[:-1]) for c in cells], axis=0)
    return int(np.diff(y) @ hit @ np.diff(x))


def _moving(lattices: Sequence[Lattice], image: Box, threshold_px: float) -> int:
    """Count the pixels that overlapping lattices move by more than T."""
    reach = np.array([lattice.reach_px for lattice in lattices])
    low, high = np.floor(reach[:, :2].min(axis=0)), np.ceil(reach[:, 2:].max(axis=0))
    box = Box(*low.astype(int).tolist(), *high.astype(int).tolist()).clipped(image)
    tiles = _Tiles(box)
    least, most = np.stack([_tile_bounds(lattice, tiles) for lattice in lattices], axis=1)
    together = most.sum(axis=0)
    # Lower bound if the displacements of the other lattices partly cancel.
    least = (least - (together - most)).max(axis=0)
    total = int(tiles.heights @ (least > threshold_px) @ tiles.widths)
    at = np.argwhere((least <= threshold_px) & (together > threshold_px))
    for start in range(0, len(at), _AT_ONCE):
        rows, columns = at[start : start + _AT_ONCE].T
        displacement = np.zeros((len(rows), 2, _TILE_PX, _TILE_PX))
        for lattice, bound in zip(lattices, most, strict=True):
            mine = np.flatnonzero(bound[rows, columns])
            if len(mine):
                displacement[mine] += tiles.displacement(lattice, rows[mine], columns[mine])
        displacement *= displacement
        moved = displacement[:, 0] + displacement[:, 1] > threshold_px**2
        moved[rows == len(tiles.top) - 1, tiles.heights[-1] :] = False
        moved[columns == len(tiles.left) - 1, :, tiles.widths[-1] :] = False
        total += int(np.count_nonzero(moved))
    return total


class _Tiles:
    """Square tiles of `_TILE_PX` that cover a box, from its top left pixel."""

    def __init__(self, box: Box) -> None:
        self.box = box
        self.left = np.arange(box.left, box.right, _TILE_PX)
        self.top = np.arange(box.top, box.bottom, _TILE_PX)
        self.widths = np.minimum(_TILE_PX, box.right - self.left)
        self.heights = np.minimum(_TILE_PX, box.bottom - self.top)

    @property
    def spans_px(self) -> tuple[Array, Array]:
        """First and last pixel of each column of tiles along x, and of each row along y."""
        x = np.stack([self.left, self.left + self.widths - 1.0])
        return x, np.stack([self.top, self.top + self.heights - 1.0])

    def displacement(self, lattice: Lattice, rows: Array, columns: Array) -> Array:
        """Evaluate eq. (1) on tiles, shape (N, 2, 16, 16), px."""
        left, top = int(columns.min()), int(rows.min())
        first_i, bx = lattice.grid.weights(self.left[left : columns.max() + 1], _TILE_PX, 0)
        first_j, by = lattice.grid.weights(self.top[top : rows.max() + 1], _TILE_PX, 1)
        i, j, count = first_i - first_i[0], first_j - first_j[0], bx.shape[1]
        nodes = lattice.window(
            (int(first_i[0]), int(first_j[0])), (int(j[-1]) + count, int(i[-1]) + count)
        )
        windows = np.lib.stride_tricks.sliding_window_view(nodes, (count, count), (0, 1))
        rows, columns = rows - top, columns - left
        phi = windows[j[rows], i[columns]]
        return np.asarray(by[rows][:, None].swapaxes(2, 3) @ phi @ bx[columns][:, None])


def _tile_bounds(lattice: Lattice, tiles: _Tiles) -> tuple[Array, Array]:
    """Return a lower and an upper bound of the displacement in each tile, px."""
    while lattice.grid.spacing_px > _LARGEST_COUNTED_PX:
        lattice = lattice.refined()
    values = np.stack([-lattice.least_px, lattice.bound_px])
    least, most = lattice.most_in(values, tiles.spans_px)
    return -least, most
