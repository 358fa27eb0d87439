"""Moving least squares (Schaefer, McPhail, Warren 2006): the most rigid map near each pixel.

Our own few lines: no library with the rigid form is kept up.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.base.language import Text
from kogao_core.lab.methods.base import Method, Warp, WarpTask, interpolated

_NEAREST_PX: Final = 1e-6  # a point on a landmark takes that landmark's displacement


class _Moving(Warp):
    def __init__(self, target_px: Array, displacement_px: Array) -> None:
        # Counted from the middle, so that products of places lose little to rounding.
        self._middle = target_px.mean(axis=0)
        self._from = target_px - self._middle
        at, goal = self._from, self._from + displacement_px
        # In the complex plane a turn with a scaling is one factor; its best one is a ratio of
        # weighted sums: of the places, the goals, and conj(place) * goal.
        turned = np.column_stack(
            [(at * goal).sum(axis=1), at[:, 0] * goal[:, 1] - at[:, 1] * goal[:, 0]]
        )
        self._summed = np.column_stack([np.ones(len(at)), at, goal, turned])

    def at(self, points_px: Array) -> Array:
        x, y = np.ascontiguousarray((points_px - self._middle).T)
        apart = np.square(x[:, None] - self._from[:, 0])
        apart += np.square(y[:, None] - self._from[:, 1])
        weight = np.reciprocal(np.maximum(apart, _NEAREST_PX**2, out=apart), out=apart)
        total, *sums = (weight @ self._summed).T
        from_x, from_y, goal_x, goal_y, along, across = (one / total for one in sums)
        # Of the factor the rigid map keeps the turn.
        along -= from_x * goal_x + from_y * goal_y
        across -= from_x * goal_y - from_y * goal_x
        size = np.hypot(along, across)
        still = size == 0.0
        size[still], along[still] = 1.0, 1.0
        along, across = along / size, across / size
        u, v = x - from_x, y - from_y
        return np.column_stack(
            [along * u - across * v + goal_x - x, across * u + along * v + goal_y - y]
        )


def _fit(task: WarpTask) -> Warp:
    """Weights fall with the square of the distance, without an end: the edges stay."""
    return _Moving(*task.anchored())


MOVING_LEAST_SQUARES: Final = Method(
    "moving",
    Text("Moving least squares, rigid"),
    Text("Schaefer et al. 2006"),
    Text("own (numpy)"),
    _fit,
    quick=interpolated(_fit),
)
