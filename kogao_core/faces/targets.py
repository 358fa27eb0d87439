"""Section 3.2: centre candidates on the eye-mouth line, and targets on the lines to the centre.

And how two sets of points on one photo differ: marked by hand, and found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.faces.face import Face
from kogao_core.faces.zones import Shape, evened, gains
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import CENTERS


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Feature points and where they go."""

    source_px: Array  # (N, 2): landmarks
    target_px: Array  # (N, 2): their target points
    center_px: Array  # (2,): the centre they move towards
    # (N, 2): landmarks where the lens' correction alone shows them; absent without one.
    seen_px: Array | None = None

    @property
    def displacement_px(self) -> Array:
        """Backward displacement at the targets, ``source - target``, shape (N, 2)."""
        return self.source_px - self.target_px

    @property
    def warp_distance_px(self) -> float:
        """Mean distance between landmarks and targets (figure 7b)."""
        return float(np.linalg.norm(self.start_px - self.target_px, axis=1).mean())

    @property
    def start_px(self) -> Array:
        """Where landmarks are before they move towards the centre, shape (N, 2)."""
        return self.source_px if self.seen_px is None else self.seen_px

    @property
    def started(self) -> Pairs:
        """What is left to do once the lens' correction is done."""
        return Pairs(self.start_px, self.target_px, self.center_px)


def center_candidates(face: Face) -> Array:
    """Return the centre candidates, those of figure 7a first, px.

    Result (len(CENTERS), 2): the first four from the mouth to the tip of the nose.
    """
    fractions = np.array([candidate.fraction for candidate in CENTERS])[:, None]
    return np.asarray(face.eye_center + fractions * (face.mouth_center - face.eye_center))


def aim(face: Face, recipe: Recipe, seen: Face | None = None) -> Pairs:
    """Place each target ``percent`` of D along the line from its landmark to the centre (figure 6).

    Targets that the user placed by hand (`Face.targets`) stay where they are; a face with a recipe
    of its own (`Face.recipe`) goes by that. Where the recipe's zones count, the outline's sides are
    evened out first, and each zone then goes its own share of ``percent`` (`zones`);
    width, length and the like come on top (`Shape`). A face that a lens' correction shows elsewhere
    (`seen`) is aimed there. Result: one pair for each point of the outline.
    """
    recipe, source = recipe.of_face(face.recipe), face.outline
    face = seen or face
    center = center_candidates(face)[int(recipe.center) - 1]
    start, share = face.outline, np.full((len(face.outline), 1), recipe.percent / 100.0)
    if recipe.zones:
        start = evened(face, recipe.even_out)
        share = share * gains(face, recipe)[:, None]
    target = start + share * (center - start)
    if (shape := Shape.of(face, recipe)) is not None:
        target = target - shape.inwards(start - center)
    if face.targets is not None:
        target = np.where(np.isnan(face.targets), target, face.targets)
    return Pairs(source, target, center, None if seen is None else seen.outline)


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
