"""Rate the warp of a photo by table 1 (`paper.table1`).

The survey's faces moved alone, by the paper's local field. The table has no data for warps of the
whole head, for preserved eyes and mouths, or for single parts of a face.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.faces.targets import FacePairs
from kogao_core.paper.table1 import LARGEST_NATURAL, is_published, unnatural_percent
from kogao_core.recipe.recipe import Recipe

# Most error of the contour between landmarks, in warp distances. In the paper's pictures (R = 1) it
# is 0.15 to 0.29; at R = 0.25 about 1.1: the contour keeps its place between landmarks (figure 11).
_MOST_MISSED: Final = 0.4


@dataclass(frozen=True, slots=True)
class Naturalness:
    """The rating of a warp by table 1."""

    percent: float  # warp distance, % of D; below 0 (a larger face) the survey has no data
    # Share of "unnatural" answers, %: interpolated linearly between the published distances, and
    # the nearest published value beyond.
    unnatural: float
    published: bool  # False outside the surveyed distances and centres
    # True if the face moves alone, as in the survey. False: `unnatural` belongs to another warp of
    # the same distance.
    face_alone: bool = True
    # True if all of the face moves alike. False: `unnatural` does not apply, and `percent` is a
    # mean that includes parts without movement.
    whole_face: bool = True
    # False if the contour misses its displacement by more than in the survey's pictures:
    # `unnatural` does not apply.
    contour_follows: bool = True

    @property
    def beyond_limit(self) -> bool:
        """Whether the distance is beyond the paper's limit of 6 %."""
        # A distance computed from points may exceed a round number by rounding.
        return self.percent > LARGEST_NATURAL + 1e-6

    @property
    def warns(self) -> bool:
        """True if the face moves alone and the distance is beyond the limit."""
        return self.face_alone and self.whole_face and self.beyond_limit


def judge(
    percent: float, center: int, *, face_alone: bool = True, whole_face: bool = True
) -> Naturalness:
    """Look up a warp distance in % of D in Table 1.

    Centre candidates without survey data use the worst row. Result: interpolated between the
    published distances.
    """
    unnatural, published = unnatural_percent(percent, center), is_published(percent, center)
    return Naturalness(percent, unnatural, published, face_alone, whole_face)


def percent_of(pairs: FacePairs) -> float:
    """Return the mean warp distance of a face in % of D, including targets placed by hand.

    Result: below 0 where the face as a whole gets larger.
    """
    pairs = pairs.started
    outwards = pairs.source_px - pairs.center_px
    radius = np.linalg.norm(outwards, axis=1)
    moved = np.linalg.norm(pairs.displacement_px, axis=1)
    sign = -1.0 if (pairs.displacement_px * outwards).sum() < 0.0 else 1.0
    return sign * 100.0 * float((moved / np.maximum(radius, 1e-9)).mean())


def worst(faces: Sequence[tuple[FacePairs, Recipe]], missed_px: float = 0.0) -> Naturalness | None:
    """Rate the face with the largest warp distance by table 1; None without faces.

    `missed_px`: largest error of the displacement on the contours (`Residual.contour_max_px`).
    """
    judged = [
        dataclasses.replace(
            judge(
                percent_of(pairs),
                recipe.center,
                face_alone=recipe.scope == "face",
                whole_face=recipe.whole_face,
            ),
            contour_follows=missed_px <= _MOST_MISSED * pairs.warp_distance_px,
        )
        for pairs, recipe in faces
    ]
    return max(judged, key=lambda one: one.percent, default=None)
