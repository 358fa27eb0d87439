"""What held lines and neighbours ask of a face's lattice: one row for each place and direction."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.warp.fit import STILL_STEP, Problem

# Samples nearer than this to a landmark, in lattice spacings, are left out: ends are free.
_FREE: Final = 0.5
# So near to a landmark a neighbour touches the face, and moves with it.
_TOUCHING: Final = 1.0
# Lines whose ends lie so near to a longer one, in lattice spacings, are pieces of it.
_ASIDE: Final = 0.15
# Pieces that a gap of more than this share of the face's longer side parts count as lines of their
# own: somebody stands between them, and where they would part nobody sees.
_BEHIND: Final = 0.5
# The face goes on above the ends of its outline, by this share of their distance: brows, glasses.
_ABOVE: Final = 0.25
_DIRECTIONS: Final = 8  # that samples in one place can have; more say nothing new
_MOST_ROWS: Final = 400  # a face; where there would be more, samples stand farther apart
_NOWHERE: Final = -1


@dataclass(frozen=True, slots=True, eq=False)
class HeldRows:
    """What is asked of a change, a row for each place and direction."""

    # (S, 2): where, and the unit vector along which the displacement is to vanish.
    places_px: Array
    across: Array
    away: Array  # (S,): how far from the nearest landmark, in lattice spacings
    # Int (S,): which line's that may shift and turn as a whole; -1 for those of none.
    line: npt.NDArray[np.int64]

    def part(self, which: npt.NDArray[Any]) -> HeldRows:
        """Return some of the rows."""
        return HeldRows(
            self.places_px[which], self.across[which], self.away[which], self.line[which]
        )

    @property
    def rigid(self) -> Array:
        """What each line's shift and turn do to the rows, shape (S, two for each line)."""
        columns = []
        for line in sorted({*self.line.tolist()} - {_NOWHERE}):
            own = self.line == line
            places, across = self.places_px[own], self.across[own]
            along = np.array([across[0, 1], -across[0, 0]])
            t = (places - places.mean(axis=0)) @ along
            same_side = across @ across[0]
            for share in (np.ones_like(t), t / max(1e-12, float(np.abs(t).max()))):
                column = np.zeros(len(self.line))
                column[own] = same_side * share
                columns.append(column)
        return np.array(columns).reshape(-1, len(self.line)).T


def rows_of(problem: Problem, landmarks: Array, lines: Array, neighbours: Array) -> HeldRows | None:
    """Return what lines and neighbours ask of a face's lattice, if anything.

    `lines` (L, 2, 2) px. Result: None where there is nothing in reach.
    """
    step, reaches = STILL_STEP * problem.grid.spacing_px, problem.support.empty.reaches
    parts = []
    for places, across, line in _samples(problem, lines, step):
        parts.append(HeldRows(places, across, away(problem, landmarks, places), line))
    near = neighbours[reaches(neighbours)]
    apart = away(problem, landmarks, near)
    near, apart = near[apart > _TOUCHING], apart[apart > _TOUCHING]
    for direction in ((1.0, 0.0), (0.0, 1.0)):
        parts.append(HeldRows(near, np.tile(direction, (len(near), 1)), apart, _none(near)))
    rows = HeldRows(
        np.concatenate([part.places_px for part in parts]),
        np.concatenate([part.across for part in parts]),
        np.concatenate([part.away for part in parts]),
        np.concatenate([part.line for part in parts]),
    )
    return _thinned(rows.part(reaches(rows.places_px) & (rows.away > _FREE)), step)


def still_places(problem: Problem, landmarks: Array) -> Array:
    """Return the places where a change is nothing: landmarks, and what is protected.

    Result (N or more, 2) px.
    """
    protected = problem.target_px[problem.movers :]
    nowhere = np.zeros(len(protected))
    rows = HeldRows(protected, np.zeros_like(protected), nowhere, _none(protected))
    kept = _thinned(rows, STILL_STEP * problem.grid.spacing_px)
    return landmarks if kept is None else np.vstack([landmarks, kept.places_px])


