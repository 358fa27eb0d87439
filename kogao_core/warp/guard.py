"""Never render a fold: hold a face's displacement back to the largest share that is one-to-one."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.warp.field import Field
from kogao_core.warp.lattice import Lattice, groups, meet
from kogao_core.warp.one_to_one import (
    LEAST_MEASURED_DET,
    Shrinking,
    certify,
    edges_are_safe,
    falloff_slope,
    least_det,
    least_dets,
)

_BISECTIONS: Final = 10
_BELOW_ONE: Final = 1.0 - 1e-6
_SLIGHT_SLOPE: Final = 0.05  # of a displacement that has no part in a fold
_CLEAR_DET: Final = LEAST_MEASURED_DET + 1e-9  # what is found clear is measured so, however rounded

# A stroke may bring det J down so far, and where it is there already by this factor each; samples
# of the faces' lattices lie elsewhere than those of a stroke's.
_ROOM: Final = 4.0 * LEAST_MEASURED_DET
_LEFT: Final = 0.6
_LEAST_LEFT: Final = 1.4 * LEAST_MEASURED_DET


def hold_back(field: Field) -> tuple[Field, tuple[float, ...]]:
    """Scale the displacements of faces that would fold, and refuse a fade that would.

    A lattice that stands alone is held back until it is proven one-to-one. Of faces whose lattices
    reach into each other those that reach a fold are held back together, until the whole is proven
    or at least measured one-to-one. Beside a falloff the proof is needed in any case. A fade is
    kept only where it is proven harmless; without it the lossless threshold holds. Result: a field
    whose det J is positive; share of each face's displacement that was kept; 1 where nothing had to
    be done.
    """
    shares = [1.0] * len(field.lattices)
    for group in groups(field.lattices):
        part = Field(tuple(field.lattices[k] for k in group), falloff=field.falloff)
        for k, share in zip(group, _largest_safe_shares(part), strict=True):
            shares[k] = share
    held = _scaled(field, shares)
    if not edges_are_safe(held):
        held = dataclasses.replace(held, fade_px=0.0)
    return held, tuple(shares)


def share_let_in(
    field: Field, changes: Sequence[Lattice], after: Callable[[float], Field]
) -> float:
    """Return how much of further displacements, all by one share, a field bears without a fold.

    Where they make det J smaller than `_ROOM` they leave most of it, at all samples, and one that
    stands alone is proven; `after` is the field with a share of them. Result: 1 where all of it is.
    """
    near = [a for a in field.lattices if any(meet(a, one) for one in changes)]
    whole = dataclasses.replace(field, lattices=(*near, *changes), fade_px=0.0)
    members = range(len(near), len(whole.lattices))
    # What is finer than a change has samples of its own there.
    finer = [
        a.within(one.box)
        for one in changes
        for a in near
        if a.grid.spacing_px < one.grid.spacing_px and meet(a, one)
    ]
    samples = [Shrinking(whole, one, members, _ROOM) for one in (*changes, *finer)]
    before = [one.dets(0.0) for one in samples]
    least = [np.minimum(was, np.clip(_LEFT * was, _LEAST_LEFT, _ROOM)) for was in before]

    def allows(share: float) -> bool:
        if any((one.dets(share) < most).any() for one, most in zip(samples, least, strict=True)):
            return False
        if field.falloff.strokes and falloff_slope(after(share)) >= 1.0:
            return False
        return len(whole.lattices) > 1 or certify(Field(after(share).lattices[-1:]))

    return 1.0 if allows(1.0) else bisected(allows, 1.0)


def _largest_safe_shares(field: Field) -> list[float]:
    """Return how much is kept of each displacement of a group."""
    # What the falloff bears is known without a search: its bound grows with the displacement.
    slope = falloff_slope(field)
    most = 1.0 if slope < 1.0 else _BELOW_ONE / slope
    everybody = set(range(len(field.lattices)))
    shares, together = [most for _ in everybody], list[set[int]]()
    if len(shares) == 1:
        is_sound = _safe(_scaled(field, shares))
        return shares if is_sound else [bisected(lambda s: _safe(_scaled(field, [s])), most)]
    near = everybody
    # What is proven isn't measured, nor what is as it was.
    while not certify(held := _scaled(field, shares)) and (cells := [*_folding(held, near)]):
        found = _joined([*together, *cells])
        fresh = [one for one in found if one not in together]
        if not fresh:  # slight slopes make the difference
            found = fresh = [everybody]
        for members in fresh:
            share = _largest_safe_share(field, shares, members, most)
            for k in members:
                shares[k] = share
        together, near = found, set().union(*fresh)
    return shares


def _largest_safe_share(
    field: Field, shares: Sequence[float], members: set[int], most: float
) -> float:
    """Return how much some lattices may keep, the others of their group keeping their shares."""
    held = _scaled(field, [1.0 if k in members else one for k, one in enumerate(shares)])
    samples = [Shrinking(held, lattice, members, _CLEAR_DET) for lattice in _meeting(held, members)]
    return bisected(lambda share: not any(_they_fold(one, share) for one in samples), most)


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


def _they_fold(samples: Shrinking, share: float) -> bool:
    """Return whether those who shrink bend any sample that comes close to a fold."""
    folds = samples.dets(share) < _CLEAR_DET
    return bool(folds.any() and _bends(samples.steepest(share)[:, folds])[samples.shrinks].any())


def _folding(field: Field, near: Collection[int]) -> Iterator[set[int]]:
    """Yield, for each cell near some lattices that comes close to a fold, those that bend it."""
    for lattice in _meeting(field, near):
        folds = least_dets(field, lattice, LEAST_MEASURED_DET) < LEAST_MEASURED_DET
        if not folds.any():
            continue
        spans = lattice.cell_spans_px
        slopes = np.stack([a.most_in(a.steepest, spans)[folds] for a in field.lattices])
        for bends in _bends(slopes).T:
            yield set(np.flatnonzero(bends).tolist())


def _meeting(field: Field, some: Collection[int]) -> Iterator[Lattice]:
    """Yield the lattices that reach into some of them, themselves included."""
    for lattice in field.lattices:
        if any(meet(lattice, field.lattices[k]) for k in some):
            yield lattice


def _bends(slopes: Array) -> npt.NDArray[np.bool_]:
    """Return which lattices have a part in a fold, by their slopes there (lattices, folds)."""
    return np.asarray((slopes >= _SLIGHT_SLOPE) | (slopes == slopes.max(axis=0)))


def _joined(sets: Sequence[set[int]]) -> list[set[int]]:
    """Return sets of which no two have a member in common."""
    found: list[set[int]] = []
    for one in sets:
        near = [other for other in found if other & one]
        found = [other for other in found if not other & one] + [one.union(*near)]
    return found


def is_safe(field: Field, det: float | None = None) -> bool:
    """Return whether a field needs no holding back."""
    return edges_are_safe(field) and _safe(field, det)


def _safe(field: Field, det: float | None = None) -> bool:
    """Return whether a field that its falloff can't fold is one-to-one."""
    if certify(field):
        return True
    if len(field.lattices) == 1:
        return False
    return (least_det(field, LEAST_MEASURED_DET) if det is None else det) >= LEAST_MEASURED_DET


def _scaled(field: Field, shares: Sequence[float]) -> Field:
    if all(share == 1.0 for share in shares):
        return field
    lattices = (
        lattice if share == 1.0 else lattice.scaled(share)
        for lattice, share in zip(field.lattices, shares, strict=True)
    )
    return dataclasses.replace(field, lattices=tuple(lattices))
