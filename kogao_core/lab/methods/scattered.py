"""Interpolation between landmarks: radial functions by scipy, triangles by scikit-image."""

from __future__ import annotations

from typing import Any, ClassVar, Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array, Image
from kogao_core.base.language import Text
from kogao_core.lab.methods.base import Method, Warp, WarpTask, interpolated

# Gaussians this wide, in landmark spacings, blend along the outline and end soon beside it.
GAUSSIAN_SPACINGS: Final = 1.5


class _Radial(Warp):
    def __init__(self, interpolator: Any) -> None:
        self._interpolator = interpolator

    def at(self, points_px: Array) -> Array:
        return np.asarray(self._interpolator(points_px), np.float64)


def _thin_plate(task: WarpTask) -> Warp:
    """Fit the surface that bends least through all points; it never ends: the edges stay."""
    target, displacement = task.anchored()
    return _radial(target, displacement, kernel="thin_plate_spline")


def _gaussians(task: WarpTask) -> Warp:
    """Fit a Gaussian on each landmark, together through all of them; they end by themselves."""
    epsilon = 1.0 / (GAUSSIAN_SPACINGS * task.spacing_px)
    target, displacement = task.anchored(edges=False)
    return _radial(target, displacement, kernel="gaussian", epsilon=epsilon, degree=-1)


def _radial(target_px: Array, displacement_px: Array, **shape: Any) -> Warp:
    from scipy.interpolate import RBFInterpolator  # an extra

    return _Radial(RBFInterpolator(target_px, displacement_px, **shape))


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
    """Map each of the Delaunay triangles of all points affinely."""
    from skimage.transform import PiecewiseAffineTransform  # an extra

    target, displacement = task.anchored()
    return _Piecewise(PiecewiseAffineTransform.from_estimate(target, target + displacement))


class _Triangles(_Piecewise):
    """The same, run triangle by triangle by OpenCV."""

    def __init__(self, transform: Any, target_px: Array, source_px: Array) -> None:
        super().__init__(transform)
        self._target, self._source = (p.astype(np.float32) for p in (target_px, source_px))

    def pixels(self, photo: Image, moved: Array | None = None) -> Image:
        from scipy.spatial import Delaunay  # an extra

        if moved is not None:
            moved[:] = self.on_grid(*(np.arange(n) for n in photo.shape[1::-1]))
        result = photo.copy()
        for corners in Delaunay(self._target).simplices:
            target, source = self._target[corners], self._source[corners]
            left, top, width, height = cv2.boundingRect(target)
            mask = np.zeros((height, width), np.uint8)
            cv2.fillConvexPoly(mask, np.round(target - (left, top)).astype(np.int32), 1)
            affine = cv2.getAffineTransform(target - np.array((left, top), np.float32), source)
            flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            part = cv2.warpAffine(
                photo, affine, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE
            )
            box = (slice(top, top + height), slice(left, left + width))
            cv2.copyTo(part, mask, result[box])
        return result


def _triangle_by_triangle(task: WarpTask) -> Warp:
    from skimage.transform import PiecewiseAffineTransform  # an extra

    target, displacement = task.anchored()
    source = target + displacement
    return _Triangles(PiecewiseAffineTransform.from_estimate(target, source), target, source)


THIN_PLATE: Final = Method(
    "thin-plate", Text("Thin-plate spline"), "[6]", "scipy", _thin_plate, needs="scipy",
    quick=interpolated(_thin_plate),
)  # fmt: skip
RADIAL: Final = Method(
    "radial",
    Text("Radial basis functions, Gaussian"),
    "[5]",
    "scipy",
    _gaussians,
    needs="scipy",
    quick=interpolated(_gaussians),
)
PIECEWISE_AFFINE: Final = Method(
    "mesh", Text("Piecewise-affine mesh"), "[4]", "scikit-image", _piecewise_affine,
    needs="skimage",
    quick=_triangle_by_triangle,
)  # fmt: skip
