"""Draw the paper's figures from any photo, except the survey's."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Final

import cv2
import numpy as np

from kogao_core.base.display import rgb8
from kogao_core.base.geometry import Affine, Array, Box, Image
from kogao_core.faces.face import Face
from kogao_core.faces.naturalness import DISTANCES
from kogao_core.faces.targets import Pairs, aim, center_candidates
from kogao_core.lab.reports.drawing import Dots, Drawing, Mark, Strokes, Word
from kogao_core.lab.study.design import LATTICES
from kogao_core.lab.subjects import Subject, at_paper_size
from kogao_core.pipeline import Rendering, render
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import DOMAINS, PAPER_CENTERS, DomainName
from kogao_core.warp.canvas import Canvas
from kogao_core.warp.domain import mask_of, reduce
from kogao_core.warp.field import Field
from kogao_core.warp.fit import fit
from kogao_core.warp.lattice import ORDER, Lattice

LANDMARK: Final = "#56b4e9"
TARGET: Final = "#d55e00"
CENTER: Final = "#f0e442"
LATTICE: Final = "#cc79a7"
_INK: Final = "#202020"
_GAP: Final = 0.0125  # gap between pictures, relative to the width
_LETTER: Final = 0.02  # height of letters, relative to the width
_DOT: Final = 0.004  # radius of dots, relative to the width
_PROCESSED, _LEFT_OUT = 150, 255  # greys of figures 12 to 15
_NEVER_ZERO: Final = 1e-9
_CHIN: Final = 10  # of the outline's 21 points
_FOUR: Final = (0, 6, 14, 20)  # landmarks of figures 12 and 13
_FAR_PERCENT: Final = 30.0  # of D; large, to be visible in print
_SEEN_PX: Final = 0.5  # minimum threshold of figure 13; large, to be visible in print
# Lattice sizes of figures 8 to 10, in landmark spacings; the paper prints none.
_SMALL_LATTICE, _LARGE_LATTICE = 0.25, 4.0


def figures(subject: Subject, recipe: Recipe, width_px: int) -> list[Drawing]:
    """Draw every figure of a photo."""
    shown = pictured(subject, width_px)
    rendering = render(shown.pixels, shown.faces, recipe)
    made: Sequence[Callable[[Subject, Rendering], Drawing]] = (
        landmarks,
        centers,
        lattice,
        domains,
        before_after,
        one_point,
        overlap,
        directions,
        small_lattice,
        large_lattice,
        lattice_sizes,
        selection,
        threshold,
    )
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
    """Draw the control lattice and the control points other than zero (figures 2 and 8)."""
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


# -- figures 1, 3, 6, 8 to 10, 12 and 13 -----------------------------------------------------------


def one_point(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw one feature point with its target, and the result of moving it alone (figure 1)."""
    pairs = rendering.pairs[0]
    (source,), toward = pairs.source_px[[_CHIN]], pairs.center_px - pairs.source_px[_CHIN]
    goal = source + _FAR_PERCENT / 100.0 * toward
    field = _field_of(shown, rendering, Pairs(source[None], goal[None], pairs.center_px))
    dot = 2.0 * _DOT * shown.size[0]
    marks = (
        Strokes(np.array([[source, goal]]), 2.0, TARGET),
        Dots(goal[None], dot, TARGET, filled=False),
        Dots(source[None], dot, LANDMARK),
    )
    marked = Drawing("", shown.pixels, marks).painted()
    return _side_by_side("one-point", [marked, _warped(shown, field)])


