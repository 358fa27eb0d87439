"""The photo's edge: nothing moves across it, so no pixel is read from outside."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array, Box, ramp
from kogao_core.base.language import Text
from kogao_core.faces.targets import Pairs
from kogao_core.warp.lattice import ORDER, Lattice, basis

# A landmark so many times its move inside the photo makes all of it; nearer to the edge it makes
# less of the part across the edge, so that what lies between is stretched by a third at most.
_ROOM: Final = 4.0
_MISSED: Final = 0.05  # of its move: a face that loses more is said to lie at the edge


def edges_px(photo: Box) -> Array:
    """Return the centres of the photo's outermost pixels: least and greatest (x, y), (2, 2)."""
    return np.array(
        [(photo.left, photo.top), (photo.right - 1, photo.bottom - 1)], dtype=np.float64
    )


def slid(pairs: Pairs, photo: Box) -> Pairs:
    """Return pairs whose targets near the photo's edge move along it, and less across it."""
    moves = pairs.displacement_px
    low, high = edges_px(photo)
    room = np.where(moves < 0.0, pairs.source_px - low, high - pairs.source_px)
    share = ramp(room / np.maximum(_ROOM * np.abs(moves), 1e-9))
    if (share == 1.0).all():
        return pairs
    return dataclasses.replace(pairs, target_px=pairs.source_px - share * moves)


def kept_inside(lattice: Lattice, photo: Box) -> Lattice:
    """Return the lattice nearest to this one that moves nothing across the photo's edges.

    A row of control points across an edge is orthogonal to the basis there, eq. (1): the spline is
    0 all along the edge, and what is one-to-one then maps the photo onto itself.
    """
    for edge in edges_px(photo):
        for axis in (0, 1):
            lattice = _orthogonal(lattice, float(edge[axis]), axis)
    return lattice


def _orthogonal(lattice: Lattice, edge_px: float, axis: int) -> Lattice:
    cell, part = lattice.grid.locate(np.array([edge_px]), axis)
    start, first, shape = int(cell[0]) - 1, [*lattice.first], [*lattice.shape[::-1]]
    if not first[axis] - ORDER < start < first[axis] + shape[axis]:
        return lattice
    # All control points that reach the edge take part, those that nothing has moved, too.
    end = max(first[axis] + shape[axis], start + ORDER)
    first[axis] = min(first[axis], start)
    shape[axis] = end - first[axis]
    phi = lattice.window((first[0], first[1]), (shape[1], shape[0]))
    along = np.moveaxis(phi[..., axis], 1 - axis, 0)
    within = slice(start - first[axis], start - first[axis] + ORDER)
    if not along[within].any():
        return lattice
    weights = basis(part)[0]
    across = np.tensordot(weights, along[within], 1)
    along[within] -= weights[:, None] * across / float(weights @ weights)
    return Lattice(lattice.grid, (first[0], first[1]), phi)


def cut_note(pairs: Sequence[Pairs], asked: Sequence[Pairs]) -> str:
    """Return a sentence on faces that slide along the photo's edge; empty where none does.

    `pairs` are those that were rendered, `asked` those that the recipe asks for.
    """
    count = sum(
        bool((np.abs(a.target_px - b.target_px) > _MISSED * b.warp_distance_px).any())
        for a, b in zip(pairs, asked, strict=True)
    )
    if not count:
        return ""
    return Text.counted(
        count,
        "{n} face lies at the photo's edge: there it slides along the edge and gets no smaller",
        "{n} faces lie at the photo's edge: there they slide along the edge and get no smaller",
    )
