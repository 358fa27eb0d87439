"""Table 1 of the paper: how many answers called a transformed face unnatural.

25 faces, each at 5 warp distances towards 4 centres, were shown to 32 students, who answered
"natural" or "unnatural". The paper concludes that the warp distance should stay below 6 % of D.
The faces alone had moved, by the paper's local field: of warps where what surrounds them goes
along, or eyes and mouth keep their shape, the table says nothing; nor of faces of which parts move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.faces.targets import Pairs
from kogao_core.recipe.recipe import Recipe

DISTANCES: Final = (2.0, 4.0, 6.0, 8.0, 10.0)  # % of D
SUBJECTS: Final = 25
STUDENTS: Final = 32
LARGEST_NATURAL: Final = 6.0  # % of D
# % of answers, a row for each centre candidate. 6.825 is as printed; every other figure is a
# multiple of 0.625, one answer in 160, so 6.875 may have been meant.
UNNATURAL: Final = (
    (0.625, 1.250, 6.250, 35.000, 67.500),
    (0.625, 0.000, 5.000, 29.375, 70.000),
    (1.250, 0.625, 5.000, 45.000, 76.875),
    (0.625, 4.375, 6.825, 44.375, 76.250),
)


@dataclass(frozen=True, slots=True)
class Naturalness:
    """A warp judged by table 1."""

    percent: float  # warp distance, % of D; below 0 the face gets larger, which nobody was asked
    # Share of answers that called such a face unnatural, %; a straight line between the published
    # distances, the nearest published value beyond them.
    unnatural: float
    published: bool  # false outside the distances and centres that were asked about
    # Whether the face alone moves, as those that were asked about did; if not, `unnatural` is of
    # another warp of the same distance.
    face_alone: bool = True
    # Whether all of the face moves alike; if not, `unnatural` says nothing, and `percent` is a mean
    # over parts that hardly move.
    whole_face: bool = True

    @property
    def beyond_limit(self) -> bool:
        """Whether the distance is beyond the paper's limit of 6 %."""
        # A distance measured from points may miss a round number by rounding.
        return self.percent > LARGEST_NATURAL + 1e-6

    @property
    def warns(self) -> bool:
        """True beyond the limit, which was found for faces that move alone."""
        return self.face_alone and self.whole_face and self.beyond_limit


def judge(
    percent: float, center: int, *, face_alone: bool = True, whole_face: bool = True
) -> Naturalness:
    """Look a warp distance in % of D up in Table 1.

    A centre candidate that nobody was asked about is judged by the worst row. Result: interpolated
    between the published distances.
    """
    asked = center <= len(UNNATURAL)
    rows = UNNATURAL[center - 1 : center] if asked else UNNATURAL
    unnatural = max(float(np.interp(percent, DISTANCES, row)) for row in rows)
    published = asked and DISTANCES[0] <= percent <= DISTANCES[-1]
    return Naturalness(percent, unnatural, published, face_alone, whole_face)


def percent_of(pairs: Pairs) -> float:
    """Return the mean warp distance of a face in % of D, targets placed by hand included.

    Result: below 0 where the face as a whole gets larger.
    """
    pairs = pairs.started
    outwards = pairs.source_px - pairs.center_px
    radius = np.linalg.norm(outwards, axis=1)
    moved = np.linalg.norm(pairs.displacement_px, axis=1)
    sign = -1.0 if (pairs.displacement_px * outwards).sum() < 0.0 else 1.0
    return sign * 100.0 * float((moved / np.maximum(radius, 1e-9)).mean())


def worst(faces: Sequence[tuple[Pairs, Recipe]]) -> Naturalness | None:
    """Judge the face with the largest warp distance by table 1; None without faces.

    Result: that of the face that moves most.
    """
    judged = [
        judge(
            percent_of(pairs),
            recipe.center,
            face_alone=recipe.face_alone,
            whole_face=recipe.whole_face,
        )
        for pairs, recipe in faces
    ]
    return max(judged, key=lambda one: one.percent, default=None)