def overlap(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the 4 x 4 control points of two close landmarks; mark the shared ones (figure 3)."""
    one, places = rendering.field.lattices[0], rendering.pairs[0].target_px[[_CHIN, _CHIN + 2]]
    grid, dot = one.grid, _DOT * shown.size[0]
    around = np.arange(-1, ORDER - 1)
    marks: list[Mark] = [Strokes(_grid_lines(one), 1.0, LATTICE)]
    nodes = []
    for place in places:
        (i, _), (j, _) = (grid.locate(place[axis : axis + 1], axis) for axis in (0, 1))
        at = np.dstack(np.meshgrid(grid.node_px(i + around, 0), grid.node_px(j + around, 1)))
        nodes.append(at.reshape(-1, 2))
    shared = (np.abs(nodes[0][:, None] - nodes[1]).max(axis=2) < 1e-6 * grid.spacing_px).any(axis=1)
    return Drawing(
        "overlap",
        shown.pixels,
        (
            *marks,
            Dots(nodes[0], 1.2 * dot, LANDMARK),
            Dots(nodes[1], 1.2 * dot, TARGET),
            Dots(nodes[0][shared], 1.8 * dot, CENTER),
            Dots(places, dot, _INK),
        ),
    )


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


def small_lattice(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the photo and the results of R = 1 and of a very small lattice (figure 8)."""
    panels = [_at_lattice(shown, rendering, size).pixels for size in (1.0, _SMALL_LATTICE)]
    return _side_by_side("small-lattice", [shown.pixels, *panels])


def large_lattice(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the domains and lattices of R = 1 and of a very large R (figure 9)."""
    panels = []
    for size in (1.0, _LARGE_LATTICE):
        made = _at_lattice(shown, rendering, size)
        mask = mask_of(made.field, Box.of(shown.pixels), "threshold")
        panels.append(_over(shown, mask, made.field.lattices))
    return _side_by_side("large-lattice", panels)


def lattice_sizes(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the results of the survey's four lattice sizes (figure 10)."""
    panels = [_at_lattice(shown, rendering, size).pixels for size in LATTICES]
    return _side_by_side("lattice-sizes", panels)


def selection(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the image domain and the control-point domain of four landmarks (figure 12)."""
    return _of_four("selection", shown, rendering, ("image", 0.0), ("control-points", 0.0))


def threshold(shown: Subject, rendering: Rendering) -> Drawing:
    """Draw the control-point and threshold domains of four landmarks (figure 13)."""
    least_px = max(rendering.recipe.threshold_px, _SEEN_PX)
    masks: tuple[tuple[DomainName, float], ...] = (("control-points", 0.0), ("threshold", least_px))
    return _of_four("threshold", shown, rendering, *masks)


def _of_four(
    name: str, shown: Subject, rendering: Rendering, *masks: tuple[DomainName, float]
) -> Drawing:
    """Draw domains, each with its threshold in px, of four landmarks."""
    pairs, few = rendering.pairs[0], list(_FOUR)
    four = Pairs(pairs.source_px[few], pairs.target_px[few], pairs.center_px)
    field, image = _field_of(shown, rendering, four), Box.of(shown.pixels)
    panels = [
        _over(shown, mask_of(field, image, *one), field.lattices, four.target_px) for one in masks
    ]
    return _side_by_side(name, panels)


def _field_of(shown: Subject, rendering: Rendering, pairs: Pairs) -> Field:
    recipe = dataclasses.replace(rendering.recipe, fit="approximation")
    return Field(fit([pairs], [shown.faces[0].anchor], [recipe]))


def _warped(shown: Subject, field: Field) -> Image:
    canvas = Canvas(shown.pixels)
    canvas.warp(field, reduce(field, Box.of(shown.pixels), "threshold"), "bilinear")
    return canvas.pixels


def _at_lattice(shown: Subject, rendering: Rendering, size: float) -> Rendering:
    recipe = dataclasses.replace(rendering.recipe, lattice=size, lattice_unit="spacing")
    return render(shown.pixels, shown.faces, recipe)


def _over(
    shown: Subject, mask: Image, lattices: Sequence[Lattice], points: Array | None = None
) -> Image:
    """Return a domain in grey with lattices and points."""
    marks: list[Mark] = [Strokes(_grid_lines(one), 1.0, LATTICE) for one in lattices]
    if points is not None:
        marks.append(Dots(points, 1.5 * _DOT * shown.size[0], _INK))
    return Drawing("", _mask(mask), tuple(marks)).painted()


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
