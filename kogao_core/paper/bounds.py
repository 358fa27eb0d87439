"""Bounds of a spline in each cell, by the convex hull of its Bezier points.

Cell [0, 0] is the first that a control point reaches: phi of shape (J, I, 2) reaches
(J + 3, I + 3) cells.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.paper.basis import ORDER


def bezier(phi: Array) -> Array:
    """Return the Bezier points of each cell, (J + 3, I + 3, 2, 4, 4).

    Cell row, cell column, component, points along y and along x.
    """
    # Points are the outer axes in memory: bounds over all cells are then four times as fast.
    points = bezier_along(bezier_along(phi).transpose(2, 0, 1, 3)).transpose(2, 0, 4, 3, 1)
    return np.ascontiguousarray(points).transpose(3, 4, 2, 0, 1)


def bezier_along(phi: Array) -> Array:
    """Convert B-spline control points along the first axis to Bezier points, for tight bounds.

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


def longest(points: Array) -> Array:
    """Return an upper bound of the length in each cell, (J + 3, I + 3), from `bezier`."""
    x, y = points[:, :, 0], points[:, :, 1]
    return np.asarray(np.sqrt((x * x + y * y).max(axis=(2, 3))))


def shortest(points: Array) -> Array:
    """Return a lower bound of the length in each cell, (J + 3, I + 3); 0 if directions differ."""
    # Project the Bezier points on their mean direction. The least projection bounds every
    # convex combination, and so every displacement in the cell.
    x, y = np.moveaxis(points.reshape(*points.shape[:2], 2, ORDER**2), 2, 0)
    toward_x, toward_y = x.mean(axis=2), y.mean(axis=2)
    length = np.maximum(np.hypot(toward_x, toward_y), 1e-12)
    toward_x, toward_y = (toward_x / length)[..., None], (toward_y / length)[..., None]
    return np.asarray(np.maximum(0.0, (x * toward_x + y * toward_y).min(axis=2)))


def slopes(points: Array, spacing_px: float) -> tuple[Array, Array]:
    """Return Bezier points of the derivatives along x and y in each cell, per px."""
    per_px = (ORDER - 1) / spacing_px
    return per_px * np.diff(points, axis=4), per_px * np.diff(points, axis=3)


def steepest(along_x: Array, along_y: Array) -> Array:
    """Return an upper bound of the slope in each cell, (J + 3, I + 3), from `slopes`."""
    most_x, most_y = (np.abs(slope).max(axis=(3, 4)) for slope in (along_x, along_y))
    return np.asarray(np.sqrt((most_x**2 + most_y**2).sum(axis=2)))


def reached(phi: Array) -> npt.NDArray[np.bool_]:
    """Return the cells that a non-zero control point reaches, (J + 3, I + 3); section 4.1."""
    rows, columns = phi.shape[:2]
    stored = np.zeros((rows + 2 * ORDER - 2, columns + 2 * ORDER - 2), bool)
    stored[ORDER - 1 : 1 - ORDER, ORDER - 1 : 1 - ORDER] = phi.any(axis=2)
    along = stored[:-3] | stored[1:-2] | stored[2:-1] | stored[3:]
    return np.asarray(along[:, :-3] | along[:, 1:-2] | along[:, 2:-1] | along[:, 3:])
