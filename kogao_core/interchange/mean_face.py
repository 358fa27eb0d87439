"""A mean face in the mark-ups of 68 and 189 points, for the points that our 27 don't have."""

from __future__ import annotations

from functools import cache
from importlib import resources

import numpy as np

from kogao_core.geometry import Array, frozen
from kogao_core.landmarks.aam.points import OUTLINE_LABELS
from kogao_core.landmarks.outline import resampled


@cache
def means() -> dict[int, Array]:
    """Return the mean face of 189 points, and of 68, by their count.

    Returns
    -------
    dict of int to array of shape (count, 2)
        Unit: the outer inter-ocular distance of the 189.
    """
    text = resources.files(__package__).joinpath("mean189.csv").read_text(encoding="ascii")
    full = np.loadtxt(text.splitlines(), delimiter=",", skiprows=1)
    return {189: frozen(full), 68: frozen(_sixty_eight(full))}


def _sixty_eight(full: Array) -> Array:
    """Return the mean of iBUG's points from the 189: near enough to stand in for unknown ones."""
    bridge = [(full[50] + full[56]) / 2.0, (full[54] + full[60]) / 2.0]
    return np.vstack(
        [
            resampled(full[list(OUTLINE_LABELS)], 17),
            full[[*range(71, 76), *range(78, 83)]],
            resampled(np.array(bridge), 4),
            full[[64, 170, 55, 172, 69]],
            full[[18, 19, 21, 22, 30, 28, 23, 24, 26, 27, 33, 31]],
            full[[*range(87, 94), 108, 107, 106, 105, 104]],
            (full[87] + full[94]) / 2.0,
            full[[95, 96, 97]],
            (full[93] + full[98]) / 2.0,
            full[[102, 101, 100]],
        ]
    )
