"""Straight lines stay straight and neighbours stay put: a change of the fit that no landmark feels.

A line may slide along itself, so only what the displacement does across it is asked to vanish: a
row ``n . d = 0`` for each sample, in which x and y meet. At the edge of somebody else both vanish.
The change c keeps to the control points of the fit and is nothing at every landmark and protected
place, so the field stays one spline that does to the face what the fit does. Among all such changes
it makes least ``c' L c + sum w (n . (d + c))^2``, L being the (screened) Laplacian of neighbouring
control points: what is moved for a line's sake is in proportion to the bend that it saves, and
weights, not decisions, say how much each line counts.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array, ramp
from kogao_core.faces.face import Face
from kogao_core.warp.field import Field
from kogao_core.warp.fit import STILL_STEP, Problem, on_quanta, summed
from kogao_core.warp.frame import edges_px
from kogao_core.warp.guard import bisected, is_safe
from kogao_core.warp.lattice import Grid, Lattice, groups, matrices
from kogao_core.warp.one_to_one import least_det

# In lattice spacings: so near to a landmark a line's ends are free, and so far from it all counts.
_FREE: Final = 0.25
_ALL: Final = 0.75
# A neighbour nearer to a landmark than this touches the face, and moves with it.
_TOUCHING: Final = 1.0
# Lines whose ends lie so near to a longer one, in lattice spacings, are pieces of it.
_ASIDE: Final = 0.15
# Pieces that a gap of more than this share of the face's longer side parts count as lines of their
# own: somebody stands between them, and where they would part nobody sees.
_BEHIND: Final = 0.5
# The face goes on above the ends of its outline, by this share of their distance: brows, glasses.
_ABOVE: Final = 0.25
_LINE: Final = 3e4  # weight of a line's row, 1 being that of a control point's
_LEAST: Final = 1e-2  # rows of less weight are left out
_NEIGHBOUR: Final = 3e4
_WITHIN: Final = 60.0  # of a place within the face, which is to go where it went
_INSIDE: Final = 1.5  # lattice spacings between those
_CORNER: Final = 1e6  # of eyes and mouth
_HARD: Final = 1e8  # of a landmark, a protected place, and the photo's edge
_RIGID: Final = (
    30.0  # of a line's shift and turn, for the square of its samples: free, but not for nothing
)
_SCREEN: Final = 0.06  # in L beside neighbours' differences: a change dies out over four spacings
_PINNED: Final = 3.5  # a line is followed so far beyond what the fit moves, in spacings
_MARGIN: Final = 1.0  # so far beyond that control points change, in spacings
_SOFT: Final = 2.0  # the last of them less and less
_MOST_NODES: Final = 4000  # of a change; of more it takes a lattice twice as coarse
# For lines, and for each other purpose; of more, samples stand farther apart.
_MOST_ROWS: Final = 350
# A change leaves det J at least so large, and at least this share of what it was without.
_LEAST_DET: Final = 0.5
_LEAST_SHARE: Final = 0.9


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """What a warp leaves as it is where it can."""

    # (N, 2, 2): ends (x, y) of straight lines of the background, px.
    lines: Array = dataclasses.field(default_factory=lambda: np.zeros((0, 2, 2)))
    # (M, 2): for each face, points on the edge of other people, whom it isn't to drag along, px;
    # empty where there are none.
    neighbours: tuple[Array, ...] = ()
    # (N,): how much each line counts, 0 to 1; all of them in full, if not given.
    weights: Array | None = None

    def mapped(self, transform: Affine) -> Held:
        """Return the same in another image's px."""
        lines = transform(self.lines.reshape(-1, 2)).reshape(-1, 2, 2)
        neighbours = tuple(transform(points) for points in self.neighbours)
        return dataclasses.replace(self, lines=lines, neighbours=neighbours)


NOTHING_HELD: Final = Held()


