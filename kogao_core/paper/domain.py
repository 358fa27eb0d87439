"""Section 4: the reduced warp domain, by control points (4.1) and by threshold (4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Final, assert_never

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Box
from kogao_core.paper.choices import LOSSLESS_PX as LOSSLESS_PX
from kogao_core.paper.choices import DomainName as DomainName
from kogao_core.paper.lattice import Lattice, Spline, groups, meet

Mask = npt.NDArray[np.bool_]
_LARGEST_CELL_PX: Final = 96  # refine larger cells: the bounds of smaller cells are tighter
_STRIP_PX: Final = 256  # rows evaluated per step, to limit the memory of a mask


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

    @property
    def bounds(self) -> Box:
        """Bounding box of the pixels in active cells; empty if no cell is active."""
        if not self.active.any():
            return Box(0, 0, 0, 0)
        columns = np.flatnonzero(self.active.any(axis=0))
        rows = np.flatnonzero(self.active.any(axis=1))
        x, y = self.edges_px(0), self.edges_px(1)
        return Box(*map(int, (x[columns[0]], y[rows[0]], x[columns[-1] + 1], y[rows[-1] + 1])))


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
            part = cells.bounds.clipped(box)
            if part.area:
                rows, columns = np.arange(part.top, part.bottom), np.arange(part.left, part.right)
                mask[np.ix_(rows - box.top, columns - box.left)] |= cells.at(columns, rows)
        return mask

    @property
    def bounds(self) -> Box:
        """Bounding box of the domain, clipped to the image."""
        if self.name == "image":
            return self.image
        boxes = [astuple(cells.bounds) for cells in self.cells if cells.active.any()]
        if not boxes:
            return Box(0, 0, 0, 0)
        low, high = np.min(boxes, axis=0), np.max(boxes, axis=0)
        return Box(*low[:2].tolist(), *high[2:].tolist()).clipped(self.image)


def reduce(
    lattices: Sequence[Lattice], image: Box, name: DomainName, threshold_px: float = LOSSLESS_PX
) -> Domain:
    """Select the cells to resample. No pixel outside the selected cells changes.

    ``control-points`` (figure 12) keeps the 4 x 4 cells that each non-zero control point reaches.
    Section 4.1 takes 3 x 3 control points, which leaves a seam (`docs/decisions/04`).
    ``threshold`` keeps cells in which a pixel could move by more than T, after large cells are
    refined.
    """
    match name:
        case "image" | "control-points":
            cells = tuple(Cells(lattice, lattice.reached) for lattice in lattices)
        case "threshold":
            # Displacements of overlapping faces add up, so each face gets an equal part of the
            # threshold. The factor leaves room for rounding in single precision.
            least_px = 0.99 * threshold_px
            cells = tuple(
                cells_beyond(a, image, least_px / sum(meet(a, b) for b in lattices))
                for a in lattices
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


def threshold_mask(
    lattices: Sequence[Lattice], box: Box, threshold_px: float = LOSSLESS_PX
) -> Mask:
    """Return the pixels of `box` that move by more than T (figure 13). Result: bool (H, W)."""
    spline = Spline(tuple(lattices))
    xs = np.arange(box.left, box.right)
    mask = np.zeros((box.height, box.width), bool)
    for top in range(box.top, box.bottom, _STRIP_PX):
        ys = np.arange(top, min(top + _STRIP_PX, box.bottom))
        displacement = spline.on_grid(xs, ys)
        moved = (displacement**2).sum(axis=0) > threshold_px**2
        mask[top - box.top : top - box.top + len(ys)] = moved
    return mask


def mask_of(
    lattices: Sequence[Lattice], box: Box, name: DomainName, threshold_px: float = LOSSLESS_PX
) -> Mask:
    """Return the pixels of `box` in a domain of section 4. Result: bool (H, W)."""
    match name:
        case "image" | "control-points":
            return reduce(lattices, box, name).mask(box)
        case "threshold":
            return threshold_mask(lattices, box, threshold_px)
        case unknown:
            assert_never(unknown)


def pixel_counts(
    lattices: Sequence[Lattice], image: Box, threshold_px: float
) -> dict[DomainName, int]:
    """Count the pixels of the three domains (figures 14 and 15). Result: count per domain name."""
    reached = moving = 0
    for group in groups(lattices):
        part = [lattices[k] for k in group]
        domain = reduce(part, image, "control-points")
        reached += int(domain.mask(domain.bounds).sum())
        moving += int(threshold_mask(part, domain.bounds, threshold_px).sum())
    return {"image": image.area, "control-points": reached, "threshold": moving}
