"""Beside table 1: what the warp does to a face, in numbers that know nothing of whose face it is.

The paper asked people which pictures look unnatural. For the same grid of centres and distances,
and for the lattice sizes of figure 11, this measures the warp itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from kogao_core.background.lines import bends, off_faces, straight_lines
from kogao_core.base.geometry import Array, Box
from kogao_core.faces.targets import Pairs
from kogao_core.lab.study.design import Variant, variants
from kogao_core.lab.subjects import Progress, Subject, no_progress
from kogao_core.pipeline import Rendering, render
from kogao_core.recipe.recipe import PAPER, Recipe
from kogao_core.warp.field import Field, shown_at
from kogao_core.warp.samples import largest_det

RULES: Final = 16  # straight lines drawn each way
_ROUND: Final = 0.25  # of the faces' box is added round them for these lines
_LOCAL_STEPS: Final = 200  # samples of det J along each side of the domain


@dataclass(frozen=True, slots=True)
class Distortion:
    """What one variant does to one photo."""

    photo: str  # its name
    variant: Variant  # centre, distance and lattice
    # Mean lattice spacing, and mean warp distance, of the faces.
    spacing_px: float
    warp_px: float
    # How far landmarks come towards the centre, mean over the faces, in % of D
    # (`kogao_core.warp.dose`); the variant's percentage was asked for.
    achieved: float
    # Area inside the outline after the warp over the area before it, minus 1, in %.
    face_area: float
    # Root mean square of local changes of area, |det J - 1|, where pixels move, in %.
    local_area: float
    # Smallest and largest Jacobian determinant of the backward field, of 8 x 8 samples a lattice
    # cell: below 1 the picture is stretched, 0 or less is a fold; above 1 it is compressed.
    min_det: float
    max_det: float
    folds: bool  # whether it folds
    # How far the worst straight line of a grid over and round the faces departs from straight, in %
    # of the distance between the eyes' outer corners.
    bend: float
    # The same of the worst line found in the photo beside the faces, on hair and collars, too: a
    # studio portrait has no others.
    photo_bend: float | None
    # How far the field at the targets misses what they ask for, on average, and the outline between
    # them its curve's, at worst, in % of the same; and how far landmarks land from their targets.
    residual: float
    contour: float
    landing: float


@dataclass(frozen=True, slots=True)
class DistortionResult:
    """Table 1's grid and figure 11's sizes on some photos, made after one recipe."""

    distortions: tuple[Distortion, ...]
    recipe: Recipe

    def of(self, variant: Variant) -> list[Distortion]:
        """Return what one variant does to each photo."""
        return [one for one in self.distortions if one.variant == variant]


def shown(recipe: Recipe) -> tuple[Variant, ...]:
    """Return the 20 variants of table 1 and the 4 lattice sizes."""
    return variants(recipe, satisfaction=False)


def measure(
    subject: Subject, recipe: Recipe = PAPER, *, progress: Progress = no_progress
) -> list[Distortion]:
    """Measure one photo at each centre and distance of table 1 and each lattice of figure 11."""
    found = []
    chosen = shown(recipe)
    lines = _LinesOf(subject)
    for done, variant in enumerate(chosen, start=1):
        rendering = render(subject.pixels, subject.faces, variant.recipe(recipe))
        found.append(_distortion(subject, variant, rendering, lines))
        progress(done, len(chosen))
    return found


def _distortion(
    subject: Subject, variant: Variant, rendering: Rendering, lines: _LinesOf
) -> Distortion:
    field, sound, miss = rendering.field, rendering.one_to_one, rendering.residual
    eyes = 100.0 / subject.interocular_px
    outlines = [face.outline for face in subject.faces]
    before = sum(map(_area, outlines))
    after = sum(_area(shown_at(field, outline)) for outline in outlines)
    drawn = bends(field, lines.ruled)
    own = bends(field, lines.near(rendering.domain.bounds))
    return Distortion(
        photo=subject.name,
        variant=variant,
        spacing_px=float(np.mean([a.grid.spacing_px for a in field.lattices])),
        warp_px=float(np.mean([pairs.warp_distance_px for pairs in rendering.pairs])),
        achieved=float(np.mean(rendering.achieved)),
        face_area=100.0 * (after / before - 1.0),
        local_area=100.0 * _local_area(rendering),
        min_det=sound.min_det,
        max_det=largest_det(field),
        folds=sound.folds,
        bend=eyes * drawn[0].bend_px,
        photo_bend=eyes * own[0].bend_px if own else None,
        residual=eyes * miss.mean_px,
        contour=eyes * miss.contour_max_px,
        landing=eyes * float(np.mean([_landing_px(field, pairs) for pairs in rendering.pairs])),
    )


def _landing_px(field: Field, pairs: Pairs) -> float:
    landed = shown_at(field, pairs.source_px, pairs.target_px)
    return float(np.linalg.norm(landed - pairs.target_px, axis=1).mean())


class _LinesOf:
    """Straight lines to bend: those ruled over the faces, and the photo's own beside them."""

    def __init__(self, subject: Subject) -> None:
        self.ruled = _grid(np.vstack([face.points for face in subject.faces]))
        found = straight_lines(subject.pixels)
        self._own = off_faces(found, [face.points for face in subject.faces])

    def near(self, box: Box) -> Array:
        """Return the photo's own lines whose bounding box meets `box`."""
        low, high = self._own.min(axis=1), self._own.max(axis=1)
        over = (low[:, 0] < box.right) & (high[:, 0] >= box.left)
        return np.asarray(self._own[over & (low[:, 1] < box.bottom) & (high[:, 1] >= box.top)])


def _grid(points: Array) -> Array:
    """Return straight lines evenly over and round points, shape (2 RULES, 2, 2)."""
    low, high = points.min(axis=0), points.max(axis=0)
    low, high = low - _ROUND * (high - low), high + _ROUND * (high - low)
    xs, ys = np.linspace(low, high, RULES).T
    upright = [((x, low[1]), (x, high[1])) for x in xs]
    level = [((low[0], y), (high[0], y)) for y in ys]
    return np.array(upright + level, np.float64)


def _area(outline: Array) -> float:
    return float(cv2.contourArea(outline.astype(np.float32)))


def _local_area(rendering: Rendering) -> float:
    box = rendering.domain.bounds
    if not box.area:
        return 0.0
    xs = np.linspace(box.left, box.right - 1, _LOCAL_STEPS)
    ys = np.linspace(box.top, box.bottom - 1, _LOCAL_STEPS)
    displacement = rendering.field.on_grid(xs, ys)
    moves = np.hypot(displacement[0], displacement[1]) > rendering.threshold_px
    change = rendering.field.det_jacobian(xs, ys)[moves] - 1.0
    return float(np.sqrt(np.square(change).mean())) if change.size else 0.0