def hold(field: Field, problems: Sequence[Problem], faces: Sequence[Face], held: Held) -> Field:
    """Change a field so that lines stay straight and neighbours where they are.

    Where that would squeeze the photo too much, all of the change gives way, as little as it takes;
    faces never do. `problems` are what its lattices were fitted to, `faces` whose they are. What
    comes back is one-to-one where `field` is.
    """
    if not len(held.lines) and not any(len(points) for points in held.neighbours):
        return field
    lattices, rooms = list(field.lattices), [_Room.of(problem) for problem in problems]
    for group in groups([room.empty for room in rooms]):
        among = [problems[k] for k in group]
        landmarks = np.vstack([problem.target_px[: problem.movers] for problem in among])
        changed = []
        for k in group:
            near = held.neighbours[k] if held.neighbours else np.zeros((0, 2))
            if field.lattices[k].phi.any():
                before = field.lattices[k]
                rows = _rows(problems[k], rooms[k].empty, faces[k], landmarks, before, held, near)
                alone = _changed(before, problems[k], rooms[k], rows)
                lattices[k] = _allowed(field, [k], [alone])[0]
                changed.append(k)
        if len(changed) > 1:
            after = [lattices[k] for k in changed]
            for k, lattice in zip(changed, _allowed(field, changed, after), strict=True):
                lattices[k] = lattice
    return dataclasses.replace(field, lattices=tuple(lattices))


