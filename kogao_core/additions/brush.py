"""Push and restore by a round brush: more control points of the same field, finer than a face's.

A push adds the displacement that drags along what lies under the brush; a restore takes away a
share of all displacements there are before it. Both stay sums of cubic B-splines, so there is one
field, one resampling and one proof.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Final, Literal, get_args

import numpy as np
import numpy.typing as npt

from kogao_core.additions.edge import zero_on_edges
from kogao_core.additions.guard import limited_stroke
from kogao_core.base.geometry import Affine, Array, Box, frozen, smoothstep
from kogao_core.base.language import BadValue
from kogao_core.field.field import Field
from kogao_core.field.one_to_one import fade_is_safe
from kogao_core.paper.lattice import MIN_SPACING_PX, Grid, Lattice, meet

BrushKind = Literal["push", "restore"]
_SPACINGS: Final = 4.0  # lattice spacings in a brush's radius; larger: finer strokes, slower
_STEPS: Final = 8.0  # steps along a stroke in a brush's radius; larger: smoother strokes, slower
# A restore refines coarser lattices to this spacing, in spacings of its own lattice.
_COARSEST: Final = 1.5
LEAST_FALLOFF: Final = 0.4  # least softness of a brush; harder edges fall between control points
# Two lattices are joined if the result has at most this many times their control points.
_JOINED: Final = 1.5
# Lattices and shares after some strokes. While a stroke is drawn, earlier strokes don't change.
_Drawn = tuple[tuple[Lattice, ...], tuple[float, ...]]
_KEPT: dict[bytes, _Drawn] = {}
_MOST_KEPT: Final = 32  # cached results; larger values take more memory
_LOCK: Final = Lock()


@dataclass(frozen=True, slots=True, eq=False)
class BrushStroke:
    """One stroke of a round brush over the result."""

    kind: BrushKind
    points_px: Array  # (N, 2): corners of its way
    radius_px: float
    strength: float = 0.5  # share of its way that a push drags, or of the move that a restore takes
    # Over this share of the radius, from the edge inwards, the strength fades to nothing.
    falloff: float = 1.0
    pressure: Array | None = None  # (N,): 0 to 1, of a pen at the corners; none is 1

    def __post_init__(self) -> None:
        """Freeze the points and refuse broken strokes."""
        if self.kind not in get_args(BrushKind):
            raise ValueError(f"kind must be one of {', '.join(get_args(BrushKind))}")
        try:
            object.__setattr__(self, "points_px", frozen(self.points_px, (None, 2)))
            if self.pressure is not None:
                pressure = frozen(self.pressure, (len(self.points_px),))
                object.__setattr__(self, "pressure", pressure)
        except ValueError as error:
            raise BadValue("a stroke can't be used: {error}", error=error) from None
        if not len(self.points_px):
            raise BadValue("a stroke needs at least one point")
        for name, value, low, high in (
            ("radius_px", self.radius_px, MIN_SPACING_PX, np.inf),
            ("strength", self.strength, 0.0, 1.0),
            ("falloff", self.falloff, LEAST_FALLOFF, 1.0),
        ):
            if not low <= value <= high or value == np.inf:
                raise BadValue(
                    "{name} must be {low:g} to {high:g}, got {value!r}",
                    name=name,
                    low=low,
                    high=high,
                    value=value,
                )

    @property
    def spacing_px(self) -> float:
        """The spacing of the lattice that it needs."""
        return max(MIN_SPACING_PX, self.radius_px / _SPACINGS)

    @property
    def steps(self) -> npt.NDArray[np.int64]:
        """In how many steps it goes from each corner to the next."""
        lengths = np.linalg.norm(np.diff(self._corners[:, :2], axis=0), axis=1)
        return np.asarray(np.ceil(_STEPS * lengths / self.radius_px).clip(1.0), np.int64)

    @property
    def _corners(self) -> Array:
        """Place (x, y), px, and pressure at each corner; (N, 3), a single one twice."""
        pressure = np.ones(len(self.points_px)) if self.pressure is None else self.pressure
        corners = np.column_stack([self.points_px, pressure])
        return corners if len(corners) > 1 else np.repeat(corners, 2, axis=0)

    def mapped(self, transform: Affine) -> BrushStroke:
        """Return the stroke carried along by a similarity transform of its image."""
        radius = max(MIN_SPACING_PX, self.radius_px * transform.scale)
        return dataclasses.replace(self, points_px=transform(self.points_px), radius_px=radius)

    def dabs(self) -> Array:
        """Return each step's middle (x, y), the way it goes there (x, y), px, and the pressure.

        Result (M, 5); a single corner is a step that goes nowhere.
        """
        corners, steps = self._corners, self.steps
        corner = np.repeat(np.arange(len(steps)), steps)
        number = np.arange(len(corner)) - (np.cumsum(steps) - steps)[corner]
        ways = np.diff(corners, axis=0)[corner] / steps[corner, None]
        middles = corners[corner] + (number[:, None] + 0.5) * ways
        return np.column_stack([middles[:, :2], ways[:, :2], middles[:, 2]])


@dataclass(frozen=True, slots=True, eq=False)
class Brushwork:
    """Brush strokes that push parts of the result or restore the original.

    Parameters
    ----------
    strokes : tuple of BrushStroke
        In drawing order; each stroke changes the result of the previous strokes.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> work = kogao.Brushwork().with_stroke("push", [(300, 600), (320, 590)], radius_px=60)
    >>> rendering = kogao.render(photo.pixels, [], kogao.Recipe(), brushwork=work)
    >>> rendering.one_to_one.certified, rendering.brush_shares
    (True, (1.0,))
    """

    strokes: tuple[BrushStroke, ...] = ()

    def mapped(self, transform: Affine) -> Brushwork:
        """Return the strokes in the coordinates of a transformed image.

        Parameters
        ----------
        transform : Affine
            From old to new px; a similarity: rotation, scale, mirroring and shift.
        """
        return Brushwork(tuple(stroke.mapped(transform) for stroke in self.strokes))

    def with_stroke(
        self,
        kind: BrushKind,
        points_px: npt.ArrayLike,
        radius_px: float,
        strength: float = 0.5,
        falloff: float = 1.0,
    ) -> Brushwork:
        """Return the brushwork with one more stroke.

        Parameters
        ----------
        kind : {"push", "restore"}
            Push pixels along the stroke, or reduce the displacement under the stroke.
        points_px : array of shape (N, 2)
            Points of the brush path (x, y), px.
        radius_px : float
            Half the brush's width, at least 1.
        strength : float
            0 to 1. Push: pixels move by this share of the path. Restore: this share of the
            displacement is removed.
        falloff : float
            0.4 to 1: the strength fades to 0 over this share of the radius.
        """
        points = np.asarray(points_px, np.float64)
        stroke = BrushStroke(kind, points, radius_px, strength, falloff)
        return Brushwork((*self.strokes, stroke))


UNTOUCHED = Brushwork()


def brushed(
    field: Field, brushwork: Brushwork, photo: Box, *, guarded: bool
) -> tuple[Field, tuple[float, ...]]:
    """Return a field after the strokes of a brush, and the smallest share kept of each stroke.

    The lattices of `field` stay as they are, and first. Strokes are reduced where they squeeze.
    """
    own, strokes = len(field.lattices), brushwork.strokes
    keys = _keys(field, brushwork, (photo, guarded))
    lattices, shares = _known(keys) or (field.lattices, ())
    field = dataclasses.replace(field, lattices=lattices)
    for stroke, key in [*zip(strokes, keys, strict=True)][len(shares) :]:
        grid = Grid((photo.left - 0.5, photo.top - 0.5), stroke.spacing_px)
        if stroke.kind == "push":
            drawn = [_push(stroke, grid)]
        else:
            drawn = _restore(stroke, grid, field.lattices)
        changes: Sequence[Lattice] = [zero_on_edges(one, photo) for one in drawn if one.phi.any()]
        share = 1.0
        if guarded and changes:
            changes, share = limited_stroke(field, changes, photo)
        field, shares = _joined(field, own, changes), (*shares, share)
        _keep(key, (field.lattices, shares))
    if not fade_is_safe(field):
        field = dataclasses.replace(field, fade_px=0.0)
    return field, shares


def _keys(field: Field, work: Brushwork, other: object) -> list[bytes]:
    """Return what tells the results of the first stroke, of the first two, … from all others."""
    known, keys = hashlib.blake2b(repr(other).encode()), []
    for lattice in field.lattices:
        known.update(repr((lattice.grid, lattice.first, lattice.shape)).encode())
        known.update(lattice.phi.tobytes())
    for still in field.protection.strokes:
        known.update(still.key)
    for one in work.strokes:
        known.update(repr((one.kind, one.radius_px, one.strength, one.falloff)).encode())
        known.update(one.dabs().tobytes())
        keys.append(known.digest())
    return keys


def _known(keys: Sequence[bytes]) -> _Drawn | None:
    """Return the result of as many strokes as possible, of those kept."""
    with _LOCK:
        return next((_KEPT[key] for key in reversed(keys) if key in _KEPT), None)


def _keep(key: bytes, drawn: _Drawn) -> None:
    with _LOCK:
        _KEPT[key] = drawn
        while len(_KEPT) > _MOST_KEPT:
            del _KEPT[next(iter(_KEPT))]


def _push(stroke: BrushStroke, grid: Grid) -> Lattice:
    """Return the lattice that moves the picture under a brush along its way."""
    dabs = stroke.dabs()
    at, first, shape, weights = _nodes(stroke, grid, dabs[:, :2])
    moves = -stroke.strength * (dabs[:, 2:4] * dabs[:, 4:])
    phi: Array = np.empty((*shape, 2))
    for axis in (0, 1):
        summed = np.bincount(at.ravel(), (weights * moves[:, axis, None]).ravel(), phi[..., 0].size)
        phi[..., axis] = summed.reshape(shape)
    return Lattice(grid, first, phi)


def _restore(stroke: BrushStroke, grid: Grid, lattices: Sequence[Lattice]) -> list[Lattice]:
    """Return what takes away the share of lattices that lies under a brush."""
    dabs = stroke.dabs()
    at, first, shape, weights = _nodes(stroke, grid, dabs[:, :2])
    most = np.zeros(shape[0] * shape[1])
    np.maximum.at(most, at.ravel(), (stroke.strength * weights * dabs[:, 4:]).ravel())
    mask = Lattice(grid, first, np.repeat(most.reshape(*shape, 1), 2, axis=2))
    found = []
    for part in (lattice for lattice in lattices if meet(lattice, mask)):
        part = part.within(mask.box)
        while part.grid.spacing_px > _COARSEST * grid.spacing_px:
            part = part.refined().within(mask.box)
        x, y = (part.grid.nodes_px(part.first[k], part.shape[1 - k], k) for k in (0, 1))
        taken = np.moveaxis(mask.on_grid(x, y), 0, -1) * part.phi
        found.append(Lattice(part.grid, part.first, -taken))
    return found


def _nodes(
    stroke: BrushStroke, grid: Grid, middles: Array
) -> tuple[npt.NDArray[np.int64], tuple[int, int], tuple[int, int], Array]:
    """Return the nodes under a brush in each of its places, numbered within a block of them.

    Result: numbers and the brush's weights there, (M, K); the block's first column and row; how
    many rows and columns it has.
    """
    reach = math.ceil(stroke.radius_px / grid.spacing_px)
    offsets = np.arange(-reach, reach + 2)
    (i, s), (j, t) = (grid.locate(middles[:, axis], axis) for axis in (0, 1))
    first = int(i.min()) - reach, int(j.min()) - reach
    shape = int(np.ptp(j)) + len(offsets), int(np.ptp(i)) + len(offsets)
    across, down = offsets - s[:, None], offsets - t[:, None]
    rho = np.hypot(across[:, None, :], down[:, :, None]) * (grid.spacing_px / stroke.radius_px)
    columns, rows = (i - first[0])[:, None] + offsets, (j - first[1])[:, None] + offsets
    at = rows[:, :, None] * shape[1] + columns[:, None, :]
    weights = 1.0 - smoothstep(1.0 - (1.0 - rho) / stroke.falloff)
    return at.reshape(len(at), -1), first, shape, weights.reshape(len(at), -1)


def _joined(field: Field, own: int, changes: Sequence[Lattice]) -> Field:
    """Return a field with further displacements; its first lattices stay its own."""
    lattices = [*field.lattices]
    for one in changes:
        for k, other in enumerate(lattices[own:], start=own):
            if other.grid == one.grid and meet(other, one):
                joined = other.plus(one)
                if joined.phi.size <= _JOINED * (other.phi.size + one.phi.size):
                    lattices[k] = joined
                    break
        else:
            lattices.append(one)
    return dataclasses.replace(field, lattices=tuple(lattices))
