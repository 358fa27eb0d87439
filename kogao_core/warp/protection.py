"""What must not move, folded into the field: landmarks whose target is themselves.

The field stays one spline, so nothing ghosts or tears at the edge of a protected place. A hard edge
nearer to the face than the lattice can tell apart also gets a feather: `Falloff` fades the
displacement out towards it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array, arc_lengths, frozen, smoothstep
from kogao_core.base.language import Text
from kogao_core.warp.limits import MOST_SAMPLES, OutOfBounds

_LEAST_STEP_PX: Final = 0.25  # between the places where an eraser may cut a stroke


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A point, a line or a brush stroke that must not move."""

    points_px: Array  # (N, 2): corners of the line; a single one is a dot
    radius_px: float = 0.0  # half the width of the brush; 0 protects the line alone
    # Over this distance beside the stroke the displacement fades to exactly nothing on it; 0 only
    # asks the fit to leave the place alone.
    feather_px: float = 0.0

    def __post_init__(self) -> None:
        """Freeze the points and refuse broken strokes."""
        try:
            object.__setattr__(self, "points_px", frozen(self.points_px, (None, 2)))
        except ValueError as error:
            raise ValueError(Text("a stroke can't be used: {error}", error=error)) from None
        if not len(self.points_px):
            raise ValueError(Text("a stroke needs at least one point"))
        for name in ("radius_px", "feather_px"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(
                    Text(
                        "{name} must be 0 or more, got {value!r}",
                        name=name,
                        value=getattr(self, name),
                    )
                )

    def samples_px(
        self, step_px: float, low: npt.ArrayLike = -np.inf, high: npt.ArrayLike = np.inf
    ) -> Array:
        """Return points along the line and across its width, at most `step_px` apart, (M, 2).

        `low`, `high` (2,). Raises OutOfBounds.
        """
        line = _along(self.points_px, step_px)
        radius = self.radius_px
        low, high = (np.broadcast_to(np.asarray(end, np.float64), 2) for end in (low, high))
        line = line[((line >= low - radius) & (line <= high + radius)).all(axis=1)]
        if radius <= 0.0 or not len(line):
            return line
        _check_count(2.0 * radius / step_px)
        reach = int(np.ceil(radius / step_px))
        steps = np.linspace(-radius, radius, 2 * reach + 1)
        covered, count = [], 0
        for point in line:
            disc = _disc(steps, radius, low - point, high - point)
            covered.append(point + disc)
            count += len(disc)
            _check_count(count)
        near = np.concatenate(covered)
        # Discs of neighbouring samples overlap: one point in each quarter of a step is enough.
        _, first = np.unique(np.round(near / (step_px / 2.0)), axis=0, return_index=True)
        return np.asarray(near[np.sort(first)])


def _disc(steps: Array, radius: float, low: Array, high: Array) -> Array:
    """Return the points of the grid ``steps x steps`` in a disc and in a box, shape (M, 2)."""
    xs, ys = (steps[(steps >= low[axis]) & (steps <= high[axis])] for axis in (0, 1))
    _check_count(float(len(xs)) * len(ys))
    disc = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    return np.asarray(disc[np.hypot(disc[:, 0], disc[:, 1]) <= radius])


def _along(points: Array, step_px: float) -> Array:
    if len(points) == 1:
        return points
    length = float(arc_lengths(points)[-1])
    _check_count(length / step_px)
    count = max(2, int(np.ceil(length / step_px)) + 1)
    return _at(points, np.linspace(0.0, length, count))


def _check_count(samples: float) -> None:
    if not samples <= MOST_SAMPLES:
        raise OutOfBounds(
            Text(
                "a protected line takes more than {most_samples} samples at this "
                "lattice; make it narrower or shorter, or the lattice coarser (a "
                "larger R)",
                most_samples=MOST_SAMPLES,
            )
        )


def _without(stroke: Stroke, eraser: Stroke) -> list[Stroke]:
    reach = stroke.radius_px + eraser.radius_px
    step = max(_LEAST_STEP_PX, reach / 8.0)
    length = arc_lengths(stroke.points_px)
    at = np.linspace(0.0, length[-1], int(np.ceil(length[-1] / step)) + 1)
    kept = _distance(_at(stroke.points_px, at), eraser.points_px) > reach
    if kept.all():
        return [stroke]
    edges = np.flatnonzero(np.diff(np.pad(kept, 1).astype(np.int8)))
    return [
        dataclasses.replace(stroke, points_px=_part(stroke.points_px, at[first], at[end - 1]))
        for first, end in edges.reshape(-1, 2).tolist()
    ]


def _distance(points: Array, line: Array) -> Array:
    """Return how far points of shape (N, 2) are from a line, shape (N,)."""
    nearest = np.full(len(points), np.inf)
    ends = line[1:] if len(line) > 1 else line
    for start, end in zip(line[: len(ends)], ends, strict=True):
        along = end - start
        t = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        apart = points - start - t[:, None] * along
        nearest = np.minimum(nearest, np.hypot(apart[:, 0], apart[:, 1]))
    return nearest


def _at(line: Array, length: npt.ArrayLike) -> Array:
    """Return the points of a line at lengths along it, shape (N, 2)."""
    along = arc_lengths(line)
    columns = [np.interp(np.atleast_1d(length), along, line[:, axis]) for axis in (0, 1)]
    return np.column_stack(columns)


def _part(line: Array, start: float, end: float) -> Array:
    along = arc_lengths(line)
    ends = _at(line, [start, end] if end > start else start)
    return np.vstack([ends[:1], line[(along > start) & (along < end)], ends[1:]])


@dataclass(frozen=True, slots=True, eq=False)
class Protection:
    """All strokes of a photo.

    Parameters
    ----------
    strokes : tuple of Stroke
        In the order they were drawn.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> still = kogao.Protection().with_stroke([(120, 20), (120, 340)], radius_px=3)
    >>> still = still.with_stroke([(400, 100)], radius_px=20, feather_px=10)
    >>> len(still.strokes), len(still.erased([(400, 100)], radius_px=30).strokes)
    (2, 1)
    """

    strokes: tuple[Stroke, ...] = ()

    def samples_px(self, step_px: float, low: npt.ArrayLike, high: npt.ArrayLike) -> Array:
        """Return the samples of every stroke in a box; see `Stroke.samples_px`.

        Parameters
        ----------
        step_px : float
            How far samples are apart.
        low, high : array of shape (2,)
            Corners of the box (x, y), px.

        Returns
        -------
        array of shape (M, 2)
            Positions (x, y), px.
        """
        parts = [stroke.samples_px(step_px, low, high) for stroke in self.strokes]
        return np.concatenate([np.zeros((0, 2)), *parts])

    def away_px(self, points: Array) -> Array:
        """Return how far points are from the nearest stroke.

        Parameters
        ----------
        points : array of shape (N, 2)
            Positions (x, y), px.

        Returns
        -------
        array of shape (N,)
            Px, 0 or less on a stroke; infinite where there is none.

        Examples
        --------
        >>> import numpy as np
        >>> import kogao_core as kogao
        >>> line = kogao.Protection().with_stroke([(10, 20), (10, 40)], radius_px=2)
        >>> line.away_px(np.array([[15.0, 30.0], [10.0, 25.0]]))
        array([ 3., -2.])
        """
        away = np.full(len(points), np.inf)
        for stroke in self.strokes:
            away = np.minimum(away, _distance(points, stroke.points_px) - stroke.radius_px)
        return away

    def mapped(self, transform: Affine) -> Protection:
        """Return the strokes carried along by a transform of their image.

        Parameters
        ----------
        transform : Affine
            A similarity: turn, scale, mirror and shift.

        Returns
        -------
        Protection
            px of the new image.
        """
        scale = transform.scale
        strokes = (
            Stroke(transform(s.points_px), s.radius_px * scale, s.feather_px * scale)
            for s in self.strokes
        )
        return Protection(tuple(strokes))

    def with_stroke(
        self, points_px: npt.ArrayLike, radius_px: float = 0.0, feather_px: float = 0.0
    ) -> Protection:
        """Return the protection with one more stroke.

        Parameters
        ----------
        points_px : array of shape (N, 2)
            Corners of its line (x, y).
        radius_px : float
            Half its width; 0 is the line alone.
        feather_px : float
            Width over which the move comes back beside a hard edge; 0 is none.

        Returns
        -------
        Protection
            Of all strokes.
        """
        stroke = Stroke(np.asarray(points_px, np.float64), radius_px, feather_px)
        return dataclasses.replace(self, strokes=(*self.strokes, stroke))

    def erased(self, points_px: npt.ArrayLike, radius_px: float) -> Protection:
        """Return the protection without what an eraser drawn along `points_px` touches.

        A stroke loses the part of its line whose width would meet the eraser; what lies on either
        side of the gap stays, as strokes of their own.

        Parameters
        ----------
        points_px : array of shape (N, 2)
            Corners of the eraser's line (x, y).
        radius_px : float
            Half its width.

        Returns
        -------
        Protection
            What is left.
        """
        eraser = Stroke(np.asarray(points_px, np.float64), radius_px)
        parts = (part for stroke in self.strokes for part in _without(stroke, eraser))
        return Protection(tuple(parts))

    def to_dict(self) -> dict[str, Any]:
        """Return the strokes as plain JSON values."""
        strokes = [
            {"points": s.points_px.tolist(), "radius": s.radius_px, "feather": s.feather_px}
            for s in self.strokes
        ]
        return {"strokes": strokes}


NOTHING = Protection()


def away_px(points: Array, protection: Protection, others_px: Array) -> Array:
    """Return how far points (N, 2) are from what is protected, and from others (M, 2); (N,), px."""
    away = protection.away_px(points)
    if not len(others_px):
        return away
    apart = points[:, None] - others_px
    return np.asarray(np.minimum(away, np.hypot(apart[..., 0], apart[..., 1]).min(axis=1)))


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