def _allowed(field: Field, which: Sequence[int], after: Sequence[Lattice]) -> Sequence[Lattice]:
    """Return as much of some lattices' change as leaves the photo in shape."""
    before = [field.lattices[k] for k in which]
    unchanged = dataclasses.replace(field, lattices=tuple(before))
    least = min(_LEAST_DET, _LEAST_SHARE * least_det(unchanged))
    was_safe = is_safe(unchanged)

    def mixed(share: float) -> list[Lattice]:
        return [
            on_quanta(a.plus(b.minus(a).scaled(share))) for a, b in zip(before, after, strict=True)
        ]

    def allow(lattices: Sequence[Lattice]) -> bool:
        changed = dataclasses.replace(field, lattices=tuple(lattices))
        det = least_det(changed, least)
        return det >= least and (is_safe(changed, det) or not was_safe)

    if all(a is b for a, b in zip(before, after, strict=True)) or allow(after):
        return after
    return mixed(bisected(lambda share: allow(mixed(share)), 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """What is asked of a change, a row for each place and direction.

    `places_px` and `across` are of shape (S, 2), `wanted_px` and `weight` of shape (S,): the change
    along `across`, and how much it counts. `line` says whose shift and turn a row leaves free, by
    number; -1 for none's.
    """

    places_px: Array
    across: Array
    wanted_px: Array
    weight: Array
    line: npt.NDArray[np.int64]

    @classmethod
    def of(cls, places: Array, across: Array, wanted: Array, weight: Array | float) -> _Rows:
        count = len(places)
        weights = np.broadcast_to(np.asarray(weight, np.float64), (count,))
        return cls(places, across, wanted, weights, np.full(count, -1))

    @classmethod
    def both_ways(cls, places: Array, wanted: Array, weight: Array | float) -> _Rows:
        """Return rows for x and for y; `wanted` is of shape (N, 2)."""
        weights = np.broadcast_to(np.asarray(weight, np.float64), (len(places),))
        ways = np.repeat(np.eye(2), len(places), axis=0)
        return cls.of(np.tile(places, (2, 1)), ways, wanted.T.ravel(), np.tile(weights, 2))

    @classmethod
    def joined(cls, parts: Sequence[_Rows]) -> _Rows:
        return cls(
            *(
                np.concatenate([getattr(part, field.name) for part in parts])
                for field in dataclasses.fields(cls)
            )
        )

    @property
    def rigid(self) -> Array:
        """What each line's shift and turn do to the rows, shape (S, two for each line)."""
        own = np.flatnonzero(self.line >= 0)
        _, first, which = np.unique(self.line[own], return_index=True, return_inverse=True)
        count = np.bincount(which)
        places, across = self.places_px[own], self.across[own]
        middles = np.stack([np.bincount(which, one) for one in places.T], axis=-1) / count[:, None]
        way = across[first][which]
        apart = places - middles[which]
        t = apart[:, 0] * way[:, 1] - apart[:, 1] * way[:, 0]
        most = np.zeros(len(count))
        np.maximum.at(most, which, np.abs(t))
        # The longer a line, the less it moves.
        share = (across * way).sum(axis=1) / count[which]
        columns = np.zeros((len(self.line), 2 * len(count)))
        columns[own, 2 * which] = share
        columns[own, 2 * which + 1] = share * t / np.maximum(most, 1e-12)[which]
        return columns


def _rows(
    problem: Problem,
    room: Lattice,
    face: Face,
    landmarks: Array,
    lattice: Lattice,
    held: Held,
    near: Array,
) -> _Rows:
    """Return what lines and neighbours ask of a face's lattice, and what must not feel it.

    `room` is where the lattice can change.
    """
    step, reaches = STILL_STEP * problem.grid.spacing_px, room.reaches
    parts = [_line_rows(problem, landmarks, lattice, held)]
    near = near[reaches(near)]
    apart = _away(problem, landmarks, near)
    near = _thinned(near[apart > _TOUCHING], step)
    apart = _away(problem, landmarks, near)
    weight = _NEIGHBOUR * np.clip((apart - _TOUCHING) / _TOUCHING, 0.0, 1.0) ** 2
    parts.append(_Rows.both_ways(near, -lattice.at(near), weight))
    if not any(len(part.weight) for part in parts):
        return _Rows.joined(parts)
    still = np.vstack(
        [landmarks, _thinned(problem.target_px[problem.movers + problem.features :], step)]
    )
    still = still[reaches(still)]
    inside, corners = _face_places(problem), np.vstack([face.eyes, face.mouth])
    inside, corners = inside[reaches(inside)], corners[reaches(corners)]
    parts.append(_Rows.both_ways(still, np.zeros_like(still), _HARD))
    parts.append(_Rows.both_ways(inside, np.zeros_like(inside), _WITHIN))
    parts.append(_Rows.both_ways(corners, np.zeros_like(corners), _CORNER))
    parts.extend(_edge_rows(problem, room))
    return _Rows.joined(parts)


@dataclass(frozen=True, slots=True, eq=False)
class _Room:
    """The control points that a change may move, and each column's and row's share of that.

    At its edge nothing changes: a control point more or less makes no difference.
    """

    empty: Lattice
    columns: Array
    rows: Array

    @classmethod
    def of(cls, problem: Problem) -> _Room:
        origin, spacing = np.array(problem.grid.origin_px), problem.grid.spacing_px
        low, high = problem.near_px + np.array([[-_MARGIN], [_MARGIN]]) * spacing
        while np.prod((high - low) / spacing) > _MOST_NODES:
            spacing *= 2.0
        low, high = (low - origin) / spacing, (high - origin) / spacing
        first, last = np.floor(low).astype(int), np.ceil(high).astype(int)
        axes = [np.arange(a, b + 1) for a, b in zip(first, last, strict=True)]
        columns, rows = (
            ramp(np.minimum(nodes - a, b - nodes) / _SOFT)
            for nodes, a, b in zip(axes, low, high, strict=True)
        )
        grid, zeros = Grid(problem.grid.origin_px, spacing), np.zeros((len(rows), len(columns), 2))
        return cls(Lattice(grid, (int(first[0]), int(first[1])), zeros), columns, rows)


def _changed(lattice: Lattice, problem: Problem, room: _Room, rows: _Rows) -> Lattice:
    """Return a lattice with the change that rows ask for."""
    if not rows.wanted_px.any():
        return lattice
    (((bx, by),),) = matrices([room.empty.window_at(*rows.places_px.T)])
    waves_x, costs_x = _waves(room.columns)
    waves_y, costs_y = _waves(room.rows)
    costs = costs_y[:, None] + costs_x + _SCREEN
    x, y = bx @ waves_x, by @ waves_y
    felt = (y[:, :, None] * x[:, None, :] / np.sqrt(costs)).reshape(len(x), -1)
    gram = (felt @ felt.T) * (rows.across @ rows.across.T)
    rigid = rows.rigid
    gram += _RIGID * rigid @ rigid.T + np.diag(1.0 / np.maximum(rows.weight, 1e-9))
    strength = np.linalg.solve(gram, rows.wanted_px)[:, None] * rows.across
    phi = np.stack(
        [waves_y @ ((y.T @ (one[:, None] * x)) / costs) @ waves_x.T for one in strength.T], -1
    )
    whole = summed(lattice, dataclasses.replace(room.empty, phi=phi))
    return on_quanta(problem.within(whole))


def _waves(shares: Array) -> tuple[Array, Array]:
    """Return the eigenvectors of the second difference of values, as far as those may change.

    In columns, and their eigenvalues.
    """
    numbers = np.arange(1, len(shares) + 1)
    turns = np.pi * numbers / (len(shares) + 1)
    waves = np.sqrt(2.0 / (len(shares) + 1)) * np.sin(np.outer(numbers, turns))
    return shares[:, None] * waves, 2.0 - 2.0 * np.cos(turns)


def _edge_rows(problem: Problem, room: Lattice) -> Iterator[_Rows]:
    """Yield rows along the photo's edges, across which nothing moves."""
    if problem.photo is None:
        return
    reach = np.array(room.reach_px).reshape(2, 2)
    edges = edges_px(problem.photo)
    for axis, way in enumerate(np.eye(2)):
        other = 1 - axis
        low, high = np.clip(reach[:, other], *edges[:, other])
        for edge in edges[:, axis]:
            if reach[0, axis] < edge < reach[1, axis] and low < high:
                along = np.arange(low, high, problem.grid.spacing_px)
                places = np.empty((len(along), 2))
                places[:, axis], places[:, other] = edge, along
                ways = np.repeat(way[None], len(along), axis=0)
                yield _Rows.of(places, ways, np.zeros(len(along)), _HARD)


def _line_rows(problem: Problem, landmarks: Array, lattice: Lattice, held: Held) -> _Rows:
    """Return the rows of the lines that come near: samples all along them.

    Beyond the lattice's reach nothing can change: what lies there pins a line's shift and turn.
    """
    box = problem.near_px + np.array([[-1.0], [1.0]]) * _PINNED * problem.grid.spacing_px
    lines, weights = held.lines, np.ones(len(held.lines)) if held.weights is None else held.weights
    along = lines[:, 1] - lines[:, 0]
    lengths = np.hypot(along[:, 0], along[:, 1])
    units = along / np.maximum(lengths, 1e-12)[:, None]
    start, end = _spans_in(lines[:, 0], units, lengths, box)
    kept = (end > start) & (weights > 0.0)
    lines, units, lengths, weights = lines[kept], units[kept], lengths[kept], weights[kept]
    start, spans = start[kept], (end - start)[kept]
    length_px = STILL_STEP * problem.grid.spacing_px
    dense = spans * weights ** (1.0 / 6.0)  # what hardly counts needs few samples
    step = max(length_px, float(dense.sum()) / _MOST_ROWS)
    counts = np.ceil(dense / step).astype(int) + 1
    line = np.repeat(np.arange(len(lines)), counts)
    sample = np.arange(len(line)) - np.repeat(np.cumsum(counts) - counts, counts)
    far = start[line] + sample / (counts - 1.0)[line] * spans[line]
    places, ways = lines[line, 0] + far[:, None] * units[line], _normals(units)[line]
    apart = (_away(problem, landmarks, places) - _FREE) / (_ALL - _FREE)
    share = (spans / (length_px * counts))[line]
    weight = _LINE * weights[line] * share * np.clip(apart, 0.0, 1.0) ** 2
    felt = weight > _LEAST
    line, places, ways, weight = line[felt], places[felt], ways[felt], weight[felt]
    rows = _Rows.of(places, ways, -(lattice.at(places) * ways).sum(axis=1), weight)
    aside_px = _ASIDE * problem.grid.spacing_px
    most_px = _BEHIND * float(np.ptp(problem.target_px[: problem.movers], axis=0).max())
    wholes = _wholes(lines, units, lengths, aside_px, most_px)
    return dataclasses.replace(rows, line=wholes[line])


def _spans_in(starts: Array, units: Array, lengths: Array, box: Array) -> tuple[Array, Array]:
    """Return from where to where along each line it lies in a box, px; empty where it doesn't."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort((box - starts[:, None]) / units[:, None], axis=1)
    along = np.abs(units) > 1e-9
    inside = along | ((starts >= box[0]) & (starts <= box[1]))
    low = np.where(along, ends[:, 0], np.where(inside, 0.0, np.inf)).max(axis=1)
    high = np.where(along, ends[:, 1], np.inf).min(axis=1)
    return np.maximum(low, 0.0), np.minimum(high, lengths)


def _normals(units: Array) -> Array:
    """Return what is across directions of shape (N, 2)."""
    return np.stack([-units[:, 1], units[:, 0]], axis=-1)


def _wholes(
    lines: Array, units: Array, lengths: Array, aside_px: float, most_px: float
) -> npt.NDArray[np.int64]:
    """Return the longest line that each is a piece of: a shelf is found between what is on it."""
    if not len(lines):
        return np.zeros(0, np.int64)
    normals = _normals(units)
    mine = np.einsum("knec,kc->kne", lines - lines[:, None, :1], normals)
    others = np.einsum("knec,nc->kne", lines[:, None] - lines[:, :1], normals)
    forth = np.einsum("knec,kc->kne", lines - lines[:, None, :1], units)
    gaps = np.maximum(forth.min(axis=2) - lengths[:, None], -forth.max(axis=2))
    longer = lengths[:, None] >= lengths
    pieces = np.where(longer, np.abs(mine).max(axis=2), np.abs(others).max(axis=2)) <= aside_px
    pieces &= gaps <= most_px
    return np.asarray(np.where(pieces, lengths, -1.0).argmax(axis=1))


def _away(problem: Problem, landmarks: Array, places: Array) -> Array:
    """Return how far places are from the nearest landmark, in lattice spacings, shape (N,)."""
    apart = places[:, None] - landmarks
    nearest = np.hypot(apart[..., 0], apart[..., 1]).min(axis=1, initial=np.inf)
    return np.asarray(nearest / problem.grid.spacing_px)


def _face_places(problem: Problem) -> Array:
    """Return places all over a face, from the chin to the brows, (N, 2), px."""
    outline = problem.target_px[: problem.movers]
    first, last = outline[0], outline[-1]
    up = _ABOVE * np.array([last[1] - first[1], first[0] - last[0]])
    up = up if (outline.mean(axis=0) - first) @ up < 0.0 else -up
    hull = cv2.convexHull(np.vstack([outline, last + up, first + up]).astype(np.float32))[:, 0]
    low, high = hull.min(axis=0).astype(np.float64), hull.max(axis=0).astype(np.float64)
    step = max(_INSIDE * problem.grid.spacing_px, float(np.sqrt(np.prod(high - low) / _MOST_ROWS)))
    x, y = np.meshgrid(np.arange(low[0], high[0], step), np.arange(low[1], high[1], step))
    places = np.column_stack([x.ravel(), y.ravel()])
    within = [cv2.pointPolygonTest(hull, place, measureDist=False) > 0 for place in places.tolist()]
    return np.asarray(places[np.array(within, bool)])


def _thinned(places: Array, step_px: float) -> Array:
    """Return one place for each small square, of squares so large that few are left."""
    while len(places):
        _, first = np.unique(np.floor(places / step_px), axis=0, return_index=True)
        if len(first) <= _MOST_ROWS:
            return np.asarray(places[np.sort(first)])
        step_px *= 2.0
    return places
