"""Protected places: the displacement fades to zero on every stroke.

The fit does not know about protection. Afterwards a displacement d becomes ``d S(u)``, where S is a
smoothstep and ``u = r / (WIDTH |d|)``, r being the distance to the stroke. The fade is therefore as
wide as the displacement there needs. The displacement is unchanged farther away.

Several strokes: ``u^-6 = sum over strokes of max(0, u_k^-6 - CUTOFF^-6)``. This soft minimum has no
kink halfway between two strokes, and a distant stroke has no effect. `mask` describes masks.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array, arc_lengths, frozen, smoothstep
from kogao_core.base.language import BadValue
from kogao_core.field.mask import STEPS, Mask

_LEAST_STEP_PX: Final = 0.25  # between the places where an eraser may cut a stroke
_MOST_PLACES: Final = 20_000  # of `sampled`, beside one for each stroke
# The fade is this many times as wide as the displacement is long.
WIDTH: Final = 4.0
# A stroke has no effect where its u is at least this.
_CUTOFF: Final = 1.5
_LEFT_OUT: Final = _CUTOFF**-6
# Values of u at which `steepest` evaluates its bound.
_U: Final = np.linspace(0.0, 1.0, 41)

Strokes = Sequence["Stroke | Mask"]


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A point, a line or a brush stroke that must not move."""

    points_px: Array  # (N, 2): corners of the line; a single one is a dot
    radius_px: float = 0.0  # half the width of the brush; 0 protects the line alone

    def __post_init__(self) -> None:
        """Freeze the points and refuse broken strokes."""
        try:
            object.__setattr__(self, "points_px", frozen(self.points_px, (None, 2)))
        except ValueError as error:
            raise BadValue("a stroke can't be used: {error}", error=error) from None
        if not len(self.points_px):
            raise BadValue("a stroke needs at least one point")
        if not 0.0 <= self.radius_px < np.inf:
            raise BadValue(
                "{name} must be 0 or more, got {value!r}", name="radius_px", value=self.radius_px
            )

    @property
    def key(self) -> bytes:
        """Bytes that differ between strokes with different effect."""
        return repr(self.radius_px).encode() + self.points_px.tobytes()

    def mapped(self, transform: Affine) -> Stroke:
        """Return the stroke for a transformed photo (a similarity)."""
        return Stroke(transform(self.points_px), self.radius_px * transform.scale)


def lines_of(strokes: Strokes) -> list[Stroke]:
    """Return the drawn strokes, and the outlines of masks."""
    lines = list[Stroke]()
    for one in strokes:
        lines += map(Stroke, one.outlines_px) if isinstance(one, Mask) else [one]
    return lines


def _without(stroke: Stroke | Mask, eraser: Stroke) -> Strokes:
    """Return the parts of a stroke that an eraser leaves."""
    if isinstance(stroke, Mask):
        rest = stroke.erased(eraser.points_px, eraser.radius_px)
        return [] if rest is None else [rest]
    reach = stroke.radius_px + eraser.radius_px
    step = max(_LEAST_STEP_PX, reach / 8.0)
    length = arc_lengths(stroke.points_px)
    at = np.linspace(0.0, length[-1], int(np.ceil(length[-1] / step)) + 1)
    kept = distance_px(_at(stroke.points_px, at), eraser.points_px) > reach
    if kept.all():
        return [stroke]
    edges = np.flatnonzero(np.diff(np.pad(kept, 1).astype(np.int8)))
    return [
        dataclasses.replace(stroke, points_px=_part(stroke.points_px, at[first], at[end - 1]))
        for first, end in edges.reshape(-1, 2).tolist()
    ]


def distance_px(points: Array, line: Array) -> Array:
    """Return the distance of points (N, 2) from a line, shape (N,), px."""
    x, y = points.T
    return np.asarray(np.min([_apart(x, y, *ends)[0] for ends in _segments(line)], axis=0))


def _segments(line: Array) -> Iterator[tuple[Array, Array]]:
    """Yield both ends of each straight segment of a line; a dot is one segment."""
    ends = line[1:] if len(line) > 1 else line
    return zip(line[: len(ends)], ends, strict=True)


