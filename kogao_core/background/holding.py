"""Keep straight background edges straight and neighbours in place by a change of the lattices.

Each row of `Edges` asks that the displacement across an edge is the same at two places, so that the
edge neither turns nor bends. Long edges shall not shift either, with little weight. On the outline
of a neighbour the displacement itself must be zero. The change c is zero at every landmark. Among
all such changes it minimises ``c' L c + sum of w (row of (d + c))^2``, where L is the screened
Laplacian of neighbouring control points. Everything but d and the landmarks' places is built once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.additions.edge import edges_px, zero_on_edges
from kogao_core.additions.guard import LEAST_DET, bisected, is_safe
from kogao_core.additions.lens import away_px
from kogao_core.background.edges import Edges, no_edges
from kogao_core.base.geometry import Affine, Array, Box
from kogao_core.base.threads import parallel_map
from kogao_core.faces.face import Face
from kogao_core.field.field import Field
from kogao_core.field.one_to_one import least_det
from kogao_core.paper.basis import ORDER, basis
from kogao_core.paper.lattice import Grid, Lattice, groups, quantised
from kogao_core.recipe.recipe import LOSSLESS_PX

# All lengths are in lattice spacings. A row counts nothing so near to a landmark, and in full so
# far from it.
_FREE: Final = 0.15
_ALL: Final = 0.6
# Landmarks move inwards, at most to this share of their distance from the middle of the outline.
_INNERMOST: Final = 0.9
# A neighbour nearer to a landmark than this touches the face, and moves with it.
_TOUCHING: Final = 1.0
# The face goes on above the ends of its outline, by this share of their distance: brows, glasses.
_ABOVE: Final = 0.25
# Weights; 1 is that of a difference of neighbouring control points.
_NEIGHBOUR: Final = 3e4  # of a neighbour close to the face
_PERSON: Final = 90.0  # of a place on the person's hair and clothes, where the change is to be zero
_WITHIN: Final = 60.0  # the same of a place within the face
_INSIDE: Final = 1.5  # between those
# Of neighbours clear of the face, corners of eyes and mouth, and the photo's edge. Larger values
# hold these within less than 0.04 px and lines less straight.
_STILL: Final = 1e6
_RIDGE: Final = 1e-9  # of the equations of the landmarks
_SCREEN: Final = 1.0  # in L beside neighbours' differences: a change fades over one spacing
# It fades over less far from the outline: that much is added there, rising from the first of these
# distances over the second. Larger: lines near the head take less of the picture along, and turn.
_FIRMER: Final = 1.5
_FIRM: Final = (3.0, 4.0)
# The change acts in a square of this half side, moved up from the middle of the outline by so much.
_HALF: Final = 16.0
_WIDER: Final = 1.25  # factor if a lens correction displaces more than that square
_UP: Final = 2.5
# Shorter displacements of a control point are dropped, those from three times as long on kept in
# full. Less than three times would be steeper, and make more of small changes of a photo.
_UNSEEN: Final = 0.035
# The change's lattice is the fit's, or that at double the spacing until it is at least this share
# of the landmark spacing.
_FINEST: Final = 1.4
_SMALL: Final = 64  # rows of a matrix that is inverted in one step
_MOST_PLACES: Final = 350  # of neighbours and within the face; of more, places are farther apart


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """Edges to keep straight and people to leave in place, for each face of a rendering."""

    edges: tuple[Edges, ...] = ()  # one for each face; empty: none
    # (M, 3): for each face, points on other people and how unsure they are (`PersonMask`), px.
    neighbours: tuple[Array, ...] = ()
    others: tuple[Face, ...] = ()  # faces of other people, who stay in place
    # The newest equations of each face, by its index, after the values they were built for.
    built: dict[int, tuple[Any, tuple[_Steady, ...]]] = dataclasses.field(default_factory=dict)

    def mapped(self, transform: Affine) -> Held:
        """Return the same in another image's px."""
        neighbours = tuple(
            np.column_stack([transform(points[:, :2]), transform.scale * points[:, 2:]])
            for points in self.neighbours
        )
        others = tuple(face.mapped(transform) for face in self.others)
        return Held(tuple(edges.mapped(transform) for edges in self.edges), neighbours, others)


