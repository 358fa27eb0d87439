"""Uniform cubic B-splines as Bezier curves, whose control points bound them tightly."""

from __future__ import annotations

from math import comb

import numpy as np

from kogao_core.base.geometry import Array


def cells_along(phi: Array) -> Array:
    """Return the Bezier control points of every cell that a control point reaches.

    `phi` (n, ...). Result (4, n + 3, ...): the four points of each cell.
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

    `left`, `right` (count, count): to be multiplied with the control points.
    """
    left = np.array([[comb(j, i) / 2.0**j for i in range(count)] for j in range(count)])
    return left, np.asarray(left[::-1, ::-1])
