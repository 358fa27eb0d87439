"""Limit displacements where they would fold or squeeze the picture, and only there."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.additions.edge import zero_on_edges
from kogao_core.base.geometry import Array, Box, smoothstep
from kogao_core.field.field import Field
from kogao_core.field.one_to_one import (
    LEAST_MEASURED_DET,
    certify,
    edges_are_safe,
    least_det,
    least_dets,
    protected_slopes,
)
from kogao_core.field.protection import NOTHING
from kogao_core.paper.lattice import Lattice, groups, meet, quantised

# The limited field keeps det J at least this large: below, the result looks squeezed or smeared.
LEAST_DET: Final = 0.4
# Cells below it are brought up to this.
_AIM: Final = 0.42
# The same for the bound of `protected_slopes`, which must stay below 1.
_MOST_SLOPE: Final = 0.98
# Control points up to this distance from a cell that needs a limit get the whole limit, in lattice
# spacings.
_NEAR: Final = 1.0
_FADE: Final = 2.5  # distance over which the limit fades beyond, in lattice spacings
_ROUNDS: Final = 8  # most rounds of limits, each near the cells that still squeeze
_BISECTIONS: Final = 10  # steps of `bisected`; each halves the error

# The same as `LEAST_DET` for strokes of a brush: a user squeezes there on purpose.
_LEAST_DET_OF_STROKES: Final = LEAST_DET / 2.0


@dataclasses.dataclass(frozen=True, slots=True)
class Limit:
    """How much of a face's displacement is kept where it is reduced the most."""

    share: float = 1.0  # 1: nothing is reduced
    place_px: tuple[float, float] | None = None  # (x, y) of that control point


def limited(field: Field, photo: Box | None = None) -> tuple[Field, tuple[Limit, ...]]:
    """Reduce displacements near cells where det J falls below `LEAST_DET`, and only there.

    Control points are multiplied by weights that rise smoothly to 1 with the distance from such a
    cell. A group of lattices that is still not one-to-one after some rounds is scaled as a whole.
    A fade of short displacements that could fold is removed. Nothing moves across the edges of
    `photo`. Result: a field that does not fold, and the limit of each lattice.
    """
    weights = [np.ones(lattice.shape) for lattice in field.lattices]
    spline = dataclasses.replace(field, fade_px=0.0)
    for group in groups(field.lattices):
        part = dataclasses.replace(spline, lattices=tuple(field.lattices[k] for k in group))
        for k, weight in zip(group, _weights(part, photo), strict=True):
            weights[k] = weight
    found = zip(field.lattices, weights, strict=True)
    limits = tuple(_limit(lattice, weight) for lattice, weight in found)
    field = _weighted(field, weights, photo)
    if not edges_are_safe(field):
        field = dataclasses.replace(field, fade_px=0.0)
    return field, limits


def limited_stroke(
    field: Field, changes: Sequence[Lattice], photo: Box
) -> tuple[Sequence[Lattice], float]:
    """Reduce the lattices of a brush stroke near cells that they would squeeze, and only there.

    Result: the lattices, and the smallest share of their displacement that is kept.
    """
    near = [a for a in field.lattices if any(meet(a, one) for one in changes)]
    part = dataclasses.replace(field, lattices=(*near, *changes), fade_px=0.0)
    weights = _weights(part, photo, len(near))
    share = min(_limit(*each).share for each in zip(part.lattices, weights, strict=True))
    return _weighted(part, weights, photo).lattices[len(near) :], share


def _weights(part: Field, photo: Box | None, fixed: int = 0) -> list[Array]:
    """Return the weights of the control points of a group of lattices; 1 for the first `fixed`."""
    weights, det = [np.ones(lattice.shape) for lattice in part.lattices], None
    for _ in range(_ROUNDS):
        field = _weighted(part, weights, photo)
        limits = [*_limits(field, fixed)]
        if not limits:
            det = LEAST_MEASURED_DET  # or more, everywhere
            break
        places, shares, reach = (np.concatenate(each) for each in zip(*limits, strict=True))
        for weight, lattice in zip(weights[fixed:], part.lattices[fixed:], strict=True):
            weight *= _weight(lattice, places, shares, reach)
    field = _weighted(part, weights, photo)
    share = (
        1.0
        if is_safe(field, det)
        else bisected(lambda share: is_safe(_scaled(field, share, fixed)), 1.0)
    )
    return [*weights[:fixed], *(share * weight for weight in weights[fixed:])]