NOTHING_HELD: Final = Held()


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """Where the lattice of one face stands, and what must not change there."""

    grid: Grid  # of the fit
    target_px: Array  # (N, 2): the targets of the landmarks
    around_px: Array | None  # (2, 2): corners of the box that the head displaces
    photo: Box | None  # nothing moves across its edges


def hold(field: Field, sites: Sequence[Site], faces: Sequence[Face], held: Held) -> Field:
    """Change a field so that edges stay straight and neighbours stay in place.

    A change that would squeeze the picture is reduced. The result is one-to-one where `field` is.
    """
    if not held.edges and not any(len(points) for points in held.neighbours):
        return field
    lattices, found = list(field.lattices), groups(field.lattices)
    targets = {k: np.vstack([sites[k].target_px for k in group]) for group in found for k in group}

    def change(k: int) -> Lattice | None:
        after = field.lattices[k]
        if not after.phi.any():
            return None
        exact = [targets[k]]
        for steady in _changes(field, sites[k], faces[k], held, k):
            after = after.plus(steady.change(after, targets[k]))
            exact.append(steady.still_px)
        after = _without_tails(after, np.vstack(exact), _UNSEEN * faces[k].anchor.spacing_px)
        return quantised(zero_on_edges(after, sites[k].photo))

    made = parallel_map(change, range(len(lattices)))
    for group in found:
        changed = {k: lattice for k in group if (lattice := made[k]) is not None}
        allowed = _allowed(field, [*changed], [*changed.values()])
        for k, lattice in zip(changed, allowed, strict=True):
            lattices[k] = lattice
    return dataclasses.replace(field, lattices=tuple(lattices))


def _without_tails(lattice: Lattice, exact_px: Array, unseen_px: float) -> Lattice:
    """Return the lattice without displacements that nobody sees, but for those near `exact_px`."""
    # Control points that move a place are nearer than three spacings; all of these stay.
    near = ORDER - _away_px(lattice, exact_px) / lattice.grid.spacing_px
    kept = 1.5 - 1.5 * unseen_px / np.maximum(lattice.magnitude_px, unseen_px)
    kept = np.maximum(np.clip(near, 0.0, 1.0), np.minimum(kept, 1.0))
    return dataclasses.replace(lattice, phi=lattice.phi * kept[..., None])


def _changes(field: Field, site: Site, face: Face, held: Held, k: int) -> tuple[_Steady, ...]:
    """Return the equations of the changes of a face: neighbours on a fine lattice, then all."""
    edges = held.edges[k] if held.edges else None
    # Faces of people who stay, also beyond the crop in which neighbours are looked for.
    still = [np.insert(one.points, 2, 0.0, axis=1) for one in held.others]
    near = np.vstack([np.zeros((0, 3)), *held.neighbours[k : k + 1], *still])
    # Neighbours alone are held first, in half the square and on a lattice twice as fine.
    rooms = [_room(site, face, scale) for scale in (0.5, 1.0)]
    known, found = held.built.get(k, (None, ()))
    places = [(room.grid, room.first, room.shape) for room in rooms]
    values = face.points.tobytes(), site.photo, places
    if known != values:
        both = zip(rooms, (None, edges or no_edges()), strict=True)
        found = tuple(_Steady(site, face, room, rows, near) for room, rows in both)
        found = tuple(steady for steady in found if len(steady.weights))
        held.built[k] = values, found
    if not field.protection.strokes:
        return found
    alone = Field((field.lattices[k],), protection=field.protection)
    # A protected part pins its edge.
    shares = [alone.protected_share(steady.places) for steady in found]
    return tuple(
        _Steady(site, face, one.room, one.edges, near, share) if (share < 1.0).any() else one
        for one, share in zip(found, shares, strict=True)
    )


def _allowed(field: Field, which: Sequence[int], after: Sequence[Lattice]) -> Sequence[Lattice]:
    """Return the lattices with as much of their change as does not squeeze the picture."""
    before = [field.lattices[k] for k in which]
    unchanged = dataclasses.replace(field, lattices=tuple(before))
    was = least_det(unchanged)
    least = min(was, LEAST_DET)

    def mixed(share: float) -> list[Lattice]:
        return [
            quantised(a.plus(b.minus(a).scaled(share))) for a, b in zip(before, after, strict=True)
        ]

    def allow(lattices: Sequence[Lattice]) -> bool:
        changed = dataclasses.replace(field, lattices=tuple(lattices))
        det = least_det(changed, least)
        return det >= least and (is_safe(changed, det) or not is_safe(unchanged, was))

    if allow(after):
        return after
    if len(which) > 1:
        after = [_allowed(field, [k], [one])[0] for k, one in zip(which, after, strict=True)]
        if allow(after):
            return after
    return mixed(bisected(lambda share: allow(mixed(share)), 1.0))


