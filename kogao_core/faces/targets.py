"""Targets of a face: section 3.2 (`paper.targets`), and what a recipe adds to it.

Also compare two sets of landmarks on one photo, such as marked by hand and detected.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array, Box, curve
from kogao_core.faces.face import Face
from kogao_core.faces.head import pivot_and_share
from kogao_core.faces.zones import Shape, evened
from kogao_core.paper import targets as paper
from kogao_core.paper.targets import Pairs
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import CENTERS

_PER_STEP: Final = 64  # samples of an outline between two of its points
_HEAD_CENTER: Final = 2  # centre candidate for shaping faces with scope "head"


@dataclass(frozen=True, slots=True, eq=False)
class FacePairs(Pairs):
    """Pairs of a face that a lens may have displaced and whose head may shrink as one body."""

    # (N, 2): landmarks after lens correction only; None without a correction.
    seen_px: Array | None = None
    # Fraction by which the whole head shrinks about the centre; 0 with scope "face".
    head_share: float = 0.0

    @property
    def warp_distance_px(self) -> float:
        """Mean distance between landmarks and targets, without the lens correction."""
        return float(np.linalg.norm(self.start_px - self.target_px, axis=1).mean())

    @property
    def start_px(self) -> Array:
        """Landmarks before they move towards the centre, shape (N, 2), px."""
        return self.source_px if self.seen_px is None else self.seen_px

    @property
    def started(self) -> FacePairs:
        """The pairs without the part of the lens correction."""
        return dataclasses.replace(self, source_px=self.start_px, seen_px=None)


def center_candidates(face: Face) -> Array:
    """Return the centre candidates of a face, (len(CENTERS), 2), px; the paper's come first."""
    fractions = [candidate.fraction for candidate in CENTERS]
    return paper.center_candidates(face.eye_center, face.mouth_center, fractions)


def aim(
    face: Face, recipe: Recipe, seen: Face | None = None, photo: Box | None = None
) -> FacePairs:
    """Place each target ``percent`` of D along the line from its landmark to the centre (figure 6).

    With `Recipe.scope` "head", the lines meet at the head's pivot, and a head with too little space
    in the `photo` moves less (`head`). The order is: even out the sides, move towards the centre,
    add width, length and zones (`Shape`), replace by targets placed by hand (`Face.targets`).
    `Face.recipe` takes precedence over `recipe`. `seen` is the face after lens correction, if any.
    Result: one pair for each point of the outline.
    """
    recipe, source = recipe.of_face(face.recipe), face.outline
    face = seen or face
    middle = shape_center(face, recipe)
    start = evened(face, recipe.even_out)
    if recipe.scope == "head":
        center, share = pivot_and_share(face, recipe.percent, photo)
    else:
        center, share = middle, recipe.percent / 100.0
    target = paper.aim(start, center, share).target_px
    if (shape := Shape.of(face, recipe)) is not None:
        target = target - shape.inwards(start - middle)
    if face.targets is not None:
        target = np.where(np.isnan(face.targets), target, face.targets)
    head_share = share if recipe.scope == "head" else 0.0
    return FacePairs(source, target, center, None if seen is None else seen.outline, head_share)


def shape_center(face: Face, recipe: Recipe) -> Array:
    """Return the centre for shaping a face, (2,), px."""
    chosen = recipe.center if recipe.scope == "face" else _HEAD_CENTER
    return np.asarray(center_candidates(face)[int(chosen) - 1])


@dataclass(frozen=True, slots=True, eq=False)
class Differences:
    """Distances of the points of a face from the outline of another, px, (N,) each."""

    landmarks_px: Array
    targets_px: Array  # from the curve through the other's targets


def differences(first: Face, second: Face, recipes: tuple[Recipe, Recipe]) -> Differences:
    """Compare the landmarks and targets of two faces.

    A slide along the outline is no difference, so the numbers of points may differ. Result: for
    each outline point of the first face.
    """
    ours, theirs = aim(first, recipes[0]), aim(second, recipes[1])
    return Differences(
        _away_px(ours.source_px, theirs.source_px), _away_px(ours.target_px, theirs.target_px)
    )


def _away_px(points_px: Array, line_px: Array) -> Array:
    """Return the distance of points from the curve through the points of a line, px, (N,)."""
    line_px = np.vstack([curve(line_px, _PER_STEP), line_px[-1:]])
    return np.asarray(np.linalg.norm(points_px[:, None] - line_px, axis=2).min(axis=1))


def matching(face: Face, others: Sequence[Face]) -> int | None:
    """Return the index of the face in `others` at the position of `face`.

    Result: index of the nearest face; None if no face is near.
    """
    apart = [float(np.linalg.norm(other.middle - face.middle)) for other in others]
    if not apart:
        return None
    nearest = int(np.argmin(apart))
    return nearest if apart[nearest] < max(face.box[2:]) else None
