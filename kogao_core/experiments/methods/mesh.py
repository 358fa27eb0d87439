"""Triangles between landmarks, by scikit-image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from kogao_core.experiments.methods.base import Warp, WarpTask
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


@dataclass(frozen=True, slots=True)
class PiecewiseAffine:
    """Delaunay triangles of landmarks and corners, each mapped affinely."""

    name: str = "mesh"
    title: str = Text("Piecewise-affine mesh")
    reference: str = "[4]"
    library: str = "scikit-image"
    needs: str = "skimage"

    def fit(self, task: WarpTask) -> Warp:
        """Triangulate the targets and find each triangle's map."""
        from skimage.transform import PiecewiseAffineTransform

        target, displacement = task.anchored()
        return _Piecewise(PiecewiseAffineTransform.from_estimate(target, target + displacement))
