"""What retouchers do today: a soft brush pushed at each landmark."""

from __future__ import annotations

from typing import Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.base.language import Text
from kogao_core.lab.methods.base import Method, Warp, WarpTask, interpolated

BRUSH_SPACINGS: Final = 1.0  # standard deviation of the brush, in landmark spacings


class _Pushed(Warp):
    """Strokes one after the other; a point goes back through them, the last one first."""

    def __init__(self, target_px: Array, displacement_px: Array, width_px: float) -> None:
        self._target, self._displacement, self._width_px = target_px, displacement_px, width_px

    def at(self, points_px: Array) -> Array:
        x, y = np.array(np.transpose(points_px), np.float64, order="C")
        for target, displacement in zip(self._target[::-1], self._displacement[::-1], strict=True):
            apart = np.square(x - target[0])
            apart += np.square(y - target[1])
            apart /= -2.0 * self._width_px**2
            pushed = np.exp(apart, out=apart)
            x += pushed * displacement[0]
            y += pushed * displacement[1]
        return np.column_stack([x, y]) - points_px


def _fit(task: WarpTask) -> Warp:
    """Choose the strength of the strokes, all composed before the photo is resampled once.

    Neighbouring strokes add up, so all are made weaker by one factor, such that landmarks move as
    far as they should on average: what a careful hand would do.
    """
    width_px = BRUSH_SPACINGS * task.spacing_px
    full = _Pushed(task.target_px, task.displacement_px, width_px).at(task.target_px)
    asked = np.linalg.norm(task.displacement_px, axis=1).mean()
    strength = asked / max(float(np.linalg.norm(full, axis=1).mean()), 1e-12)
    return _Pushed(task.target_px, strength * task.displacement_px, width_px)


LIQUIFY: Final = Method(
    "liquify", Text("Liquify, Gaussian brush"), Text("today's practice"), Text("own (numpy)"), _fit,
    quick=interpolated(_fit),
)  # fmt: skip
