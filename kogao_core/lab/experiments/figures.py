"""Draw the paper's figures from any photo: points, lattice, domains, result."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np

from kogao_core.base.display import rgb8
from kogao_core.base.geometry import Affine, Array, Box, Image
from kogao_core.faces.face import Face
from kogao_core.faces.naturalness import DISTANCES
from kogao_core.faces.targets import aim, center_candidates
from kogao_core.lab.reports.drawing import Dots, Drawing, Mark, Strokes, Word
from kogao_core.lab.subjects import Subject, at_paper_size
from kogao_core.pipeline import Rendering, render
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import DOMAINS, PAPER_CENTERS
from kogao_core.warp.domain import mask_of
from kogao_core.warp.lattice import Lattice

LANDMARK: Final = "#56b4e9"
TARGET: Final = "#d55e00"
CENTER: Final = "#f0e442"
LATTICE: Final = "#cc79a7"
_INK: Final = "#202020"
_GAP: Final = 0.0125  # gap between pictures, relative to the width
_LETTER: Final = 0.02  # height of letters, relative to the width
_DOT: Final = 0.004  # radius of dots, relative to the width
_PROCESSED, _LEFT_OUT = 150, 255  # greys of figures 14 and 15
_NEVER_ZERO: Final = 1e-9


def figures(subject: Subject, recipe: Recipe, width_px: int) -> list[Drawing]:
    """Draw figures 2, 4 to 7 and 14 to 16 of the paper with a photo."""
    shown = pictured(subject, width_px)
    rendering = render(shown.pixels, shown.faces, recipe)
    made = (landmarks, centers, lattice, domains, before_after, directions)
    return [draw(shown, rendering) for draw in made]


def pictured(subject: Subject, width_px: int) -> Subject:
    """Return the subject cropped to 4 : 3 around the faces, `width_px` wide, 8-bit RGB."""
    paper = at_paper_size(subject)
    width, height = paper.size
    size = (width_px, round(height * width_px / width))
    kernel = cv2.INTER_AREA if width_px < width else cv2.INTER_CUBIC
    pixels = np.asarray(cv2.resize(rgb8(paper.pixels), size, interpolation=kernel))
    onto = Affine.resize(size[0] / width, size[1] / height)
    return Subject(paper.name, pixels, tuple(face.mapped(onto) for face in paper.faces))


def landmarks(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the 27 feature points and the targets of the outline (figures 4a and 5b)."""
    dot = _DOT * shown.size[0]
    marks: list[Mark] = []
    for face, pairs in zip(shown.faces, rendering.pairs, strict=True):
        moves = np.stack([pairs.source_px, pairs.target_px], axis=1)
        marks += [
            Strokes(moves, 1.5, TARGET),
            Dots(pairs.target_px, dot, TARGET, filled=False),
            Dots(pairs.source_px, dot, LANDMARK),
            Dots(np.vstack([face.eyes, face.mouth]), 0.8 * dot, _INK),
        ]
    return Drawing("landmarks", shown.pixels, tuple(marks))