class _Steady:
    """The equations of one face's change."""

    def __init__(
        self,
        site: Site,
        face: Face,
        room: Lattice,
        edges: Edges | None,
        near: Array,
        shares: Array | None = None,
    ) -> None:
        """Build the equations of the control points of `room`; without `edges`, for neighbours.

        `shares`: of the displacement that protection leaves at `places`.
        """
        source, h, self.edges, self.room = face.outline, face.anchor.spacing_px, edges, room
        middle = source.mean(axis=0)
        swept = np.vstack(
            [middle + f * (source - middle) for f in (1.0, (1.0 + _INNERMOST) / 2.0, _INNERMOST)]
        )
        pairs, tied, normals, weights = _near_rows(edges, self.room, swept, h)
        near = near[self.room.reaches(near[:, :2])]
        near = _thinned(near[away_px(near[:, :2], swept) > _TOUCHING * h], 0.5 * h)
        near, sure = near[:, :2], 1.0 / (1.0 + near[:, 2] / h)
        # Nearly exact where a neighbour is clear of the face, soft where both meet.
        clear = away_px(near, swept) / (_TOUCHING * h) - np.array([[1.0], [2.0]])
        soft, exact = np.clip(clear, 0.0, 1.0) ** 2
        # A weight acts by its order of magnitude.
        still = np.expm1(sure**2 * np.log1p(_NEIGHBOUR * soft + _STILL * exact))
        self._edges, self._normals, self.still_px = len(weights), normals, near
        self.weights = np.concatenate([weights, still])
        self.places = np.concatenate([pairs.reshape(-1, 2), near])
        both = np.column_stack([np.ones(len(tied)), -tied]).ravel()
        factors = np.concatenate([both, np.ones(len(near))])
        self._factors = factors if shares is None else factors * shares
        if not len(self.weights):
            return
        number = np.arange(len(self.weights))
        self._of_row = np.concatenate(
            [np.repeat(number[: len(weights)], 2), number[len(weights) :]]
        )
        self._rows = self._basis_rows(self.places, self._of_row, self._factors)
        matrix = self._built(site, face, edges, swept)
        self._whitening = _inverse(np.asarray(np.linalg.cholesky(matrix), np.float64))
        # The newest change, after the values it was solved for: a drag leaves other faces alone.
        self._newest: tuple[Any, Lattice] = (), self.room

    def change(self, lattice: Lattice, landmarks: Array) -> Lattice:
        """Return the change of a lattice, zero at landmarks (N, 2)."""
        landmarks = landmarks[self.room.reaches(landmarks)]
        values = lattice.grid, lattice.first, lattice.phi.tobytes(), landmarks.tobytes()
        known, change = self._newest
        if values != known:
            change = self._solved(lattice, landmarks)
            self._newest = values, change
        return change

    def _solved(self, lattice: Lattice, landmarks: Array) -> Lattice:
        n, count = self._rows.shape[1], self._edges
        requested = self._factors[:, None] * lattice.at(self.places)
        parts = np.stack([np.bincount(self._of_row, one) for one in requested.T], axis=-1)
        parts *= self.weights[:, None]
        parts[:count] = (parts[:count] * self._normals).sum(axis=1)[:, None] * self._normals
        rows_of_basis = self._basis_rows(landmarks)
        m = len(rows_of_basis)
        both = np.zeros((2 * m, 2 * n))
        both[:m, :n] = both[m:, n:] = rows_of_basis
        sides = np.column_stack([-(self._rows.T @ parts).T.ravel(), both.T])
        sides = self._whitening @ sides
        free, ways = sides[:, 0], sides[:, 1:]
        strength = np.linalg.solve(ways.T @ ways + _RIDGE * np.eye(2 * m), ways.T @ free)
        phi = self._whitening.T @ (free - ways @ strength)
        phi = phi.reshape(2, *self.room.shape)
        # Invisible steps: a drag elsewhere leaves these control points equal.
        coarse = LOSSLESS_PX * np.round(phi / LOSSLESS_PX)
        exact = np.vstack([rows_of_basis, self._rows[count:]]).any(axis=0)
        phi = np.where(exact.reshape(self.room.shape), phi, coarse)
        return dataclasses.replace(self.room, phi=np.ascontiguousarray(phi.transpose(1, 2, 0)))

    def _basis_rows(
        self,
        places: Array,
        rows: npt.NDArray[np.int64] | None = None,
        factors: Array | float = 1.0,
    ) -> Array:
        """Return the B-spline weight of each control point at places, (places, n).

        With `rows`, add up the places of each row, each times its factor.
        """
        rows = np.arange(len(places)) if rows is None else rows
        (down, across), first = self.room.shape, self.room.first
        (i, s), (j, t) = (self.room.grid.locate(places[:, axis], axis) for axis in (0, 1))
        weights = np.reshape(factors, (-1, 1, 1)) * basis(t)[:, :, None] * basis(s)[:, None]
        reach = np.arange(ORDER) - 1
        column = np.broadcast_to((i - first[0])[:, None, None] + reach, weights.shape)
        row = np.broadcast_to((j - first[1])[:, None, None] + reach[:, None], weights.shape)
        on = (column >= 0) & (column < across) & (row >= 0) & (row < down)
        at = (rows[:, None, None] * down + row) * across + column
        shape = int(rows.max(initial=-1)) + 1, down * across
        rows_of_basis = np.bincount(at[on], weights[on], shape[0] * shape[1])
        return np.asarray(rows_of_basis.reshape(shape), np.float64)

    def _built(self, site: Site, face: Face, edges: Edges | None, swept: Array) -> Array:
        """Return the symmetric matrix of the change's x, then y components."""
        (rows, columns), n = self.room.shape, self._rows.shape[1]
        still: Array = np.zeros((n, n))
        index = np.arange(n).reshape(rows, columns)
        h, outline = face.anchor.spacing_px, swept[-len(face.outline) :]
        far = np.clip((_away_px(self.room, swept) / h - _FIRM[0]) / _FIRM[1], 0.0, 1.0)
        still[index, index] = 4.0 + _SCREEN + _FIRMER * far
        for one, other in ((index[:, 1:], index[:, :-1]), (index[1:], index[:-1])):
            still[one, other] = still[other, one] = -1.0
        inside, corners = _face_places(outline, h), np.vstack([face.eyes, face.mouth])
        count, edges = self._edges, edges or no_edges()
        on = self.room.reaches(edges.people_px)
        places = [inside, corners, edges.people_px[on]]
        weights = [np.full(len(inside), _WITHIN), np.full(len(corners), _STILL)]
        weights.append(_PERSON * edges.opacities[on])
        rows_of_basis = np.concatenate([self._basis_rows(np.vstack(places)), self._rows[count:]])
        still += _squared(rows_of_basis, np.concatenate([*weights, self.weights[count:]]))
        lines = np.asarray(self._rows[:count], np.float32)
        # Single precision halves the time and changes no displacement by 1/64 px.
        normals = np.asarray(self._normals, np.float32)
        both = np.concatenate([normal[:, None] * lines for normal in normals.T], axis=1)
        matrix = _squared(both, self.weights[:count]).reshape(2, n, 2, n)
        for axis in (0, 1):
            matrix[axis, :, axis] += still
        for axis, there in _edge_places(site, self.room):
            matrix[axis, :, axis] += _squared(self._basis_rows(there), np.full(len(there), _STILL))
        return matrix.reshape(2 * n, 2 * n)


