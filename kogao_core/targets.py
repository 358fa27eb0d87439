"""Section 3.2: centre candidates on the eye-mouth line, and targets on the lines to the centre."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kogao_core.face import Face
from kogao_core.geometry import Array
from kogao_core.recipe import CENTERS, Recipe


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Feature points and where they go.

    Parameters
    ----------
    source_px : array of shape (N, 2)
        Landmarks.
    target_px : array of shape (N, 2)
        Their target points.
    center_px : array of shape (2,)
        The centre they move towards.
    """

    source_px: Array
    target_px: Array
    center_px: Array

    @property
    def pull_px(self) -> Array:
        """Backward displacement at the targets, ``source - target``, shape (N, 2)."""
        return self.source_px - self.target_px

    @property
    def warp_distance_px(self) -> float:
        """Mean distance between landmarks and targets (figure 7b)."""
        return float(np.linalg.norm(self.pull_px, axis=1).mean())


def center_candidates(face: Face) -> Array:
    """Return the centre candidates, those of figure 7a first, shape (len(CENTERS), 2), px."""
    fractions = np.array(CENTERS)[:, None]
    return np.asarray(face.eye_center + fractions * (face.mouth_center - face.eye_center))


def aim(face: Face, recipe: Recipe) -> Pairs:
    """Place each target ``percent`` of D along the line from its landmark to the centre (figure 6).

    Targets that the user placed by hand (`Face.targets`) stay where they are; a face with a recipe
    of its own (`Face.recipe`) goes by that.
    """
    recipe = recipe.of_face(face.recipe)
    center = center_candidates(face)[int(recipe.center) - 1]
    target = face.outline + recipe.percent / 100.0 * (center - face.outline)
    if face.targets is not None:
        target = np.where(np.isnan(face.targets), target, face.targets)
    return Pairs(face.outline, target, center)