def _apart(x: Array, y: Array, start: Array, end: Array) -> tuple[Array, Array, Array]:
    """Return the distance from a segment, and the vector from its nearest point (x, y)."""
    along_x, along_y = (end - start).tolist()
    from_x, from_y = x - start[0], y - start[1]
    length = max(along_x**2 + along_y**2, 1e-12)
    t = np.clip((from_x * along_x + from_y * along_y) / length, 0.0, 1.0)
    apart_x, apart_y = from_x - t * along_x, from_y - t * along_y
    return np.sqrt(apart_x**2 + apart_y**2), apart_x, apart_y


def _at(line: Array, length: npt.ArrayLike) -> Array:
    """Return the points of a line at lengths along it, shape (N, 2)."""
    along = arc_lengths(line)
    columns = [np.interp(np.atleast_1d(length), along, line[:, axis]) for axis in (0, 1)]
    return np.column_stack(columns)


def sampled(strokes: Strokes, step_px: float) -> Array:
    """Return places along strokes, the length each stands for and its radius, (N, 4), px."""
    lines = lines_of(strokes)
    lengths = [float(arc_lengths(stroke.points_px)[-1]) for stroke in lines]
    step_px, parts = max(step_px, sum(lengths) / _MOST_PLACES), [np.zeros((0, 4))]
    for stroke, length in zip(lines, lengths, strict=True):
        count = max(1, int(np.ceil(length / step_px)))
        places = _at(stroke.points_px, (np.arange(count) + 0.5) / count * length)
        # A dot is as long as wide.
        each = (length + 2.0 * stroke.radius_px) / count, stroke.radius_px
        parts.append(np.column_stack([places, np.tile(each, (count, 1))]))
    return np.concatenate(parts)


def _part(line: Array, start: float, end: float) -> Array:
    """Return the corners of a line from one length along it to another."""
    along = arc_lengths(line)
    ends = _at(line, [start, end] if end > start else start)
    return np.vstack([ends[:1], line[(along > start) & (along < end)], ends[1:]])


@dataclass(frozen=True, slots=True, eq=False)
class Protection:
    """Strokes over areas of a photo that must not move.

    Parameters
    ----------
    strokes : tuple of Stroke or Mask
        In drawing order.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> still = kogao.Protection().with_stroke([(120, 20), (120, 340)], radius_px=3)
    >>> still = still.with_stroke([(400, 100)], radius_px=20)
    >>> len(still.strokes), len(still.erased([(400, 100)], radius_px=30).strokes)
    (2, 1)
    """

    strokes: tuple[Stroke | Mask, ...] = ()

    @property
    def drawn(self) -> list[Stroke]:
        """The strokes, without masks."""
        return [one for one in self.strokes if isinstance(one, Stroke)]

    @property
    def masks(self) -> list[Mask]:
        """The masks."""
        return [one for one in self.strokes if isinstance(one, Mask)]

    def mapped(self, transform: Affine) -> Protection:
        """Return the strokes in the coordinates of a transformed image.

        Parameters
        ----------
        transform : Affine
            From old to new px; a similarity: rotation, scale, mirroring and shift.
        """
        return Protection(tuple(stroke.mapped(transform) for stroke in self.strokes))

    def with_stroke(self, points_px: npt.ArrayLike, radius_px: float = 0.0) -> Protection:
        """Return the protection with one more stroke.

        Parameters
        ----------
        points_px : array of shape (N, 2)
            Points of the stroke (x, y), px.
        radius_px : float
            Half the width of the stroke, px; 0 is a line without width.
        """
        stroke = Stroke(np.asarray(points_px, np.float64), radius_px)
        return dataclasses.replace(self, strokes=(*self.strokes, stroke))

    def with_mask(self, mask: Mask) -> Protection:
        """Return the protection with one more mask.

        Parameters
        ----------
        mask : Mask
            Of a photo of the same size.

        Returns
        -------
        Protection
            A mask without a protected pixel adds nothing.
        """
        return Protection((*self.strokes, mask)) if mask.steps.any() else self

    def erased(self, points_px: npt.ArrayLike, radius_px: float) -> Protection:
        """Return the protection without the parts that an eraser touches.

        The part of a stroke touched by the eraser is removed. The remaining parts become separate
        strokes.

        Parameters
        ----------
        points_px : array of shape (N, 2)
            Points of the eraser's path (x, y), px.
        radius_px : float
            Half the width of the eraser, px.
        """
        eraser = Stroke(np.asarray(points_px, np.float64), radius_px)
        parts = (part for stroke in self.strokes for part in _without(stroke, eraser))
        return Protection(tuple(parts))

    def replaced(self, old: Stroke, new: Stroke) -> Protection:
        """Return the protection with another stroke instead of one of its strokes.

        Parameters
        ----------
        old : Stroke
            One of `strokes`.
        new : Stroke
            The stroke in its place.
        """
        return Protection(tuple(new if one is old else one for one in self.strokes))

    def to_dict(self) -> dict[str, Any]:
        """Return the strokes as plain JSON values."""
        strokes = [{"points": s.points_px.tolist(), "radius": s.radius_px} for s in self.drawn]
        return {"strokes": strokes}


