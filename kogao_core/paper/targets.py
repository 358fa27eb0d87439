"""Section 3.2: centre candidates on the eye-mouth line, and targets on the lines to the centre."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.paper.choices import FRACTIONS


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Landmarks of a face and their targets."""

    source_px: Array  # (N, 2): landmarks
    target_px: Array  # (N, 2): their target points
    center_px: Array  # (2,): the centre they move towards

    @property
    def displacement_px(self) -> Array:
        """Backward displacement at the targets, ``source - target``, shape (N, 2)."""
        return self.source_px - self.target_px

    @property
    def warp_distance_px(self) -> float:
        """Mean distance between landmarks and targets (figure 7b)."""
        return float(np.linalg.norm(self.source_px - self.target_px, axis=1).mean())


def center_candidates(
    eyes_px: Array, mouth_px: Array, fractions: Sequence[float] = FRACTIONS
) -> Array:
    """Return the centre candidates on the line from the eyes' centre to the mouth's, (C, 2), px."""
    return np.asarray(eyes_px + np.array(fractions)[:, None] * (mouth_px - eyes_px))


def aim(landmarks_px: Array, center_px: Array, share: float = 0.04) -> Pairs:
    """Place each target at a `share` of D along the line from its landmark to the centre.

    D is the distance between landmark and centre (figures 6, 7b); the paper chooses 4 %.
    """
    return Pairs(landmarks_px, landmarks_px + share * (center_px - landmarks_px), center_px)
