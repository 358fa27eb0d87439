"""Width, length and parts of a face are set directly: signed, and whatever the warp distance."""

import dataclasses

import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.additions.head import forehead_pairs
from kogao_core.faces.targets import aim, shape_center
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import SHAPE, Recipe

STILL = Recipe(percent=0)
ALONE = Recipe(percent=0, scope="face")
FACE = oval_face(center=(239.5, 200.0), size=0.4, forehead=True)
OUTLINE = tuple(name for name in SHAPE if name not in ("forehead_height", "even_out"))


def with_only(name, value, recipe=STILL):
    return dataclasses.replace(recipe, **{name: value})


def moves(recipe, face=FACE):
    return aim(face, recipe).displacement_px


def test_as_much_of_width_and_of_length_is_the_papers_move():
    both = dataclasses.replace(ALONE, width=-6, length=-6)
    np.testing.assert_allclose(moves(both), moves(with_only("percent", 6, ALONE)), atol=1e-9)


@pytest.mark.parametrize("name", OUTLINE)
@pytest.mark.parametrize("percent", [0, 4])
def test_each_works_at_any_amount_by_the_same_way_in_and_out(name, percent):
    base = Recipe(percent=percent)
    plain = moves(base)
    inwards, outwards = (moves(with_only(name, value, base)) - plain for value in (-5, 5))
    assert np.hypot(*inwards.T).max() > 2.0
    np.testing.assert_allclose(inwards, -outwards, atol=1e-9)


def test_width_moves_nothing_along_the_head_and_length_nothing_across_it():
    assert np.abs(moves(with_only("width", -8))[:, 1]).max() < 1e-9
    assert np.abs(moves(with_only("length", -8))[:, 0]).max() < 1e-9


@pytest.mark.parametrize("value", [-8.0, 8.0])
def test_the_hairline_goes_by_itself_as_far_as_it_is_told(value):
    recipe = dataclasses.replace(STILL, forehead_height=value)
    made = render(textured_photo(), [FACE], recipe)
    assert made.pixels.tobytes() != textured_photo().tobytes()
    top, shown = (points[6] for points in forehead_pairs(FACE, recipe, made.pairs[0]))
    center = shape_center(FACE, recipe)
    assert shown[1] - top[1] == pytest.approx(value / 100 * (top[1] - center[1]), rel=0.05)
    # What the lattice makes of it; the landmarks stay, and so do the eyes.
    assert made.field.at([shown])[0, 1] == pytest.approx(top[1] - shown[1], rel=0.35)
    assert np.abs(made.field.at(np.vstack([FACE.outline, FACE.eyes]))).max() < 0.3


def test_a_narrower_face_has_a_narrower_forehead_and_slimmer_cheeks_do_not():
    moved = {}
    for name in ("width", "cheeks_width"):
        recipe = with_only(name, -8)
        there, shown = forehead_pairs(FACE, recipe, aim(FACE, recipe))
        moved[name] = np.abs(shown - there)
    assert moved["width"][[0, -1], 0].min() > 2.0
    assert moved["width"][6, 0].max() < 0.3
    assert moved["cheeks_width"].max() < 0.3