NOTHING = Protection()


def slopes_on_grid(
    strokes: Strokes,
    xs_px: npt.ArrayLike,
    ys_px: npt.ArrayLike,
    displacement_px: Array,
    along_x: Array,
    along_y: Array,
) -> tuple[Array, Array]:
    """Return the derivatives of the faded displacement on the grid ``ys x xs``.

    `displacement_px`, `along_x`, `along_y` (2, Y, X): the unfaded displacement and its
    derivatives. Result: as the last two.
    """
    x, y = axes(xs_px, ys_px)
    unfaded = displacement_px, along_x, along_y
    found = [_slopes(strokes, x, y, step, *unfaded) for step in _steps(strokes)]
    along_x, along_y = np.mean(found, axis=0) if len(found) > 1 else found[0]
    return along_x, along_y


def _slopes(
    strokes: Strokes, x: Array, y: Array, step: int, displacement_px: Array, *along: Array
) -> tuple[Array, Array]:
    """Return the result of `slopes_on_grid` for one step of the masks."""
    length = np.hypot(*displacement_px)
    total, rise = np.zeros_like(length), np.zeros((4, *length.shape))
    for at, power, apart, way in _near(strokes, x, y, length, step, sloped=True):
        active = np.where((power > _LEFT_OUT) & (apart > 0.0), power, 0.0)
        total[at] += np.maximum(power - _LEFT_OUT, 0.0)
        rise[0][at] += active
        for axis in (0, 1):
            rise[1 + axis][at] += active / np.maximum(apart, 1e-12) * way[axis]
    u = _soft_minimum(total)
    t = np.clip(u, 0.0, 1.0)
    # dS = S' u^7 (sum of u_k^-6 (grad r_k / r_k) - (sum of u_k^-6) grad |d| / |d|)
    steep = np.where(total < np.inf, 6.0 * t * (1.0 - t) * t**7, 0.0)
    share = smoothstep(t)
    unit = displacement_px / np.maximum(length, 1e-12)
    slopes = []
    for axis, slope in enumerate(along):
        grown = (unit * slope).sum(axis=0) / np.maximum(length, 1e-12)
        slopes.append(
            share * slope + displacement_px * (steep * (rise[1 + axis] - rise[0] * grown))
        )
    return slopes[0], slopes[1]


def slope_bound(
    strokes: Strokes, centers_px: Array, radius_px: float, most_px: Array, steepest: Array
) -> Array:
    """Bound the slope of the faded displacement in cells, shape (N,).

    `centers_px` (N, 2), `radius_px`: of circles round the cells. `most_px`, `steepest` (N,):
    bounds of the displacement and of its slope. Result: 0 in cells without a fade; the field
    does not fold where the result is below 1.
    """
    near = np.zeros(len(centers_px))
    reach = _CUTOFF * WIDTH * most_px + radius_px
    for stroke in strokes:
        if isinstance(stroke, Mask):
            near += stroke.distance(centers_px[:, 0], centers_px[:, 1], 1) < reach
        else:
            near += distance_px(centers_px, stroke.points_px) - stroke.radius_px < reach
    at = np.flatnonzero(near)
    result = np.zeros(len(centers_px))
    # The derivative is A D + d grad(S)'. No direction of A stretches by more than `stretch`.
    share, rise, left_out = smoothstep(_U), 6.0 * _U * (1.0 - _U), _LEFT_OUT * _U**6
    several = 1.0 + near[at, None] * left_out
    stretch = np.maximum(share, np.abs(share - _U * rise * several))
    across = rise * several * (1.0 + left_out) ** (1.0 / 6.0) / WIDTH
    result[at] = (stretch * steepest[at, None] + across).max(axis=1, initial=0.0)
    return result


