"""Section 4: which pixels need work. Control-point selection (4.1) and thresholding (4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, assert_never

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Box
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe
from kogao_core.recipe.settings import DomainName
from kogao_core.warp.field import Field
from kogao_core.warp.lattice import Lattice, meet

Mask = npt.NDArray[np.bool_]
_LARGEST_CELL_PX: Final = 96  # smaller cells are bounded more tightly
_STRIP_PX: Final = 256  # rows evaluated at a time: bounds the memory of a mask


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """The active cells of one lattice, shape (J + 3, I + 3), and its pixel columns and rows.

    A lattice cell owns the pixel centres in ``[origin + h i, origin + h (i + 1))``.
    """

    lattice: Lattice
    active: Mask

    def edges_px(self, axis: int) -> npt.NDArray[np.int64]:
        """Return the first pixel of each of n cells along `axis` (0 is x), and the end (n + 1,)."""
        count = self.active.shape[1 - axis] + 1
        edges = self.lattice.grid.nodes_px(self.lattice.first_cell[axis], count, axis)
        return np.ceil(edges).astype(np.int64)

    def mask(self, box: Box) -> Mask:
        """Return which pixels of `box` lie in an active cell, shape (height, width)."""
        return self.at(np.arange(box.left, box.right), np.arange(box.top, box.bottom))

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
    """The pixels that a warp works on."""

    name: DomainName  # how it was reduced
    image: Box  # the whole image
    cells: tuple[Cells, ...]  # active lattice cells per face; pixels outside them keep their bytes

    def mask(self, box: Box) -> Mask:
        """Return which pixels of `box` lie in the domain's cells, shape (height, width)."""
        if self.name == "image":
            return np.ones((box.height, box.width), bool)
        mask = np.zeros((box.height, box.width), bool)
        for cells in self.cells:
            mask |= cells.mask(box)
        return mask

    @property
    def bounds(self) -> Box:
        """Smallest box of the image that holds the domain."""
        if self.name == "image":
            return self.image
        boxes = [_bounds(cells) for cells in self.cells if cells.active.any()]
        if not boxes:
            return Box(0, 0, 0, 0)
        union = Box(
            min(b.left for b in boxes),
            min(b.top for b in boxes),
            max(b.right for b in boxes),
            max(b.bottom for b in boxes),
        )
        return union.clipped(self.image)


def _bounds(cells: Cells) -> Box:
    columns = np.flatnonzero(cells.active.any(axis=0))
    rows = np.flatnonzero(cells.active.any(axis=1))
    x, y = cells.edges_px(0), cells.edges_px(1)
    return Box(int(x[columns[0]]), int(y[rows[0]]), int(x[columns[-1] + 1]), int(y[rows[-1] + 1]))


def fade_of(recipe: Recipe) -> float:
    """Return the T of the field's fade: none up to the lossless threshold, which shows no seam.

    Result: px; 0 is no fade.
    """
    lossless = recipe.domain != "threshold" or recipe.threshold_px <= LOSSLESS_PX
    return 0.0 if lossless else recipe.threshold_px


def threshold_of(recipe: Recipe, field: Field) -> float:
    """Return the T of a rendering: the recipe's, or the lossless one where its fade was refused.

    Result: px.
    """
    return LOSSLESS_PX if fade_of(recipe) > field.fade_px else recipe.threshold_px


def reduce(field: Field, image: Box, name: DomainName) -> Domain:
    """Select the cells to work on.

    ``control-points`` keeps every cell that a non-zero control point reaches: 4 x 4 of them, not
    the 3 x 3 of section 4.1, which leaves a seam. ``threshold`` keeps the cells in which a pixel
    could move by more than T, the field's own or the lossless one; large cells are cut up first.
    Result: no pixel outside it changes.
    """
    match name:
        case "image" | "control-points":
            cells = tuple(Cells(lattice, lattice.reached) for lattice in field.lattices)
        case "threshold":
            # Neighbours' displacements add up, so each face may only use up its share of the
            # threshold; a little less, because single precision may round a displacement up.
            least_px = 0.99 * max(LOSSLESS_PX, field.fade_px)
            cells = tuple(
                cells_beyond(a, image, least_px / sum(meet(a, b) for b in field.lattices))
                for a in field.lattices
            )
        case unknown:
            assert_never(unknown)
    return Domain(name, image, cells)


def cells_beyond(lattice: Lattice, image: Box, least_px: float) -> Cells:
    """Return the cells of a lattice in which a pixel of the image could move by more than that."""
    lattice = lattice.within(image)
    while lattice.grid.spacing_px > _LARGEST_CELL_PX:
        lattice = lattice.refined().within(image)
    return Cells(lattice, lattice.bound_px > least_px)


def threshold_mask(field: Field, box: Box, threshold_px: float = LOSSLESS_PX) -> Mask:
    """Return which pixels of `box` move by more than T: figure 13's regions, exact to the pixel.

    Result bool (height, width).
    """
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
    """Return which pixels of `box` belong to a domain of section 4. Result bool (height, width)."""
    match name:
        case "image":
            return np.ones((box.height, box.width), bool)
        case "control-points":
            return reduce(field, box, name).mask(box)
        case "threshold":
            return threshold_mask(field, box, threshold_px)
        case unknown:
            assert_never(unknown)
