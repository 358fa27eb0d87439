"""Displacements at the photo's edge: none across the edge, so no pixel is read from outside."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array, Box, ramp
from kogao_core.base.language import Text
from kogao_core.faces.targets import FacePairs
from kogao_core.paper.basis import ORDER, basis
from kogao_core.paper.lattice import Lattice

# A landmark farther from the photo's edge than this many times its move moves fully. Nearer, the
# component across the edge is reduced. Smaller values stretch the strip along the edge more: 4
# stretches by a third at most.
_ROOM: Final = 4.0
# The same for a head that moves as a whole: the pivot already keeps more distance from the edge.
_ROOM_OF_HEAD: Final = 3.0
_PEAK: Final = 0.7616  # where `ramp` is steepest seen from its start: ramp(x) / x is largest
# The note mentions a face that loses more than this share of its move or of its Amount.
_MISSED: Final = 0.05


def edges_px(photo: Box) -> Array:
    """Return the centres of the photo's outermost pixels: least and greatest (x, y), (2, 2)."""
    return np.array(
        [(photo.left, photo.top), (photo.right - 1, photo.bottom - 1)], dtype=np.float64
    )


def attenuated_near_edge(pairs: FacePairs, photo: Box) -> FacePairs:
    """Reduce the moves of landmarks across the photo's edge; keep the component along the edge."""
    moves = pairs.displacement_px
    low, high = edges_px(photo)
    room = np.where(moves < 0.0, pairs.source_px - low, high - pairs.source_px)
    times = _ROOM_OF_HEAD if pairs.head_share else _ROOM
    room = room / np.maximum(times * np.abs(moves), 1e-9)
    # With less room than at the peak, a longer move goes as far as the peak's: never less.
    share = ramp(np.maximum(room, _PEAK)) * np.clip(room / _PEAK, 0.0, 1.0)
    if (share == 1.0).all():
        return pairs
    return dataclasses.replace(pairs, target_px=pairs.source_px - share * moves)


def zero_on_edges(lattice: Lattice, photo: Box | None) -> Lattice:
    """Return the nearest lattice that moves nothing across the edges of `photo`, if any.

    Control points across an edge are made orthogonal to the basis, eq. (1). The spline is then 0
    all along the edge, and a one-to-one map maps the photo onto itself.
    """
    for edge in () if photo is None else edges_px(photo):
        for axis in (0, 1):
            lattice = _orthogonal(lattice, float(edge[axis]), axis)
    return lattice


def _orthogonal(lattice: Lattice, edge_px: float, axis: int) -> Lattice:
    cell, part = lattice.grid.locate(np.array([edge_px]), axis)
    start, first, shape = int(cell[0]) - 1, [*lattice.first], [*lattice.shape[::-1]]
    if not first[axis] - ORDER < start < first[axis] + shape[axis]:
        return lattice
    # Include all control points that reach the edge, even if they are still zero.
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


def cut_note(
    pairs: Sequence[FacePairs],
    requested: Sequence[FacePairs],
    percents: Sequence[float],
    rendered: Sequence[FacePairs] = (),
) -> str:
    """Return a sentence on faces with too little space in the photo; empty if there are none.

    `pairs` are those the photo's edge allows; `requested` and `percents` are the requested pairs
    and Amounts; `rendered` follow heads in front.
    """
    cut = sum(
        bool((np.abs(a.target_px - b.target_px) > _MISSED * b.warp_distance_px).any())
        for a, b in zip(pairs, requested, strict=True)
    )
    lowered = [
        100.0 * pair.head_share
        for pair, percent in zip(pairs, percents, strict=True)
        if pair.head_share and abs(100.0 * pair.head_share) < (1.0 - _MISSED) * abs(percent)
    ]
    behind = sum(
        float(np.hypot(*(a.target_px - b.target_px).T).mean()) > _MISSED * b.warp_distance_px
        for a, b in zip(rendered, pairs, strict=False)
    )
    notes = []
    if behind:
        notes.append(
            Text.counted(
                behind,
                "{n} face is partly behind another person: it gets less small there",
                "{n} faces are partly behind other people: they get less small there",
            )
        )
    if cut:
        notes.append(
            Text.counted(
                cut,
                "{n} face lies at the photo's edge: it slides along the edge and gets no smaller "
                "there",
                "{n} faces lie at the photo's edge: they slide along the edge and get no smaller "
                "there",
            )
        )
    if lowered:
        notes.append(
            Text.counted(
                len(lowered),
                "{n} head fills the photo: Amount lowered to {percent:.1f} %",
                "{n} heads fill the photo: Amount lowered, down to {percent:.1f} %",
                percent=min(lowered, key=abs),
            )
        )
    return Text.joined("; ", notes) if notes else ""