def _away_px(lattice: Lattice, places: Array) -> Array:
    """Return the distance of each control point from the nearest place, (rows, columns), px."""
    (rows, columns), grid = lattice.shape, lattice.grid
    x, y = grid.nodes_px(lattice.first[0], columns, 0), grid.nodes_px(lattice.first[1], rows, 1)
    return away_px(np.stack(np.meshgrid(x, y), -1).reshape(-1, 2), places).reshape(rows, columns)


def _squared(rows: Array, weights: Array) -> Array:
    """Return ``rows' diag(weights) rows``."""
    scaled = np.asarray(np.sqrt(weights)[:, None] * rows, rows.dtype)
    return np.asarray(scaled.T @ scaled, np.float64)


def _inverse(lower: Array) -> Array:
    """Return the inverse of a lower triangular matrix, with a third of the usual work."""
    if len(lower) <= _SMALL:
        return np.asarray(np.linalg.inv(lower))
    half, inverse = len(lower) // 2, np.zeros_like(lower)
    inverse[:half, :half] = _inverse(lower[:half, :half])
    inverse[half:, half:] = _inverse(lower[half:, half:])
    inverse[half:, :half] = -inverse[half:, half:] @ lower[half:, :half] @ inverse[:half, :half]
    return inverse


def _room(site: Site, face: Face, scale: float) -> Lattice:
    """Return the lattice that a change can move, of zeros; `scale`: of its square and spacing."""
    outline, h, half = face.outline, face.anchor.spacing_px, scale * _HALF
    spacing, origin = site.grid.spacing_px, np.array(site.grid.origin_px)
    while spacing < scale * _FINEST * h:
        spacing *= 2.0
    up = (outline[0] + outline[-1]) / 2.0 - outline.mean(axis=0)
    middle = (outline.min(axis=0) + outline.max(axis=0)) / 2.0
    if site.around_px is not None and np.abs(site.around_px - middle).max() > half * h:
        half *= _WIDER
    middle = middle + _UP * h * up / max(1e-9, float(np.hypot(*up)))
    low, high = ((middle + way * half * h - origin) / spacing for way in (-1.0, 1.0))
    first, last = np.ceil(low).astype(int), np.floor(high).astype(int)
    columns, rows = last - first + 1
    zeros = np.zeros((rows, columns, 2))
    room = Lattice(Grid(site.grid.origin_px, spacing), (int(first[0]), int(first[1])), zeros)
    return room if site.photo is None else room.within(site.photo)


