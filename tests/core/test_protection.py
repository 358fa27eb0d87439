"""A door frame beside the face stays straight, and the bend meter says so."""

import cv2
import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.bend import bends, straight_lines
from kogao_core.domain import reduce
from kogao_core.geometry import Affine, Box
from kogao_core.pipeline import render
from kogao_core.protection import Protection, Stroke
from kogao_core.recipe import LOSSLESS_PX, Recipe

WIDTH, HEIGHT = 960, 720
RECIPE = Recipe(percent=8)


def door_frame(face):
    """A vertical edge three quarters of a lattice cell beside the cheek."""
    x = face.outline[:, 0].max() + 0.75 * face.frame.spacing_px
    return np.array([[x, 60.0], [x, 660.0]])


def photo_of(line):
    photo = cv2.GaussianBlur(textured_photo(WIDTH, HEIGHT), (0, 0), 12)
    x = round(line[0, 0])
    photo[int(line[0, 1]) : int(line[1, 1]), x - 3 : x + 4] = (250, 250, 250)
    return photo


@pytest.mark.parametrize("fit", ["approximation", "exact", "multilevel"])
def test_a_protected_door_frame_bends_less_than_a_pixel(fit):
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    line, recipe = door_frame(face), Recipe(percent=8, fit=fit)
    photo = photo_of(line)
    free = render(photo, [face], recipe)
    held = render(photo, [face], recipe, protection=Protection((Stroke(line),)))
    (before,) = bends(free.field, line[None])
    (after,) = bends(held.field, line[None])
    assert before.bend_px > 1.5, "the frame doesn't bend without protection: nothing to show"
    assert held.shares == (1.0,)
    if fit == "approximation":  # it can only soften: landmarks and frame share control points
        assert after.bend_px < 0.8 * before.bend_px
        return
    assert after.bend_px < 1.0
    assert held.residual.max_px < 0.05
    if fit == "exact":
        assert after.bend_px < 0.25


def test_protection_moves_nothing_that_stood_still():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    far = Protection().with_stroke([[20.0, 20.0], [20.0, 700.0]], 10.0)
    photo = textured_photo(WIDTH, HEIGHT)
    free, held = render(photo, [face], RECIPE), render(photo, [face], RECIPE, protection=far)
    np.testing.assert_array_equal(free.pixels, held.pixels)
    near = render(photo, [face], RECIPE, protection=Protection((Stroke(door_frame(face)),)))
    image = Box.of(photo)
    rested = ~reduce(free.field, image, "control-points").mask(image)
    pull = near.field.on_grid(np.arange(WIDTH), np.arange(HEIGHT))
    assert np.hypot(*pull)[rested].max() < LOSSLESS_PX


def test_a_brushed_place_stays():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    spot = face.outline[16] + (30.0, 0.0)
    held = Protection().with_stroke([spot], 25.0)
    photo = textured_photo(WIDTH, HEIGHT)
    inside = spot + np.random.default_rng(0).uniform(-12, 12, (50, 2))
    moved = np.linalg.norm(render(photo, [face], RECIPE).field.at(inside), axis=1).max()
    field = render(photo, [face], RECIPE, protection=held).field
    assert moved > 4.0
    assert np.linalg.norm(field.at(inside), axis=1).max() < 0.25 * moved


def test_the_bend_meter_finds_the_frame_and_measures_it_as_seen():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    line = door_frame(face)
    photo = photo_of(line)
    rendering = render(photo, [face], RECIPE)
    found = straight_lines(photo, rendering.domain.bounds)
    upright = [ends for ends in found if abs(ends[0, 0] - ends[1, 0]) < 3]
    assert any(abs(ends[:, 0].mean() - line[0, 0]) < 6 for ends in upright)
    (measured,) = bends(rendering.field, line[None])
    rows = np.arange(80, 640)
    bright = np.where(rendering.pixels[rows, :, 0] > 220, 1.0, 0.0)
    seen = (bright * np.arange(WIDTH)).sum(axis=1) / np.maximum(1.0, bright.sum(axis=1))
    straight = np.polyval(np.polyfit(rows, seen, 1), rows)
    assert measured.bend_px == pytest.approx(np.abs(seen - straight).max(), abs=0.8)


def test_no_lines_in_a_plain_picture():
    assert straight_lines(np.full((300, 400, 3), 90, np.uint8), Box(0, 0, 400, 300)).shape[0] == 0
    assert straight_lines(np.zeros((300, 400), np.uint8), Box(0, 0, 0, 0)).shape[0] == 0


def test_strokes_are_sampled_within_their_step_and_follow_their_image():
    stroke = Stroke(np.array([[0.0, 0.0], [30.0, 40.0]]))
    samples = stroke.samples_px(7.0)
    assert np.linalg.norm(np.diff(samples, axis=0), axis=1).max() <= 7.0
    wide = Stroke(np.array([[5.0, 5.0]]), 10.0).samples_px(3.0)
    assert np.hypot(*(wide - 5.0).T).max() <= 10.0
    assert len(wide) > 20
    moved = Protection((stroke,)).mapped(Affine.similarity(2.0, 0.0, (1.0, 1.0)))
    np.testing.assert_allclose(moved.strokes[0].points_px[1], (61.0, 81.0))
    for broken in (np.zeros((0, 2)), [[np.nan, 0.0]]):
        with pytest.raises(ValueError, match="stroke"):
            Stroke(broken)
    with pytest.raises(ValueError, match="radius"):
        Stroke([[0.0, 0.0]], -1.0)
