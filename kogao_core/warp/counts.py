"""Section 4: how many pixels each domain holds; cells are counted whole wherever they can be."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, assert_never

import numpy as np

from kogao_core.base.geometry import Array, Box
from kogao_core.recipe.settings import DOMAINS, DomainName
from kogao_core.warp.domain import Cells
from kogao_core.warp.field import Field
from kogao_core.warp.lattice import Lattice, groups

_TILE_PX: Final = 16  # squares that are counted whole, left out whole, or looked at
_LARGEST_CELL_PX: Final = 48  # smaller cells bound the displacement more tightly
_AT_ONCE: Final = 2048  # tiles looked at together: bounds the memory


def pixel_counts(field: Field, image: Box, threshold_px: float) -> dict[DomainName, int]:
    """Count the pixels of the three domains (figures 14 and 15).

    Result: number of pixels by name of the domain.
    """
    apart = [[field.lattices[k] for k in group] for group in groups(field.lattices)]
    return {one.name: _count(one.name, apart, image, threshold_px) for one in DOMAINS}


def _count(
    name: DomainName, apart: Sequence[Sequence[Lattice]], image: Box, threshold_px: float
) -> int:
    match name:
        case "image":
            return image.area
        case "control-points":
            return sum(_reached(group, image) for group in apart)
        case "threshold":
            return sum(_moving(group, image, threshold_px) for group in apart)
        case unknown:
            assert_never(unknown)


def _reached(lattices: Sequence[Lattice], image: Box) -> int:
    """Count the pixels in cells that a non-zero control point of any of the lattices reaches."""
    cells = [Cells(lattice, lattice.reached) for lattice in lattices]
    # Between neighbouring edges of any lattice all pixels lie in the same cells.
    x, y = (
        np.sort(np.concatenate([c.edges_px(axis) for c in cells]).clip(start, end))
        for axis, start, end in ((0, image.left, image.right), (1, image.top, image.bottom))
    )
    hit = np.any([c.at(x[:-1], y[:-1]) for c in cells], axis=0)
    return int(np.diff(y) @ hit @ np.diff(x))


def _moving(lattices: Sequence[Lattice], image: Box, threshold_px: float) -> int:
    """Count the pixels that lattices which reach into each other move by more than T."""
    reach = np.array([lattice.reach_px for lattice in lattices])
    low, high = np.floor(reach[:, :2].min(axis=0)), np.ceil(reach[:, 2:].max(axis=0))
    box = Box(*low.astype(int).tolist(), *high.astype(int).tolist()).clipped(image)
    tiles = _Tiles(box)
    least, most = np.stack([_bounds(lattice, tiles) for lattice in lattices], axis=1)
    together = most.sum(axis=0)
    # Wherever the others go, they leave a tile at least this far from home.
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
    """Squares of `_TILE_PX` that cover a box from its first pixel on."""

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


def _bounds(lattice: Lattice, tiles: _Tiles) -> tuple[Array, Array]:
    """Bound from below and above how far a lattice moves any pixel of each tile, px."""
    while lattice.grid.spacing_px > _LARGEST_CELL_PX:
        lattice = lattice.refined()
    values = np.stack([-lattice.least_px, lattice.bound_px])
    least, most = lattice.most_in(values, tiles.spans_px)
    return -least, most
