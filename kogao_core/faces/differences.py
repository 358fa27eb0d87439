"""How two sets of points on one photo differ: marked by hand, and found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.faces.face import Face
from kogao_core.faces.targets import aim
from kogao_core.recipe.recipe import Recipe


@dataclass(frozen=True, slots=True, eq=False)
class Differences:
    """Distances from each point of the first face to its partner on the second."""

    # Int (N,): index of the partner: the same one where both outlines have as many points, else the
    # nearest.
    partners: npt.NDArray[np.intp]
    # (N,): distance between partners, px.
    landmarks_px: Array
    targets_px: Array


def differences(first: Face, second: Face, recipes: tuple[Recipe, Recipe]) -> Differences:
    """Compare the landmarks and targets of two faces.

    Result: for each outline point of the first face.
    """
    ours, theirs = aim(first, recipes[0]), aim(second, recipes[1])
    between = np.linalg.norm(ours.source_px[:, None] - theirs.source_px, axis=2)
    same_count = len(ours.source_px) == len(theirs.source_px)
    partners = np.arange(len(between)) if same_count else between.argmin(axis=1)
    return Differences(
        partners,
        between[np.arange(len(between)), partners],
        np.linalg.norm(ours.target_px - theirs.target_px[partners], axis=1),
    )


def matching(face: Face, others: Sequence[Face]) -> int | None:
    """Return which of `others` lies where `face` lies.

    Result: index of the nearest; None when there is none near.
    """
    apart = [float(np.linalg.norm(other.middle - face.middle)) for other in others]
    if not apart:
        return None
    nearest = int(np.argmin(apart))
    return nearest if apart[nearest] < max(face.box[2:]) else None