def share(strokes: Strokes, x: Array, y: Array, displacement_px: npt.NDArray[Any]) -> Array:
    """Return the share of displacements (2, ...) that protection leaves, 0 to 1.

    `x`, `y`: of points, (N,), or the columns and rows of a grid (`axes`).
    """
    length, shares = np.sqrt(np.square(displacement_px).sum(axis=0)), []
    for step in _steps(strokes):
        total: Array = np.zeros(length.shape)
        for at, power, _, _ in _near(strokes, x, y, length, step):
            total[at] += np.maximum(power - _LEFT_OUT, 0.0)
        shares.append(smoothstep(_soft_minimum(total)))
    return np.asarray(np.mean(shares, axis=0)) if len(shares) > 1 else shares[0]


def _steps(strokes: Strokes) -> Sequence[int]:
    """Return the steps of grey that differ in at least one of the masks."""
    soft = (one.sets for one in strokes if isinstance(one, Mask) and len(one.sets) > 1)
    return next(soft, (STEPS,))


def _near(
    strokes: Strokes,
    x: Array,
    y: Array,
    length: npt.NDArray[Any],
    step: int,
    *,
    sloped: bool = False,
) -> Iterator[tuple[Any, Array, Array, tuple[Array | float, Array | float]]]:
    """Yield for each stroke the index of places near it, u^-6, distance and its gradient.

    `step`: of the grey of masks. Without `sloped`, masks have the gradient 0.
    """
    reach = _CUTOFF * WIDTH * float(length.max(initial=0.0))
    if reach <= 0.0:
        return
    for stroke in strokes:
        if isinstance(stroke, Mask):
            away = stroke.distance(x, y, step)
            if away.min(initial=np.inf) < reach:
                slope = stroke.slope(x, y, step) if sloped else (0.0, 0.0)
                yield ..., _power(length, away), away, slope
            continue
        line, around = stroke.points_px, stroke.radius_px + reach
        low, high = line.min(axis=0) - around, line.max(axis=0) + around
        at, inner_x, inner_y = _within(x, y, low, high)
        if not np.size(length[at]):
            continue
        apart = np.full(length[at].shape, np.inf)
        way = np.zeros_like(apart), np.zeros_like(apart)
        for start, end in _segments(line):
            low, high = np.minimum(start, end) - around, np.maximum(start, end) + around
            where, near_x, near_y = _within(inner_x, inner_y, low, high)
            mine, away_x, away_y = _apart(near_x, near_y, start, end)
            nearer = mine < apart[where]
            apart[where] = np.where(nearer, mine, apart[where])
            way[0][where] = np.where(nearer, away_x, way[0][where])
            way[1][where] = np.where(nearer, away_y, way[1][where])
        per_px = np.maximum(apart, 1e-12)
        away = np.maximum(apart - stroke.radius_px, 0.0)
        yield at, _power(length[at], away), away, (way[0] / per_px, way[1] / per_px)


def _power(length: npt.NDArray[Any], away: Array) -> Array:
    """Return u^-6 of displacements of a length at a distance from a stroke, px."""
    with np.errstate(divide="ignore"):
        squared = np.maximum(WIDTH * length, 1e-15) ** 2 / away**2
    return np.asarray(squared * squared * squared)


def _soft_minimum(total: Array) -> Array:
    """Return u of the sum of ``u_k^-6 - CUTOFF^-6``; infinite where the sum is 0."""
    with np.errstate(divide="ignore"):
        return np.asarray(total ** (-1.0 / 6.0))


def axes(xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> tuple[Array, Array]:
    """Return the columns (X,) and the rows (Y, 1) of a grid."""
    x, y = np.asarray(xs_px, np.float64), np.asarray(ys_px, np.float64)
    return x.ravel(), y.reshape(-1, 1)


def _within(x: Array, y: Array, low: Array, high: Array) -> tuple[Any, Array, Array]:
    """Return the index, x and y of the places in a rectangle.

    `x`, `y`: of points, (N,), or the columns and rows of a grid (`_axes`).
    """
    if x.ndim == y.ndim:
        at = np.flatnonzero((x > low[0]) & (x < high[0]) & (y > low[1]) & (y < high[1]))
        return at, x[at], y[at]
    columns = slice(*np.searchsorted(x, [low[0], high[0]]))
    rows = slice(*np.searchsorted(y[:, 0], [low[1], high[1]]))
    return (rows, columns), x[columns], y[rows]
