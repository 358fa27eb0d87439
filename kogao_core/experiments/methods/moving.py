"""Moving least squares (Schaefer, McPhail, Warren 2006): the most rigid map near each pixel.

Our own few lines: no library with the rigid form is kept up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.experiments.methods.base import Warp, WarpTask
from kogao_core.geometry import Array

_NEAREST_PX: Final = 1e-6  # a point on a landmark takes that landmark's displacement


class _Moving(Warp):
    def __init__(self, target_px: Array, displacement_px: Array) -> None:
        self._from = _complex(target_px)
        self._onto = _complex(target_px + displacement_px)

    def displacement(self, points_px: Array) -> Array:
        at = _complex(points_px)[:, None]
        weight = 1.0 / np.maximum(np.abs(self._from - at), _NEAREST_PX) ** 2
        weight /= weight.sum(axis=1, keepdims=True)
        center, goal = weight @ self._from, weight @ self._onto
        # In the complex plane a turn with a scaling is one factor; its best one is a ratio of
        # weighted sums, of which the rigid map keeps the turn.
        around, wanted = self._from - center[:, None], self._onto - goal[:, None]
        factor = (weight * np.conj(around) * wanted).sum(axis=1)
        size = np.abs(factor)
        turn = np.where(size > 0.0, factor / np.where(size > 0.0, size, 1.0), 1.0)
        displacement = turn * (at[:, 0] - center) + goal - at[:, 0]
        return np.column_stack([displacement.real, displacement.imag])


def _complex(points_px: Array) -> np.ndarray:
    return np.asarray(points_px[:, 0] + 1j * points_px[:, 1])


@dataclass(frozen=True, slots=True)
class MovingLeastSquares:
    """Weights fall with the square of the distance; without an end, so corners are pinned."""

    name: str = "moving"
    title: str = "Moving least squares, rigid"
    reference: str = "Schaefer et al. 2006"
    library: str = "own (numpy)"
    needs: str = ""

    def fit(self, task: WarpTask) -> Warp:
        """Keep the handles; all work is done at each pixel."""
        return _Moving(*task.anchored())
