"""Uniform cubic B-splines as Bezier curves, whose control points bound them tightly."""

from __future__ import annotations

from math import comb

import numpy as np

from kogao_core.geometry import Array


def cells_along(phi: Array, axis: int) -> Array:
    """Return the Bezier control points of every cell that a control point reaches.

    Parameters
    ----------
    phi : array
        B-spline control points, n of them along `axis`; those before and after are zero.
    axis : int
        The axis along which cells follow each other.

    Returns
    -------
    array
        Shape of `phi` with n + 3 cells along `axis`, and a new last axis of 4 control points.

    Examples
    --------
    >>> import numpy as np
    >>> from kogao_core.bezier import cells_along
    >>> cells_along(np.ones(5), 0).shape
    (8, 4)
    """
    moved = np.moveaxis(phi, axis, 0)
    p = np.zeros((len(moved) + 6, *moved.shape[1:]))
    p[3:-3] = moved
    thirds = (2.0 * p[:-1] + p[1:]) / 3.0, (p[:-1] + 2.0 * p[1:]) / 3.0
    joints = (thirds[1][:-1] + thirds[0][1:]) / 2.0
    points = [joints[:-1], thirds[0][1:-1], thirds[1][1:-1], joints[1:]]
    return np.moveaxis(np.stack(points, axis=-1), 0, axis)


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
    >>> from kogao_core.bezier import halves
    >>> left, right = halves(3)
    >>> (left @ [0.0, 1.0, 0.0]).tolist()
    [0.0, 0.5, 0.5]
    """
    left = np.array([[comb(j, i) / 2.0**j for i in range(count)] for j in range(count)])
    return left, np.asarray(left[::-1, ::-1])
