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
    """Distances from each point of the first face to its partner on the second.

    Parameters
    ----------
    partners : int array of shape (N,)
        Index of the partner: the same one where both outlines have as many points, else the
        nearest.
    landmarks_px, targets_px : array of shape (N,)
        Distance between partners, px.
    """

    partners: npt.NDArray[np.intp]
    landmarks_px: Array
    targets_px: Array


def differences(first: Face, second: Face, recipes: tuple[Recipe, Recipe]) -> Differences:
    """Compare the landmarks and targets of two faces.

    Parameters
    ----------
    first, second : Face
        On the same photo.
    recipes : (Recipe, Recipe)
        That of each; they place automatic targets.

    Returns
    -------
    Differences
        For each outline point of the first face.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> from kogao_core.faces.differences import differences
    >>> first, second = (kogao.template_face((240 + x, 180), 200) for x in (0, 3))
    >>> found = differences(first, second, (kogao.Recipe(), kogao.Recipe()))
    >>> float(found.landmarks_px.max().round(6))
    3.0
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

    Parameters
    ----------
    face : Face
        The one to find again.
    others : sequence of Face
        On the same photo.

    Returns
    -------
    int, optional
        Index of the nearest; None when there is none near.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> from kogao_core.faces.differences import matching
    >>> here, there = (kogao.template_face((x, 180), 200) for x in (240, 900))
    >>> matching(here, [there, here])
    1
    """
    apart = [float(np.linalg.norm(other.middle - face.middle)) for other in others]
    if not apart:
        return None
    nearest = int(np.argmin(apart))
    return nearest if apart[nearest] < max(face.box[2:]) else None
