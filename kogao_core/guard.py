"""Never render a fold: hold a face's displacement back to the largest share that is one-to-one."""

from __future__ import annotations

import dataclasses
from typing import Final

from kogao_core.falloff import NO_FALLOFF
from kogao_core.field import Field
from kogao_core.lattice import groups
from kogao_core.one_to_one import (
    LEAST_MEASURED_DET,
    certify,
    edges_are_safe,
    falloff_slope,
    least_det,
)

_BISECTIONS: Final = 10
_BELOW_ONE: Final = 1.0 - 1e-6


def hold_back(field: Field) -> tuple[Field, tuple[float, ...]]:
    """Scale the displacements of faces that would fold, and refuse a fade that would.

    A lattice that stands alone is held back until it is proven one-to-one; faces whose lattices
    reach into each other are held back together, until proven or at least measured so. Beside a
    falloff the proof is needed in any case. A fade is kept only where it is proven harmless;
    without it the lossless threshold holds.

    Parameters
    ----------
    field : Field
        What the recipe asks for.

    Returns
    -------
    Field
        A field whose det J is positive.
    tuple of float
        Share of each face's displacement that was kept; 1 where nothing had to be done.

    Examples
    --------
    >>> import numpy as np
    >>> import kogao_core as kogao
    >>> from kogao_core.guard import hold_back
    >>> from kogao_core.one_to_one import check_one_to_one
    >>> face = kogao.template_face((240, 180), 200)
    >>> photo = np.zeros((360, 480), np.uint8)
    >>> rough = kogao.Recipe(percent=15, lattice=0.25, guard=False)
    >>> rendering = kogao.render(photo, [face], rough)
    >>> rendering.one_to_one.folds
    True
    >>> held, (share,) = hold_back(rendering.field)
    >>> 0.0 < share < 1.0, check_one_to_one(held).folds
    (True, False)
    """
    shares = [1.0] * len(field.lattices)
    for group in groups(field.lattices):
        part = Field(tuple(field.lattices[k] for k in group), falloff=field.falloff)
        share = _largest_safe_share(part)
        for k in group:
            shares[k] = share
    held = _scaled(field, shares)
    if not edges_are_safe(held):
        held = dataclasses.replace(held, fade_px=0.0)
    return held, tuple(shares)


def _largest_safe_share(field: Field) -> float:
    # What the falloff bears is known without a search: its bound grows with the displacement.
    slope = falloff_slope(field)
    most = 1.0 if slope < 1.0 else _BELOW_ONE / slope
    if _safe(_scaled(field, [most] * len(field.lattices))):
        return most
    low, high = 0.0, most
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2.0
        if _safe(_scaled(field, [middle] * len(field.lattices))):
            low = middle
        else:
            high = middle
    return low


def is_safe(field: Field) -> bool:
    """Return whether a field needs no holding back.

    Parameters
    ----------
    field : Field
        With its fade and its falloff.

    Returns
    -------
    bool

    Examples
    --------
    >>> import numpy as np
    >>> import kogao_core as kogao
    >>> from kogao_core.guard import is_safe
    >>> face = kogao.template_face((240, 180), 200)
    >>> photo = np.zeros((360, 480), np.uint8)
    >>> is_safe(kogao.render(photo, [face], kogao.Recipe(percent=6)).field)
    True
    """
    return edges_are_safe(field) and _safe(field)


def _safe(field: Field) -> bool:
    """Return whether a field that its falloff can't fold is one-to-one."""
    if certify(dataclasses.replace(field, falloff=NO_FALLOFF)):
        return True
    if len(field.lattices) == 1:
        return False
    return least_det(field, LEAST_MEASURED_DET) >= LEAST_MEASURED_DET


def _scaled(field: Field, shares: list[float]) -> Field:
    if all(share == 1.0 for share in shares):
        return field
    lattices = (a.scaled(share) for a, share in zip(field.lattices, shares, strict=True))
    return dataclasses.replace(field, lattices=tuple(lattices))
