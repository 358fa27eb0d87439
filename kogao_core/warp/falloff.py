"""A soft mask round hard edges: the displacement fades out towards a stroke, and is zero on it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, smoothstep
from kogao_core.warp.protection import Protection, Stroke


@dataclass(frozen=True, slots=True, eq=False)
class Falloff:
    """Everything that has a feather: 0 on the strokes, 1 from a feather's width beside them."""

    strokes: tuple[Stroke, ...]  # those with a feather

    @property
    def boxes_px(self) -> Array:
        """Rectangles (left, top, right, bottom) outside which each stroke changes nothing."""
        reach = np.array([s.radius_px + s.feather_px for s in self.strokes])[:, None]
        low = np.array([s.points_px.min(axis=0) for s in self.strokes]).reshape(-1, 2) - reach
        high = np.array([s.points_px.max(axis=0) for s in self.strokes]).reshape(-1, 2) + reach
        return np.hstack([low, high])

    def at(self, points_px: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the factor and its slope at points.

        `factor` (N,): 0 to 1; `slope` (N, 2): its derivatives along x and y, per px.
        """
        depth, slope = self._depth(np.asarray(points_px, np.float64))
        return smoothstep(depth), (6.0 * depth * (1.0 - depth))[:, None] * slope

    def bounds(self, points_px: Array, radius_px: float) -> tuple[Array, Array]:
        """Bound the factor and its slope round points.

        `factor`, `slope` (N,): no factor there is larger, no slope steeper (per px).
        """
        thinnest = min((stroke.feather_px for stroke in self.strokes), default=np.inf)
        depth, _ = self._depth(points_px)
        low = np.maximum(0.0, depth - radius_px / thinnest)
        high = np.minimum(1.0, depth + radius_px / thinnest)
        steepest = np.clip(0.5, low, high)  # of a smoothstep: half way
        return smoothstep(high), 6.0 * steepest * (1.0 - steepest) / thinnest

    @property
    def _parts(self) -> Iterator[tuple[Stroke, Array, Array, Array]]:
        """Each straight part of a stroke: its ends, and the box beyond which it does nothing."""
        for stroke in self.strokes:
            reach, line = stroke.radius_px + stroke.feather_px, stroke.points_px
            ends = line[1:] if len(line) > 1 else line
            for start, end in zip(line[: len(ends)], ends, strict=True):
                low, high = np.minimum(start, end) - reach, np.maximum(start, end) + reach
                yield stroke, start, end, np.append(low, high)

    def _depth(self, points: Array) -> tuple[Array, Array]:
        """Return how far into the feather points lie, 0 on a stroke to 1, and its slope per px."""
        depth, slope = np.ones(len(points)), np.zeros((2, len(points)))
        x, y = points.T
        for stroke, start, end, (left, top, right, bottom) in self._parts:
            near = np.flatnonzero((x > left) & (x < right) & (y > top) & (y < bottom))
            if len(near):
                mine, rise = _into_feather(stroke, start, end, x[near], y[near])
                nearer = mine < depth[near]
                where = near[nearer]
                depth[where], slope[:, where] = mine[nearer], rise[:, nearer]
        return depth, slope.T

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the factor and its slopes on the grid ``ys x xs``.

        `xs_px`, `ys_px` (X,) and (Y,). `factor` (Y, X): 0 to 1; `slope` (2, Y, X): its derivatives
        along x and y, per px.
        """
        xs, ys = np.asarray(xs_px, np.float64), np.asarray(ys_px, np.float64)
        depth, slope = np.ones((len(ys), len(xs))), np.zeros((2, len(ys), len(xs)))
        for stroke, start, end, (left, top, right, bottom) in self._parts:
            columns = slice(*np.searchsorted(xs, [left, right]))
            rows = slice(*np.searchsorted(ys, [top, bottom]))
            if columns.start < columns.stop and rows.start < rows.stop:
                mine, rise = _into_feather(stroke, start, end, xs[columns], ys[rows, None])
                nearer = mine < depth[rows, columns]
                np.copyto(depth[rows, columns], mine, where=nearer)
                np.copyto(slope[:, rows, columns], rise, where=nearer)
        slope *= 6.0 * depth * (1.0 - depth)
        return smoothstep(depth), slope


NO_FALLOFF = Falloff(())


def falloff_of(protection: Protection) -> Falloff:
    """Return the falloff of a photo's protection: its strokes that have a feather.

    Result: without a feather one that is 1 everywhere.
    """
    return Falloff(tuple(stroke for stroke in protection.strokes if stroke.feather_px > 0.0))


def _into_feather(
    stroke: Stroke, start: Array, end: Array, x: Array, y: Array
) -> tuple[Array, Array]:
    """Return the depth, 0 on the part of a stroke from `start` to `end`, and its slope per px."""
    along_x, along_y = (end - start).tolist()
    from_x, from_y = x - start[0], y - start[1]
    length = max(along_x**2 + along_y**2, 1e-12)
    t = np.clip((from_x * along_x + from_y * along_y) / length, 0.0, 1.0)
    apart_x, apart_y = from_x - t * along_x, from_y - t * along_y
    apart = np.sqrt(apart_x**2 + apart_y**2)
    depth = np.maximum(0.0, (apart - stroke.radius_px) / stroke.feather_px)
    per_px = np.maximum(apart, 1e-12) * stroke.feather_px
    return depth, np.stack([apart_x / per_px, apart_y / per_px])
