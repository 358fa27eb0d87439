"""Radial functions through scattered landmarks, by scipy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from kogao_core.experiments.methods.base import Warp, WarpTask
from kogao_core.geometry import Array
from kogao_core.language import Text

# Gaussians this wide, in landmark spacings, blend along the outline and end soon beside it.
GAUSSIAN_SPACINGS: Final = 1.5


class _Interpolated(Warp):
    def __init__(self, interpolator: Any) -> None:
        self._interpolator = interpolator

    def displacement(self, points_px: Array) -> Array:
        return np.asarray(self._interpolator(points_px), np.float64)


@dataclass(frozen=True, slots=True)
class ThinPlate:
    """The surface that bends least through all landmarks; it never ends, so corners are pinned."""

    name: str = "thin-plate"
    title: str = Text("Thin-plate spline")
    reference: str = "[6]"
    library: str = "scipy"
    needs: str = "scipy"

    def fit(self, task: WarpTask) -> Warp:
        """Fit a thin-plate spline to the displacement."""
        from scipy.interpolate import RBFInterpolator

        target, displacement = task.anchored()
        return _Interpolated(RBFInterpolator(target, displacement, kernel="thin_plate_spline"))


@dataclass(frozen=True, slots=True)
class Radial:
    """A Gaussian on each landmark, together through all of them; ends by itself."""

    name: str = "radial"
    title: str = Text("Radial basis functions, Gaussian")
    reference: str = "[5]"
    library: str = "scipy"
    needs: str = "scipy"

    def fit(self, task: WarpTask) -> Warp:
        """Fit Gaussians to the displacement."""
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
