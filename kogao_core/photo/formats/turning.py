"""The eight EXIF orientations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from kogao_core.base.geometry import Image

_TURNS: Final[dict[int, Callable[[Image], Image]]] = {
    1: lambda stored: stored,
    2: np.fliplr,
    3: lambda stored: np.rot90(stored, 2),
    4: np.flipud,
    5: lambda stored: stored.swapaxes(0, 1),
    6: lambda stored: np.rot90(stored, -1),
    7: lambda stored: np.rot90(stored, 2).swapaxes(0, 1),
    8: np.rot90,
}
_BACK: Final = {6: 8, 8: 6}  # all others undo themselves


def turn_upright(stored: Image, orientation: int) -> Image:
    """Return stored pixels of shape (H, W) or (H, W, C) as the orientation 1 to 8 shows them."""
    return np.ascontiguousarray(_TURNS[orientation](stored))


def as_stored(upright: Image, orientation: int) -> Image:
    """Return upright pixels as a file of that orientation holds them; a view, where it can be."""
    return _TURNS[_BACK.get(orientation, orientation)](upright)
