"""Radial functions through scattered landmarks, by scipy."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from kogao_core.experiments.methods.base import Method, Warp, WarpTask
from kogao_core.geometry import Array
from kogao_core.language import Text

# Gaussians this wide, in landmark spacings, blend along the outline and end soon beside it.
GAUSSIAN_SPACINGS: Final = 1.5


class _Interpolated(Warp):
    def __init__(self, interpolator: Any) -> None:
        self._interpolator = interpolator

    def displacement(self, points_px: Array) -> Array:
        return np.asarray(self._interpolator(points_px), np.float64)


def _thin_plate(task: WarpTask) -> Warp:
    """Fit the surface that bends least through all landmarks; it never ends: corners are pinned."""
    from scipy.interpolate import RBFInterpolator

    target, displacement = task.anchored()
    return _Interpolated(RBFInterpolator(target, displacement, kernel="thin_plate_spline"))


def _gaussians(task: WarpTask) -> Warp:
    """Fit a Gaussian on each landmark, together through all of them; they end by themselves."""
    from scipy.interpolate import RBFInterpolator

    width_px = GAUSSIAN_SPACINGS * task.spacing_px
    gaussians = RBFInterpolator(
        task.target_px,
        task.displacement_px,
        kernel="gaussian",
        epsilon=1.0 / width_px,
        degree=-1,
    )
    return _Interpolated(gaussians)


THIN_PLATE: Final = Method(
    "thin-plate", Text("Thin-plate spline"), "[6]", "scipy", _thin_plate, needs="scipy"
)
RADIAL: Final = Method(
    "radial",
    Text("Radial basis functions, Gaussian"),
    "[5]",
    "scipy",
    _gaussians,
    needs="scipy",
)
