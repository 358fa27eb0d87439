"""Triangles between landmarks, by scikit-image."""

from __future__ import annotations

from typing import Any, ClassVar, Final

import numpy as np

from kogao_core.experiments.methods.base import Method, Warp, WarpTask
from kogao_core.geometry import Array
from kogao_core.language import Text


class _Piecewise(Warp):
    strip_px: ClassVar[int] = 2**16  # each asks every triangle

    def __init__(self, transform: Any) -> None:
        self._transform = transform

    def displacement(self, points_px: Array) -> Array:
        shown = np.asarray(self._transform(points_px), np.float64)
        # Rounding puts points of the rim outside all triangles; both coordinates say -1 there.
        outside = (shown == -1.0).all(axis=1)
        return np.where(outside[:, None], 0.0, shown - points_px)


def _fit(task: WarpTask) -> Warp:
    """Map each of the Delaunay triangles of landmarks and corners affinely."""
    from skimage.transform import PiecewiseAffineTransform

    target, displacement = task.anchored()
    return _Piecewise(PiecewiseAffineTransform.from_estimate(target, target + displacement))


PIECEWISE_AFFINE: Final = Method(
    "mesh", Text("Piecewise-affine mesh"), "[4]", "scikit-image", _fit, needs="skimage"
)
