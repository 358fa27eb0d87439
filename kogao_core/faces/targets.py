"""Section 3.2: centre candidates on the eye-mouth line, and targets on the lines to the centre."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.face import Face
from kogao_core.faces.symmetry import evened
from kogao_core.faces.zones import gains
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import CENTERS


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
    def displacement_px(self) -> Array:
        """Backward displacement at the targets, ``source - target``, shape (N, 2)."""
        return self.source_px - self.target_px

    @property
    def warp_distance_px(self) -> float:
        """Mean distance between landmarks and targets (figure 7b)."""
        return float(np.linalg.norm(self.displacement_px, axis=1).mean())


def center_candidates(face: Face) -> Array:
    """Return the centre candidates, those of figure 7a first, px.

    Parameters
    ----------
    face : Face
        Its eye and mouth corners count.

    Returns
    -------
    array of shape (len(CENTERS), 2)
        The first four from the mouth to the tip of the nose.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> from kogao_core.faces.targets import center_candidates
    >>> face = kogao.template_face((240, 180), 200)
    >>> center_candidates(face)[:4].round(1)
    array([[240. , 195.2],
           [240. , 175.9],
           [240. , 156.7],
           [240. , 144.2]])
    """
    fractions = np.array([candidate.fraction for candidate in CENTERS])[:, None]
    return np.asarray(face.eye_center + fractions * (face.mouth_center - face.eye_center))


def aim(face: Face, recipe: Recipe) -> Pairs:
    """Place each target ``percent`` of D along the line from its landmark to the centre (figure 6).

    Targets that the user placed by hand (`Face.targets`) stay where they are; a face with a recipe
    of its own (`Face.recipe`) goes by that. Where the recipe's zones count, the outline's sides are
    evened out first (`symmetry`), and each zone then goes its own share of ``percent`` (`zones`).

    Parameters
    ----------
    face : Face
        Landmarks, and targets placed by hand where it has some.
    recipe : Recipe
        Of it, `percent`, `center` and what it says of zones.

    Returns
    -------
    Pairs
        One pair for each point of the outline.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> from kogao_core.faces.targets import aim
    >>> face = kogao.template_face((240, 180), 200)
    >>> pairs = aim(face, kogao.Recipe(percent=10, center=2))
    >>> (pairs.center_px, face.outline[10], pairs.target_px[10].round(1))
    (array([240.  , 175.94]), array([240. , 262.4]), array([240. , 253.8]))
    >>> round(pairs.warp_distance_px, 2)
    9.65
    """
    recipe = recipe.of_face(face.recipe)
    center = center_candidates(face)[int(recipe.center) - 1]
    start, share = face.outline, np.full((len(face.outline), 1), recipe.percent / 100.0)
    if recipe.zones:
        start = evened(face, recipe.even_out)
        share = share * gains(face, recipe)[:, None]
    target = start + share * (center - start)
    if face.targets is not None:
        target = np.where(np.isnan(face.targets), target, face.targets)
    return Pairs(face.outline, target, center)
