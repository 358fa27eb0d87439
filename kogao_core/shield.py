"""A soft mask round hard edges: the displacement fades out towards a stroke, and is zero on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kogao_core.geometry import Array
from kogao_core.protection import Protection, Stroke


@dataclass(frozen=True, slots=True, eq=False)
class Shield:
    """Everything that has a feather: 0 on the strokes, 1 from a feather's width beside them.

    Parameters
    ----------
    strokes : tuple of Stroke
        Those with a feather.
    """

    strokes: tuple[Stroke, ...]

    @property
    def boxes_px(self) -> Array:
        """Rectangles (left, top, right, bottom) outside which each stroke changes nothing."""
        reach = np.array([s.radius_px + s.feather_px for s in self.strokes])[:, None]
        low = np.array([s.points_px.min(axis=0) for s in self.strokes]).reshape(-1, 2) - reach
        high = np.array([s.points_px.max(axis=0) for s in self.strokes]).reshape(-1, 2) + reach
        return np.hstack([low, high])

    def at(self, points_px: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the factor at points of shape (N, 2), shape (N,), and its slope per px, (N, 2)."""
        depth, slope = self._depth(np.asarray(points_px, np.float64))
        return _smoothstep(depth), (6.0 * depth * (1.0 - depth))[:, None] * slope

    def bounds(self, points_px: Array, radius_px: float) -> tuple[Array, Array]:
        """Bound the factor and its slope within `radius_px` of points of shape (N, 2).

        Returns
        -------
        factor, slope : arrays of shape (N,)
            No factor there is larger, no slope steeper (per px).
        """
        thinnest = min((stroke.feather_px for stroke in self.strokes), default=np.inf)
        depth, _ = self._depth(points_px)
        low = np.maximum(0.0, depth - radius_px / thinnest)
        high = np.minimum(1.0, depth + radius_px / thinnest)
        steepest = np.clip(0.5, low, high)  # of a smoothstep: half way
        return _smoothstep(high), 6.0 * steepest * (1.0 - steepest) / thinnest

    def _depth(self, points: Array) -> tuple[Array, Array]:
        """Return how far into the feather points lie, 0 on a stroke to 1, and its slope per px."""
        depth, slope = np.ones(len(points)), np.zeros((len(points), 2))
        for stroke, (left, top, right, bottom) in zip(self.strokes, self.boxes_px, strict=True):
            x, y = points.T
            near = np.flatnonzero((x > left) & (x < right) & (y > top) & (y < bottom))
            apart, unit = _distance(points[near], stroke.points_px)
            mine = np.maximum(0.0, (apart - stroke.radius_px) / stroke.feather_px)
            nearer = mine < depth[near]
            where = near[nearer]
            depth[where] = mine[nearer]
            slope[where] = unit[nearer] / stroke.feather_px
        return depth, slope

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the factor on the grid ``ys x xs``, shape (Y, X), and its slopes, (2, Y, X)."""
        xs, ys = np.asarray(xs_px, np.float64), np.asarray(ys_px, np.float64)
        factor, slope = np.ones((len(ys), len(xs))), np.zeros((2, len(ys), len(xs)))
        if not len(self.strokes):
            return factor, slope
        left, top = self.boxes_px[:, :2].min(axis=0)
        right, bottom = self.boxes_px[:, 2:].max(axis=0)
        columns = slice(*np.searchsorted(xs, [left, right]))
        rows = slice(*np.searchsorted(ys, [top, bottom]))
        grid = np.stack(np.meshgrid(xs[columns], ys[rows]), axis=-1)
        values, slopes = self.at(grid.reshape(-1, 2))
        factor[rows, columns] = values.reshape(grid.shape[:2])
        slope[:, rows, columns] = slopes.T.reshape(2, *grid.shape[:2])
        return factor, slope


NO_SHIELD = Shield(())


def shield_of(protection: Protection) -> Shield:
    """Return the shield of a photo's protection: its strokes that have a feather."""
    return Shield(tuple(stroke for stroke in protection.strokes if stroke.feather_px > 0.0))


def _smoothstep(t: Array) -> Array:
    return np.asarray(t * t * (3.0 - 2.0 * t))


def _distance(points: Array, line: Array) -> tuple[Array, Array]:
    """Return how far points are from a polyline, and the direction away from it."""
    nearest, away = np.full(len(points), np.inf), np.zeros((len(points), 2))
    ends = line[1:] if len(line) > 1 else line
    for start, end in zip(line[: len(ends)], ends, strict=True):
        along = end - start
        t = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        apart = points - start - t[:, None] * along
        length = np.sqrt((apart**2).sum(axis=1))
        nearer = length < nearest
        nearest[nearer], away[nearer] = length[nearer], apart[nearer]
    return nearest, away / np.maximum(nearest, 1e-12)[:, None]