def _scaled(field: Field, share: float, fixed: int) -> Field:
    """Return the field with a share of all lattices but the first `fixed`."""
    lattices = field.lattices[fixed:]
    scaled = (lattice.scaled(share) for lattice in lattices)
    return dataclasses.replace(field, lattices=(*field.lattices[:fixed], *scaled))


def _limits(field: Field, fixed: int) -> Iterator[tuple[Array, Array, Array]]:
    """Yield places (N, 2), px, the share of the displacement that each bears, and its spacing."""
    plain = dataclasses.replace(field, protection=NOTHING)
    floor = _LEAST_DET_OF_STROKES if fixed else LEAST_DET
    for number, lattice in enumerate(field.lattices):
        det = least_dets(plain, lattice, floor)
        if not (det < floor).any():
            continue
        # About the smallest det J without the stroke.
        bare = _scaled(plain, 0.0, fixed)
        before = np.minimum(least_dets(bare, bare.lattices[number]), 1.0) if fixed else 1.0
        before = np.broadcast_to(before, det.shape)
        low = det < np.minimum(floor, before)
        before, det = before[low], det[low]
        # Slopes shrink with the displacement: 1 - det J does at least in proportion.
        aim = np.minimum(_AIM / LEAST_DET * floor, before)
        yield from _at(lattice, low, (before - aim) / (before - det))
    for fine, slope in protected_slopes(field):
        steep = slope >= 1.0
        yield from _at(fine, steep, _MOST_SLOPE / slope[steep])


def _at(
    lattice: Lattice, cells: npt.NDArray[np.bool_], shares: Array
) -> Iterator[tuple[Array, Array, Array]]:
    """Yield the middles of some cells, unless there are none, with their shares and spacings."""
    if not len(shares):
        return
    h, corner = lattice.grid.spacing_px, np.add(lattice.first_cell, np.argwhere(cells)[:, ::-1])
    yield lattice.grid.origin_px + h * (corner + 0.5), shares, np.full(len(shares), h)


def _weight(lattice: Lattice, places: Array, shares: Array, reach: Array) -> Array:
    """Return the factor of each control point of a lattice, (J, I)."""
    (i, j), (rows, columns), h = lattice.first, lattice.shape, lattice.grid.spacing_px
    x, y = lattice.grid.nodes_px(i, columns, 0), lattice.grid.nodes_px(j, rows, 1)
    factor: Array = np.ones(lattice.shape)
    for (px, py), share, side in zip(places.tolist(), shares.tolist(), reach.tolist(), strict=True):
        apart = np.hypot(x - px, (y - py)[:, None]) / max(h, side)
        np.minimum(factor, share + (1.0 - share) * smoothstep((apart - _NEAR) / _FADE), out=factor)
    return factor


def _weighted(field: Field, weights: Sequence[Array], photo: Box | None) -> Field:
    """Return a field with control points multiplied by weights; the same where all are 1."""
    lattices = tuple(
        a
        if (weight == 1.0).all()
        else quantised(zero_on_edges(Lattice(a.grid, a.first, a.phi * weight[..., None]), photo))
        for a, weight in zip(field.lattices, weights, strict=True)
    )
    if all(a is b for a, b in zip(lattices, field.lattices, strict=True)):
        return field
    return dataclasses.replace(field, lattices=lattices)


def _limit(lattice: Lattice, weight: Array) -> Limit:
    moving = np.where(lattice.phi.any(axis=2), weight, 1.0)
    row, column = np.unravel_index(moving.argmin(), moving.shape)
    if moving[row, column] == 1.0:
        return Limit()
    i, j = np.add(lattice.first, (column, row))
    place = lattice.grid.node_px(i, 0), lattice.grid.node_px(j, 1)
    return Limit(float(moving[row, column]), (float(place[0]), float(place[1])))


def bisected(allows: Callable[[float], bool], most: float) -> float:
    """Return about the largest share that is allowed, 0 to `most`."""
    low, high = 0.0, most
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2.0
        if allows(middle):
            low = middle
        else:
            high = middle
    return low


def is_safe(field: Field, det: float | None = None) -> bool:
    """Return whether a field is proven, or of touching faces measured, to be one-to-one.

    `det`: its least det J, if known.
    """
    if not edges_are_safe(field):
        return False
    if certify(field):
        return True
    if len(field.lattices) == 1:
        return False
    return (least_det(field, LEAST_MEASURED_DET) if det is None else det) >= LEAST_MEASURED_DET
