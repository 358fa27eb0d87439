"""Uniform cubic B-splines as Bezier curves, whose control points bound them tightly."""

from __future__ import annotations

from math import comb

import numpy as np

from kogao_core.base.geometry import Array


def cells_along(phi: Array) -> Array:
    """Return the Bezier control points of every cell that a control point reaches.

    Parameters
    ----------
    phi : array of shape (n, ...)
        B-spline control points; those before and after are zero.

    Returns
    -------
    array of shape (4, n + 3, ...)
        The four points of each cell.

    Examples
    --------
    >>> import numpy as np
    >>> from kogao_core.warp.bezier import cells_along
    >>> cells_along(np.ones(5)).shape
    (4, 8)
    """
    p = np.zeros((len(phi) + 6, *phi.shape[1:]))
    p[3:-3] = phi
    twice = 2.0 * p
    thirds = (twice[:-1] + p[1:]) / 3.0, (p[:-1] + twice[1:]) / 3.0
    joints = (thirds[1][:-1] + thirds[0][1:]) / 2.0
    points = np.empty((4, len(phi) + 3, *phi.shape[1:]))
    points[0], points[1] = joints[:-1], thirds[0][1:-1]
    points[2], points[3] = thirds[1][1:-1], joints[1:]
    return points


def halves(count: int) -> tuple[Array, Array]:
    """Return de Casteljau's matrices from `count` Bezier points to those of either half.

    Parameters
    ----------
    count : int
        Control points of the curve: its degree plus one.

    Returns
    -------
    left, right : array of shape (count, count)
        To be multiplied with the control points.

    Examples
    --------
    >>> from kogao_core.warp.bezier import halves
    >>> left, right = halves(3)
    >>> (left @ [0.0, 1.0, 0.0]).tolist()
    [0.0, 0.5, 0.5]
    """
    left = np.array([[comb(j, i) / 2.0**j for i in range(count)] for j in range(count)])
    return left, np.asarray(left[::-1, ::-1])
