"""What a warp makes of a face: lengths before and after, and how far it comes to its centre.

How far is asked and achieved in % of D (figures 6 and 7b). The percentage of a recipe places
targets. What the field makes of them is another number: a fit that approximates goes past some
targets and stays short of others, neighbours' fields add up, and guard, fade and protected places
hold back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across
from kogao_core.faces.targets import Pairs
from kogao_core.warp.field import Field, shown_at


@dataclass(frozen=True, slots=True)
class FaceMeasures:
    """Lengths of one face, px of its picture."""

    width_px: float  # of the outline where it is widest, across the face's midline
    jaw_px: float  # of the outline at the height of the mouth's corners
    area_px2: float  # inside the outline, closed by the line between its ends
    interocular_px: float  # between the outer corners of the eyes

    @property
    def jaw_to_eyes(self) -> float:
        """Jaw width in shares of the distance between the outer corners of the eyes."""
        return self.jaw_px / self.interocular_px


def measures(face: Face) -> FaceMeasures:
    """Measure a face."""
    right = across(face)
    down = np.array([-right[1], right[0]])
    x, y = (face.outline - face.middle) @ right, (face.outline - face.middle) @ down
    level = float(((face.mouth - face.middle) @ down).mean())
    turned = np.roll(face.outline, -1, axis=0)
    area = (face.outline[:, 0] * turned[:, 1] - turned[:, 0] * face.outline[:, 1]).sum() / 2.0
    return FaceMeasures(
        float(np.ptp(x)), _width_at(x, y, level), abs(float(area)), face.interocular_px
    )


def _width_at(x: Array, y: Array, level: float) -> float:
    """Return the width of an outline at a height, between the first and the last crossing of it."""
    below = y >= level
    crossings = np.flatnonzero(below[1:] != below[:-1])
    if len(crossings) < 2:
        return float(np.ptp(x))
    ends = crossings[[0, -1]]
    share = (level - y[ends]) / (y[ends + 1] - y[ends])
    at = x[ends] + share * (x[ends + 1] - x[ends])
    return float(abs(at[1] - at[0]))


def moved(face: Face, field: Field, pairs: Pairs) -> Face:
    """Return a face where the result shows it."""
    return Face(
        shown_at(field, face.outline, pairs.target_px),
        shown_at(field, face.eyes),
        shown_at(field, face.mouth),
        forehead=None if face.forehead is None else shown_at(field, face.forehead),
        source=face.source,
    )


def asked_percent(pairs: Pairs) -> float:
    """Return `toward_center_percent` of the targets: the recipe's percentage, without drags.

    Result: %.
    """
    return toward_center_percent(pairs, pairs.target_px)


def achieved_percent(field: Field, pairs: Sequence[Pairs]) -> tuple[float, ...]:
    """Return `toward_center_percent` of the places where the result shows the landmarks.

    Result: %, one for each face.
    """
    if not pairs:
        return ()
    sources = np.concatenate([p.source_px for p in pairs])
    targets = np.concatenate([p.target_px for p in pairs])
    ends = np.cumsum([len(p.source_px) for p in pairs])
    moved = np.split(shown_at(field, sources, targets), ends[:-1])
    return tuple(toward_center_percent(p, mine) for p, mine in zip(pairs, moved, strict=True))


def toward_center_percent(pairs: Pairs, moved_px: Array) -> float:
    """Return how far landmarks have come towards the centre: the mean over them, in % of D.

    For a landmark p with centre c, ``D = |c - p|`` and place p' it is ``(p' - p) . (c - p) / D^2``:
    positive inwards, negative outwards, 0 for what moves across.
    """
    toward = pairs.center_px - pairs.start_px
    along = ((moved_px - pairs.start_px) * toward).sum(axis=1)
    squared = np.maximum(
        (toward**2).sum(axis=1), 1e-18
    )  # a landmark on the centre can't come closer
    return 100.0 * float((along / squared).mean())