def centers(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the centre candidates and the five warp distances towards the chosen one (figure 7)."""
    marks: list[Mark] = []
    for face in shown.faces:
        recipe = rendering.recipe.of_face(face.recipe)
        marks += _distances(face, recipe, shown.size[0]) + _candidates(face, shown.size[0])
    return Drawing("centers", shown.pixels, tuple(marks))


def _candidates(face: Face, width_px: int) -> list[Mark]:
    dot = _DOT * width_px
    line = np.array([[face.eye_center, face.mouth_center]])
    candidates = center_candidates(face)[: len(PAPER_CENTERS)]
    words = [
        Word((float(x + 2.0 * dot), float(y + dot)), str(number), 3.0 * dot, _INK)
        for number, (x, y) in enumerate(candidates, start=1)
    ]
    return [Strokes(line, 1.5, CENTER), Dots(candidates, dot, CENTER), *words]


def _distances(face: Face, recipe: Recipe, width_px: int) -> list[Mark]:
    dot = _DOT * width_px
    automatic = dataclasses.replace(face, targets=None, recipe=None)
    targets = [
        aim(automatic, dataclasses.replace(recipe, percent=percent)).target_px
        for percent in DISTANCES
    ]
    rays = np.stack([face.outline, targets[-1]], axis=1)
    return [
        Strokes(rays, 1.0, TARGET),
        *(Dots(points, 0.3 * dot, TARGET) for points in targets),
        Dots(face.outline, dot, LANDMARK),
    ]


def lattice(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the control lattice and the control points other than zero (figure 2)."""
    dot = _DOT * shown.size[0]
    marks: list[Mark] = []
    for one in rendering.field.lattices:
        marks += [Strokes(_grid_lines(one), 1.0, LATTICE), *_control_points(one, dot)]
    return Drawing("lattice", shown.pixels, tuple(marks))


def _nodes(one: Lattice) -> tuple[Array, Array]:
    rows, columns = one.shape
    grid = one.grid
    return grid.nodes_px(one.first[0], columns, 0), grid.nodes_px(one.first[1], rows, 1)


def _grid_lines(one: Lattice) -> Array:
    xs, ys = _nodes(one)
    upright = [[(x, ys[0]), (x, ys[-1])] for x in xs]
    level = [[(xs[0], y), (xs[-1], y)] for y in ys]
    return np.array(upright + level)


def _control_points(one: Lattice, dot: float) -> list[Mark]:
    xs, ys = _nodes(one)
    at = np.dstack(np.meshgrid(xs, ys)).reshape(-1, 2)
    moves = one.magnitude_px.ravel() > _NEVER_ZERO
    tips = at[moves] + one.phi.reshape(-1, 2)[moves]
    return [
        Strokes(np.stack([at[moves], tips], axis=1), 1.5, TARGET),
        Dots(at[~moves], 0.5 * dot, LATTICE, filled=False),
        Dots(at[moves], 0.8 * dot, LATTICE),
    ]


def domains(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the three domains: image, control points, threshold (figures 14 and 15)."""
    image = Box.of(shown.pixels)
    threshold_px = rendering.recipe.threshold_px
    panels = [_mask(mask_of(rendering.field, image, one.name, threshold_px)) for one in DOMAINS]
    return _side_by_side("domains", panels)


def _mask(mask: Image) -> Image:
    grey = np.where(mask, np.uint8(_PROCESSED), np.uint8(_LEFT_OUT))
    framed = cv2.copyMakeBorder(grey[1:-1, 1:-1], 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=(0,))
    return np.dstack([framed] * 3)


def before_after(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the photo and the result side by side (figure 16)."""
    return _side_by_side("before-after", [shown.pixels, rendering.pixels])


def directions(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the lines from the landmarks to the centre, with the targets (figure 6)."""
    dot = _DOT * shown.size[0]
    marks: list[Mark] = []
    for face, pairs in zip(shown.faces, rendering.pairs, strict=True):
        ends = np.broadcast_to(pairs.center_px, pairs.source_px.shape)
        marks += [
            Strokes(np.array([[face.eye_center, face.mouth_center]]), 1.5, CENTER),
            Strokes(np.stack([pairs.source_px, ends], axis=1), 1.0, TARGET),
            Dots(pairs.target_px, dot, TARGET, filled=False),
            Dots(pairs.source_px, dot, LANDMARK),
            Dots(pairs.center_px[None], 1.5 * dot, CENTER),
        ]
    return Drawing("directions", shown.pixels, tuple(marks))


def _side_by_side(name: str, panels: Sequence[Image]) -> Drawing:
    height, width = panels[0].shape[:2]
    gap = round(_GAP * width)
    each = (width - gap * (len(panels) - 1)) // len(panels)
    size = (each, round(height * each / width))
    space = np.full((size[1], gap, 3), 255, np.uint8)
    row: list[Image] = []
    for panel in panels:
        row += [np.asarray(cv2.resize(panel, size, interpolation=cv2.INTER_AREA)), space]
    letter_px = _LETTER * width
    words = [
        Word((n * (each + gap) + 0.5 * letter_px, 1.5 * letter_px), f"({letter})", letter_px, _INK)
        for n, letter in zip(range(len(panels)), "abcd", strict=False)
    ]
    return Drawing(name, np.hstack(row[:-1]), tuple(words))