def _near_rows(
    edges: Edges | None, room: Lattice, landmarks: Array, h: float
) -> tuple[Array, Array, Array, Array]:
    """Return places, ties, normals and weights of the rows that a change can serve."""
    edges = edges or no_edges()
    on = room.reaches(edges.places_px.reshape(-1, 2)).reshape(-1, 2).any(axis=1)
    places, weights = edges.places_px[on], edges.weights[on]
    apart = away_px(places.reshape(-1, 2), landmarks).reshape(-1, 2).min(axis=1) / h
    weights = weights * np.clip((apart - _FREE) / (_ALL - _FREE), 0.0, 1.0) ** 2
    some = weights > 0.0
    return places[some], edges.tied[on][some], edges.normals[on][some], weights[some]


def _edge_places(site: Site, room: Lattice) -> Iterator[tuple[int, Array]]:
    """Yield places along each edge of the photo in the room, and the axis across it."""
    if site.photo is None:
        return
    reach = np.array(room.reach_px).reshape(2, 2)
    edges = edges_px(site.photo)
    for axis in (0, 1):
        low, high = np.clip(reach[:, 1 - axis], *edges[:, 1 - axis])
        for edge in edges[:, axis]:
            if reach[0, axis] < edge < reach[1, axis] and low < high:
                along = np.arange(low, high, room.grid.spacing_px)
                places = np.empty((len(along), 2))
                places[:, axis], places[:, 1 - axis] = edge, along
                yield axis, places


def _face_places(outline: Array, h: float) -> Array:
    """Return places all over a face, from the chin to the brows, (N, 2), px."""
    first, last = outline[0], outline[-1]
    up = _ABOVE * np.array([last[1] - first[1], first[0] - last[0]])
    up = up if (outline.mean(axis=0) - first) @ up < 0.0 else -up
    hull = cv2.convexHull(np.vstack([outline, last + up, first + up]).astype(np.float32))[:, 0]
    low, high = hull.min(axis=0).astype(np.float64), hull.max(axis=0).astype(np.float64)
    step = max(_INSIDE * h, float(np.sqrt(np.prod(high - low) / _MOST_PLACES)))
    x, y = np.meshgrid(np.arange(low[0], high[0], step), np.arange(low[1], high[1], step))
    places = np.column_stack([x.ravel(), y.ravel()])
    within = [cv2.pointPolygonTest(hull, place, measureDist=False) > 0 for place in places.tolist()]
    return np.asarray(places[np.array(within, bool)])


def _thinned(places: Array, step_px: float) -> Array:
    """Return one place for each small square, of squares so large that few are left."""
    while len(places):
        cells = np.floor(places[:, :2] / step_px)
        _, first = np.unique(cells, axis=0, return_index=True)
        if len(first) <= _MOST_PLACES:
            return np.asarray(places[np.sort(first)])
        step_px *= 2.0
    return places
