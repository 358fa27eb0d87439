"""The paper end to end: a pure function that moves with its input."""

import dataclasses

import cv2
import numpy as np
import pytest
from opencv import needs_rounded_positions
from scenes import oval_face, textured_photo

from kogao_core.base.geometry import Affine, Box
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import SETTINGS, Recipe
from kogao_core.resample.canvas import Canvas

WIDTH, HEIGHT = 480, 360


def scene():
    return textured_photo(WIDTH, HEIGHT), oval_face(WIDTH, HEIGHT)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_zero_percent_returns_the_same_bytes(dtype):
    """A photo without a face does, too."""
    photo = textured_photo(WIDTH, HEIGHT, dtype=dtype)
    for faces, recipe in (([oval_face(WIDTH, HEIGHT)], Recipe(percent=0)), ([], Recipe())):
        rendering = render(photo, faces, recipe)
        assert rendering.pixels.tobytes() == photo.tobytes()
        assert rendering.pixels is not photo
        assert rendering.changed == []
        assert rendering.one_to_one.min_det == 1.0
        assert rendering.residual.max_px == 0.0


def test_the_face_gets_smaller():
    """The silhouette, drawn as an edge, moves inwards by the warp distance."""
    face = oval_face(WIDTH, HEIGHT)
    photo = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.fillPoly(photo, [np.round(face.outline).astype(np.int32)], 255)
    rendering = render(photo, [face], Recipe(percent=8))
    assert (rendering.pixels > 127).sum() < 0.93 * (photo > 127).sum()


MIRROR = Affine(np.diag([-1.0, 1.0]), np.array([WIDTH - 1.0, 0.0]))
HALF_TURN = Affine(-np.eye(2), np.array([WIDTH - 1.0, HEIGHT - 1.0]))
QUARTER_TURN = Affine(np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([HEIGHT - 1.0, 0.0]))


@pytest.mark.parametrize("fit", SETTINGS["fit"].choices)
@pytest.mark.parametrize(
    ("transform", "turn"),
    [
        (MIRROR, lambda image: image[:, ::-1]),
        (HALF_TURN, lambda image: image[::-1, ::-1]),
        (QUARTER_TURN, lambda image: np.rot90(image, -1)),
    ],
    ids=["mirror", "half turn", "quarter turn"],
)
def test_turning_or_mirroring_the_input_moves_the_result_with_it(transform, turn, fit):
    photo, face = scene()
    recipe = Recipe(percent=8, fit=fit)
    expected = turn(render(photo, [face], recipe).pixels)
    moved = render(np.ascontiguousarray(turn(photo)), [face.mapped(transform)], recipe).pixels
    difference = np.abs(moved.astype(int) - expected)
    assert difference.mean() < 0.05
    assert (difference > 3).mean() < 1e-3


@pytest.mark.parametrize("scale", [0.5, 2.0, 3.7])
def test_scaling_the_input_scales_the_field(scale):
    photo, face = scene()
    recipe = Recipe(percent=8)
    field = render(photo, [face], recipe).field
    resize = Affine.resize(scale, scale)
    size = (round(HEIGHT * scale), round(WIDTH * scale), 3)
    large = render(np.zeros(size, np.uint8), [face.mapped(resize)], recipe).field
    points = np.random.default_rng(4).uniform((120, 60), (360, 300), (300, 2))
    np.testing.assert_allclose(large.at(resize(points)), scale * field.at(points), atol=2e-3)


@pytest.mark.parametrize("degrees", [10, 33, 75])
def test_a_tilted_head_is_warped_like_an_upright_one(degrees):
    """The lattice stays upright, so between landmarks a turn may cost a little."""
    photo, face = scene()
    recipe = Recipe(percent=8)
    turn = Affine.similarity(1.0, degrees, (0, 0))
    everywhere = Box(-2000, -2000, 2000, 2000)  # the turned face lies outside the photo
    field = render(photo, [face], recipe, whole=everywhere).field
    turned = render(photo, [face.mapped(turn)], recipe, whole=everywhere)
    np.testing.assert_allclose(
        turned.field.at(turned.pairs[0].target_px), turned.pairs[0].displacement_px, atol=0.05
    )
    points = np.random.default_rng(4).uniform((120, 60), (360, 300), (300, 2))
    expected = field.at(points) @ turn.matrix.T
    error = np.linalg.norm(turned.field.at(turn(points)) - expected, axis=1)
    assert error.mean() < 0.1 * np.linalg.norm(expected, axis=1).max()


def test_a_canvas_over_another_photo_is_refused():
    photo, face = scene()
    with pytest.raises(ValueError, match="another photo"):
        render(photo, [face], Recipe(), canvas=Canvas(photo.copy()))


@needs_rounded_positions
def test_a_face_with_a_recipe_of_its_own_goes_by_it():
    photo = textured_photo(1200, 500)
    left, right = (oval_face(1200, 500, center=(x, 250.0), size=0.5) for x in (300.0, 900.0))
    own = Recipe(percent=9.0, center=4, lattice=0.7, fit="multilevel", interpolation="bilinear")
    both = render(photo, [left, dataclasses.replace(right, recipe=own)], Recipe()).pixels
    as_left = render(photo, [left], Recipe()).pixels
    as_right = render(photo, [right], Recipe().of_face(own)).pixels
    np.testing.assert_array_equal(both[:, :600], as_left[:, :600])
    # A second lattice may round a map entry to the next 1/32 px.
    assert (both[:, 600:] != as_right[:, 600:]).mean() < 0.001
    assert Recipe().of_face(own).interpolation == "cubic", "the kernel is the photo's choice"
    assert (both[:, 600:] != render(photo, [right], Recipe()).pixels[:, 600:]).any()
