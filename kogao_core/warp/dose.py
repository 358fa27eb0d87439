"""How far a face comes towards its centre, asked and achieved, in % of D (figures 6 and 7b).

The percentage of a recipe places targets. What the field makes of them is another number: a fit
that approximates goes past some targets and stays short of others, neighbours' fields add up, and
guard, fade and protected places hold back.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.targets import Pairs
from kogao_core.warp.field import Field, shown_at


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
