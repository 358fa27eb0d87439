"""Table 1: the share of answers that rated a transformed face unnatural.

The survey showed 25 faces, each at 5 warp distances towards 4 centres, to 32 students, who answered
"natural" or "unnatural". The paper concludes that the warp distance should stay below 6 % of D.
"""

from __future__ import annotations

from typing import Final

import numpy as np

DISTANCES: Final = (2.0, 4.0, 6.0, 8.0, 10.0)  # % of D
SUBJECTS: Final = 25  # faces of the survey
STUDENTS: Final = 32  # people who answered
LARGEST_NATURAL: Final = 6.0  # % of D
# % of answers, one row for each centre candidate. 6.825 is as printed. Every other value is a
# multiple of 0.625 (one answer in 160), so 6.875 may have been meant.
UNNATURAL: Final = (
    (0.625, 1.250, 6.250, 35.000, 67.500),
    (0.625, 0.000, 5.000, 29.375, 70.000),
    (1.250, 0.625, 5.000, 45.000, 76.875),
    (0.625, 4.375, 6.825, 44.375, 76.250),
)


def unnatural_percent(percent: float, center: int) -> float:
    """Look up a warp distance in % of D: the share of "unnatural" answers, %.

    Linear between the published distances, the nearest published value beyond. A centre without
    survey data has the worst row.
    """
    rows = UNNATURAL[center - 1 : center] if center <= len(UNNATURAL) else UNNATURAL
    return max(float(np.interp(percent, DISTANCES, row)) for row in rows)


def is_published(percent: float, center: int) -> bool:
    """Return whether the survey asked about this distance and this centre, or between two."""
    return center <= len(UNNATURAL) and DISTANCES[0] <= percent <= DISTANCES[-1]
