"""Distances between landmarks and labels, in % of the outer inter-ocular distance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, frozen
from kogao_core.faces.face import Face

_EYES: Final = slice(0, 4)
_MOUTH: Final = slice(4, 6)
_JAW: Final = slice(6, None)
# Faces with nearer centres are the same, in outer inter-ocular distances. Neighbours are over 1.
_SAME_FACE: Final = 0.5


@dataclass(frozen=True, eq=False)
class Labels:
    """One face as labelled by hand, px."""

    eyes: Array  # (4, 2): left eye outer and inner corner, right eye inner and outer corner
    mouth: Array  # (2, 2): left and right mouth corner
    # (N, 2): points along the visible outline, N >= 2. A correct outline may continue beyond the
    # labelled points.
    jaw: Array
    # (6 + N,) of bool: False for hidden points, which are guesses and never scored.
    seen: npt.NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "eyes", frozen(self.eyes, (4, 2)))
        object.__setattr__(self, "mouth", frozen(self.mouth, (2, 2)))
        object.__setattr__(self, "jaw", frozen(self.jaw, (None, 2)))

    @classmethod
    def of(cls, one: Mapping[str, Any], corner: npt.ArrayLike = (0.0, 0.0)) -> Labels:
        """Return one pass of a face of ``tests/labels/faces.json``; its crop begins at `corner`."""
        names, hidden = ("eyes", "mouth", "outline"), one.get("hidden", {})
        seen = [~np.isin(range(len(one[name])), hidden.get(name, ())) for name in names]
        eyes, mouth, jaw = (np.add(one[name], corner) for name in names)
        return cls(eyes, mouth, jaw, np.concatenate(seen))

    @cached_property
    def unit_px(self) -> float:
        """One percent of the distance between the outer eye corners."""
        return float(np.linalg.norm(self.eyes[3] - self.eyes[0])) / 100.0

    @cached_property
    def center_px(self) -> Array:
        """Middle between eyes and mouth, (x, y)."""
        return np.asarray((self.eyes.mean(axis=0) + self.mouth.mean(axis=0)) / 2.0)

    def in_percent(self, distances_px: Sequence[Array]) -> Errors:
        """Return the mean distances of the visible points (eyes, mouth, jaw), in % of the unit."""
        distances = np.concatenate(distances_px) / self.unit_px
        if self.seen is not None:
            distances[~np.asarray(self.seen)] = np.nan
        return Errors(*(_mean(distances[part]) for part in (_EYES, _MOUTH, _JAW)))


class Errors(NamedTuple):
    """Mean distances of one face's points, % of the outer inter-ocular distance; NaN if unseen."""

    eyes: float
    mouth: float
    jaw: float


class Summary(NamedTuple):
    """Statistics of the errors of many faces; NaN without faces."""

    mean: float
    p95: float
    worst: float


def distance_to_line(points: Array, line: Array) -> Array:
    """Return the distance of each point, shape (N, 2), to a polyline, shape (M, 2), M >= 2."""
    start, along = line[:-1], np.diff(line, axis=0)
    length = np.maximum((along**2).sum(axis=-1), 1e-12)
    t = np.clip(((points[:, None] - start) * along).sum(axis=-1) / length, 0.0, 1.0)
    return np.asarray(
        np.linalg.norm(points[:, None] - start - t[..., None] * along, axis=-1).min(axis=1)
    )


def errors(face: Face, labels: Labels) -> Errors:
    """Return a face's errors: corner to corner, and labelled jaw points to the open outline."""
    return _apart(labels, face, face.outline)


def repeatability(first: Labels, second: Labels) -> Errors:
    """Return the distance between two passes of labels, both ways: the lower limit of `errors`."""
    ways = [_apart(first, second, second.jaw), _apart(second, first, first.jaw)]
    return Errors(*(float(value) for value in np.mean(ways, axis=0)))


def _apart(labels: Labels, other: Face | Labels, line: Array) -> Errors:
    return labels.in_percent(
        [
            np.linalg.norm(other.eyes - labels.eyes, axis=1),
            np.linalg.norm(other.mouth - labels.mouth, axis=1),
            distance_to_line(labels.jaw, line),
        ]
    )


def nearest(faces: Sequence[Face], labels: Labels) -> Face | None:
    """Return the face at the position of the labels, or None."""

    def apart(face: Face) -> float:
        return float(np.linalg.norm(face.middle - labels.center_px)) / (100.0 * labels.unit_px)

    near = [face for face in faces if apart(face) < _SAME_FACE]
    return min(near, key=apart, default=None)


def summary(values: npt.ArrayLike) -> Summary:
    """Return mean, 95th percentile and maximum of values; ignore NaN."""
    kept = np.asarray(values, np.float64)
    kept = kept[~np.isnan(kept)]
    if not len(kept):
        return Summary(np.nan, np.nan, np.nan)
    return Summary(float(kept.mean()), float(np.percentile(kept, 95)), float(kept.max()))


def share_below(values: npt.ArrayLike, limits: npt.ArrayLike) -> Array:
    """Return the share of values at or below each limit, 0 to 1; a missed face's value is inf."""
    ordered = np.sort(np.asarray(values, np.float64))
    ordered = ordered[~np.isnan(ordered)]
    return np.searchsorted(ordered, np.asarray(limits), side="right") / max(1, len(ordered))


def area_under_curve(low: Array, high: Array) -> float:
    """Return how often a value of `low` is below one of `high`; 0.5 is chance, NaN if empty."""
    if not len(low) or not len(high):
        return float("nan")
    return float((low[:, None] < high).mean() + 0.5 * (low[:, None] == high).mean())


def _mean(values: Array) -> float:
    seen = values[~np.isnan(values)]
    return float(seen.mean()) if len(seen) else float("nan")
