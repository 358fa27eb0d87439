"""Interpolation between landmarks: radial functions by scipy, triangles by scikit-image."""

from __future__ import annotations

from typing import Any, ClassVar, Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.base.language import Text
from kogao_core.lab.methods.base import Method, Warp, WarpTask

# Gaussians this wide, in landmark spacings, blend along the outline and end soon beside it.
GAUSSIAN_SPACINGS: Final = 1.5


class _Interpolated(Warp):
    def __init__(self, interpolator: Any) -> None:
        self._interpolator = interpolator

    def at(self, points_px: Array) -> Array:
        return np.asarray(self._interpolator(points_px), np.float64)


def _thin_plate(task: WarpTask) -> Warp:
    """Fit the surface that bends least through all landmarks; it never ends: corners are pinned."""
    target, displacement = task.anchored()
    return _radial(target, displacement, kernel="thin_plate_spline")


def _gaussians(task: WarpTask) -> Warp:
    """Fit a Gaussian on each landmark, together through all of them; they end by themselves."""
    epsilon = 1.0 / (GAUSSIAN_SPACINGS * task.spacing_px)
    return _radial(
        task.target_px, task.displacement_px, kernel="gaussian", epsilon=epsilon, degree=-1
    )


def _radial(target_px: Array, displacement_px: Array, **shape: Any) -> Warp:
    from scipy.interpolate import RBFInterpolator  # an extra

    return _Interpolated(RBFInterpolator(target_px, displacement_px, **shape))


class _Piecewise(Warp):
    strip_px: ClassVar[int] = 2**16  # each asks every triangle

    def __init__(self, transform: Any) -> None:
        self._transform = transform

    def at(self, points_px: Array) -> Array:
        shown = np.asarray(self._transform(points_px), np.float64)
        # Rounding puts points of the rim outside all triangles; both coordinates say -1 there.
        outside = (shown == -1.0).all(axis=1)
        return np.where(outside[:, None], 0.0, shown - points_px)


def _piecewise_affine(task: WarpTask) -> Warp:
    """Map each of the Delaunay triangles of landmarks and corners affinely."""
    from skimage.transform import PiecewiseAffineTransform  # an extra

    target, displacement = task.anchored()
    return _Piecewise(PiecewiseAffineTransform.from_estimate(target, target + displacement))


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
PIECEWISE_AFFINE: Final = Method(
    "mesh", Text("Piecewise-affine mesh"), "[4]", "scikit-image", _piecewise_affine, needs="skimage"
)
