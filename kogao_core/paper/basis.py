"""Eq. (2): the uniform cubic B-spline basis and its derivative."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array

ORDER = 4  # control points per axis that reach a point: cubic


def basis(s: npt.ArrayLike) -> Array:
    """Return B_0..B_3 of eq. (2) at `s` in [0, 1), shape (..., 4). Result: they sum to 1.

    >>> basis(0.0).round(3)
    array([0.167, 0.667, 0.167, 0.   ])
    """
    s = np.asarray(s, np.float64)
    r = 1.0 - s
    weights: Array = np.empty((*s.shape, ORDER))
    weights[..., 0] = r * r * r
    weights[..., 1] = (3 * s - 6) * s * s + 4
    weights[..., 2] = (3 * r - 6) * r * r + 4  # as printed: B_2(s) = B_1(1 - s)
    weights[..., 3] = s * s * s
    weights /= 6.0
    return weights


def basis_slope(s: npt.ArrayLike) -> Array:
    """Return dB_0/ds..dB_3/ds of eq. (2), shape (..., 4). Result: they sum to 0."""
    s = np.asarray(s, np.float64)
    slopes: Array = np.empty((*s.shape, ORDER))
    slopes[..., 0] = -((1.0 - s) ** 2)
    slopes[..., 1] = 3 * s**2 - 4 * s
    slopes[..., 2] = -3 * s**2 + 2 * s + 1
    slopes[..., 3] = s**2
    slopes /= 2.0
    return slopes
