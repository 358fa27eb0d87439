"""Outlines as smooth curves, for mark-ups with other counts of points."""

from __future__ import annotations

from typing import Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.landmarks.outline import resampled

_STEPS: Final = 16  # straight pieces between two points of an outline


def along(line: Array, count: int) -> Array:
    """Return `count` points at equal steps along the smooth curve through a line (N, 2), N >= 2.

    The curve is Catmull and Rom's. Steps along the straight pieces would cut every bend: on an oval
    face 1.5 % of the inter-ocular distance are lost from 21 points to 17 and back. Result (count,
    2): the line's ends among them.
    """
    ends = 2.0 * line[[0, -1]] - line[[1, -2]]
    around = np.vstack([ends[:1], line, ends[1:]])
    before, first, last, after = (around[k : len(around) - 3 + k, None] for k in range(4))
    t = (np.arange(_STEPS) / _STEPS)[:, None]
    pieces = first + t / 2.0 * (
        last - before
        + t * (2.0 * before - 5.0 * first + 4.0 * last - after)
        + t**2 * (3.0 * (first - last) + after - before)
    )  # fmt: skip
    return resampled(np.vstack([pieces.reshape(-1, 2), line[-1:]]), count)


def shares_of(line: Array) -> Array:
    """Return how far along a line (N, 2) each of its points lies, 0 to 1.

    Result (N,): from 0 to 1, by length along straight pieces.
    """
    lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    return np.asarray(lengths / lengths[-1])


def placed(line: Array, shares: Array) -> Array:
    """Return the points that lie at shares of the way along the smooth curve through a line.

    `shares` (M,). Result (M, 2).
    """
    even = along(line, _STEPS * len(line))
    return np.column_stack(
        [np.interp(shares, np.linspace(0.0, 1.0, len(even)), even[:, axis]) for axis in (0, 1)]
    )
