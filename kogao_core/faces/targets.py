"""Section 3.2: centre candidates on the eye-mouth line, and targets on the lines to the centre."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.face import Face
from kogao_core.faces.shape import Shape
from kogao_core.faces.zones import evened, gains
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import CENTERS


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Feature points and where they go."""

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
        return float(np.linalg.norm(self.displacement_px, axis=1).mean())


def center_candidates(face: Face) -> Array:
    """Return the centre candidates, those of figure 7a first, px.

    Result (len(CENTERS), 2): the first four from the mouth to the tip of the nose.
    """
    fractions = np.array([candidate.fraction for candidate in CENTERS])[:, None]
    return np.asarray(face.eye_center + fractions * (face.mouth_center - face.eye_center))


def aim(face: Face, recipe: Recipe) -> Pairs:
    """Place each target ``percent`` of D along the line from its landmark to the centre (figure 6).

    Targets that the user placed by hand (`Face.targets`) stay where they are; a face with a recipe
    of its own (`Face.recipe`) goes by that. Where the recipe's zones count, the outline's sides are
    evened out first, and each zone then goes its own share of ``percent`` (`zones`);
    width, length and the like come on top (`shape`).
    Result: one pair for each point of the outline.
    """
    recipe = recipe.of_face(face.recipe)
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
    return Pairs(face.outline, target, center)