def face_places(problem: Problem) -> Array:
    """Return places all over a face, from the chin to the brows. Result (N, 2) px."""
    outline = problem.target_px[: problem.movers]
    first, last = outline[0], outline[-1]
    up = _ABOVE * np.array([last[1] - first[1], first[0] - last[0]])
    up = up if (outline.mean(axis=0) - first) @ up < 0.0 else -up
    corners = np.vstack([outline, last + up, first + up]).astype(np.float32)
    hull = cv2.convexHull(corners)[:, 0].astype(np.float64)
    step, low, high = STILL_STEP * problem.grid.spacing_px, hull.min(axis=0), hull.max(axis=0)
    x, y = np.meshgrid(np.arange(low[0], high[0], step), np.arange(low[1], high[1], step))
    places = np.column_stack([x.ravel(), y.ravel()])
    edges, offsets = np.roll(hull, -1, axis=0) - hull, places[:, None] - hull
    turns = edges[:, 0] * offsets[..., 1] - edges[:, 1] * offsets[..., 0]
    return np.asarray(places[(turns >= 0.0).all(axis=1) | (turns <= 0.0).all(axis=1)])


def away(problem: Problem, landmarks: Array, places: Array) -> Array:
    """Return how far places are from the nearest landmark, in lattice spacings. Result (M,)."""
    apart = places[:, None] - landmarks
    nearest = np.hypot(apart[..., 0], apart[..., 1]).min(axis=1, initial=np.inf)
    return np.asarray(nearest / problem.grid.spacing_px)


def _none(places: Array) -> npt.NDArray[np.int64]:
    return np.full(len(places), _NOWHERE)


def _samples(
    problem: Problem, lines: Array, step_px: float
) -> Iterator[tuple[Array, Array, npt.NDArray[np.int64]]]:
    """Yield samples of each line that comes near, which way is across it, and `HeldRows.line`."""
    box = np.array(problem.support.empty.reach_px).reshape(2, 2)
    along = lines[:, 1] - lines[:, 0]
    lengths = np.hypot(along[:, 0], along[:, 1])
    lines, along, lengths = (part[lengths > 0.0] for part in (lines, along, lengths))
    units = along / lengths[:, None]
    low, high = lines.min(axis=1), lines.max(axis=1)
    near = np.flatnonzero(((low < box[1]) & (high > box[0])).all(axis=1))
    ends_outside = ((low < box[0]) | (high > box[1])).any(axis=1)
    aside_px = _ASIDE * problem.grid.spacing_px
    most_px = _BEHIND * float(np.ptp(problem.target_px[: problem.movers], axis=0).max())
    wholes = _wholes(lines, units, lengths, near, aside_px, most_px, ends_outside)
    for index, whole in zip(near, wholes, strict=True):
        (start, _), unit, length = lines[index], units[index], lengths[index]
        count = max(2, int(np.ceil(length / step_px)) + 1)
        points = start + np.linspace(0.0, length, count)[:, None] * unit
        points = points[((points >= box[0]) & (points <= box[1])).all(axis=1)]
        yield points, np.tile([-unit[1], unit[0]], (len(points), 1)), np.full(len(points), whole)


def _wholes(
    lines: Array,
    units: Array,
    lengths: Array,
    near: npt.NDArray[np.int64],
    aside_px: float,
    most_px: float,
    pinned: npt.NDArray[np.bool_],
) -> npt.NDArray[np.int64]:
    """Return which line each of those near is a piece of, or none where the warp can't shift that.

    Lines are found in pieces, a shelf between the things on it.
    """
    normals = np.stack([-units[:, 1], units[:, 0]], axis=-1)
    mine = np.einsum("knec,kc->kne", lines - lines[near, None, :1], normals[near])
    others = np.einsum("knec,nc->kne", lines[near, None] - lines[:, :1], normals)
    ahead = np.einsum("knec,kc->kne", lines - lines[near, None, :1], units[near])
    gaps = np.maximum(ahead.min(axis=2) - lengths[near, None], -ahead.max(axis=2))
    longer = lengths[near, None] >= lengths
    pieces = np.where(longer, np.abs(mine).max(axis=2), np.abs(others).max(axis=2)) <= aside_px
    pieces &= gaps <= most_px
    # Without any line there is none to look for.
    wholes = np.where(pieces, lengths, -1.0).argmax(axis=1) if len(near) else near
    stuck = wholes[(pieces & pinned).any(axis=1)]
    return np.where(np.isin(wholes, stuck), _NOWHERE, wholes)


def _thinned(rows: HeldRows, step_px: float) -> HeldRows | None:
    """Return one row for each small square and direction, of squares so large that few are left."""
    turn = np.arctan2(rows.across[:, 1], rows.across[:, 0]) / np.pi * _DIRECTIONS
    turn = np.round(turn) % _DIRECTIONS
    while len(rows.away):
        keys = np.column_stack([np.floor(rows.places_px / step_px), turn])
        _, first = np.unique(keys, axis=0, return_index=True)
        if len(first) <= _MOST_ROWS:
            return rows.part(np.sort(first))
        step_px *= 2.0
    return None
