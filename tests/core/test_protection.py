"""A door frame beside the face stays straight, and the bend meter says so."""

import cv2
import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.background.lines import bends, straight_lines
from kogao_core.base.geometry import Affine, Box
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import LOSSLESS_PX, SETTINGS, Recipe
from kogao_core.warp.domain import reduce
from kogao_core.warp.protection import Falloff, Protection, Stroke

WIDTH, HEIGHT = 960, 720
RECIPE = Recipe(percent=8)


def door_frame(face):
    """A vertical edge three quarters of a lattice cell beside the cheek."""
    x = face.outline[:, 0].max() + 0.75 * face.anchor.spacing_px
    return np.array([[x, 60.0], [x, 660.0]])


def photo_of(line):
    photo = cv2.GaussianBlur(textured_photo(WIDTH, HEIGHT), (0, 0), 12)
    x = round(line[0, 0])
    photo[int(line[0, 1]) : int(line[1, 1]), x - 3 : x + 4] = (250, 250, 250)
    return photo


@pytest.mark.parametrize("fit", SETTINGS["fit"].choices)
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
    displacement = near.field.on_grid(np.arange(WIDTH), np.arange(HEIGHT))
    assert np.hypot(*displacement)[rested].max() < LOSSLESS_PX


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


def test_a_hard_edge_with_a_feather_keeps_every_byte_and_nothing_folds():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    line, photo = door_frame(face), textured_photo(WIDTH, HEIGHT)
    hard = Protection((Stroke(line, radius_px=4.0, feather_px=16.0),))
    soft, recipe = Protection((Stroke(line, radius_px=4.0),)), Recipe(percent=5)
    rows = np.arange(70, 650)
    columns = np.round(line[0, 0]).astype(int) + np.arange(-3, 4)
    asked = render(photo, [face], recipe, protection=soft).field
    assert np.hypot(*asked.on_grid(columns, rows)).max() > LOSSLESS_PX, "the fit alone holds it"
    held = render(photo, [face], recipe, protection=hard)
    assert held.shares == (1.0,)
    assert not held.field.on_grid(columns, rows).any()
    np.testing.assert_array_equal(held.pixels[rows][:, columns], photo[rows][:, columns])
    xs = np.arange(line[0, 0] - 40, line[0, 0] + 40, 0.25)
    assert held.field.det_jacobian(xs, np.arange(50.0, 670.0, 1.7)).min() > 0.0
    assert held.one_to_one.certified


def test_the_guard_holds_back_what_a_thin_feather_would_fold():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    across = Protection((Stroke(face.outline[8:13], feather_px=2.0),))
    recipe = Recipe(percent=8, fit="approximation")
    photo = textured_photo(WIDTH, HEIGHT)
    held = render(photo, [face], recipe, protection=across)
    assert 0.0 < held.shares[0] < 1.0
    assert held.one_to_one.certified
    loose = render(
        photo, [face], Recipe(percent=8, fit="approximation", guard=False), protection=across
    )
    assert not loose.one_to_one.edges_proven


def test_the_falloff_has_the_slope_it_says_and_keeps_its_bounds():
    rng = np.random.default_rng(4)
    falloff = Falloff(
        (
            Stroke([[10.0, 10.0], [60.0, 30.0], [80.0, 90.0]], 3.0, 12.0),
            Stroke([[90.0, 20.0]], 0.0, 30.0),
        )
    )
    points = rng.uniform(-20, 130, (4000, 2))
    factor, slope = falloff.at(points)
    assert (factor == 0.0).any()
    assert (factor == 1.0).any()
    most, steepest = falloff.bounds(points, 5.0)
    beside = points + rng.uniform(-3.5, 3.5, points.shape)
    other_factor, other_slope = falloff.at(beside)
    assert (other_factor <= most + 1e-12).all()
    assert (np.linalg.norm(other_slope, axis=1) <= steepest + 1e-12).all()
    step = 1e-5
    numeric = [
        (falloff.at(points + step * unit)[0] - falloff.at(points - step * unit)[0]) / (2 * step)
        for unit in np.eye(2)
    ]
    # At equal distance from two places the slope jumps: a few points may sit on that line.
    assert (np.abs(np.stack(numeric, 1) - slope).max(axis=1) > 1e-4).mean() < 0.001
    xs, ys = np.arange(-20.0, 130.0, 7.0), np.arange(0.0, 120.0, 5.0)
    on_grid, slopes = falloff.on_grid(xs, ys)
    at, slope = falloff.at(np.stack(np.meshgrid(xs, ys), -1).reshape(-1, 2))
    np.testing.assert_allclose(on_grid.ravel(), at)
    np.testing.assert_allclose(slopes.reshape(2, -1).T, slope)


def test_the_bend_meter_finds_the_frame_and_measures_it_as_seen():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    line = door_frame(face)
    photo = photo_of(line)
    rendering = render(photo, [face], RECIPE)
    found = straight_lines(photo)
    upright = [ends for ends in found if abs(ends[0, 0] - ends[1, 0]) < 3]
    assert any(abs(ends[:, 0].mean() - line[0, 0]) < 6 for ends in upright)
    (measured,) = bends(rendering.field, line[None])
    rows = np.arange(80, 640)
    bright = np.where(rendering.pixels[rows, :, 0] > 220, 1.0, 0.0)
    seen = (bright * np.arange(WIDTH)).sum(axis=1) / np.maximum(1.0, bright.sum(axis=1))
    straight = np.polyval(np.polyfit(rows, seen, 1), rows)
    assert measured.bend_px == pytest.approx(np.abs(seen - straight).max(), abs=0.8)


def test_no_lines_in_a_plain_picture():
    assert straight_lines(np.full((300, 400, 3), 90, np.uint8)).shape[0] == 0
    noise = np.random.default_rng(0).integers(0, 2, (5, 40), np.uint8) * 255
    for small in (noise, noise.T, noise[:1, :1]):
        assert straight_lines(small).shape[0] == 0
    assert straight_lines(np.zeros((9, 65535), np.uint8)).shape[0] == 0  # no row is left of it


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
    with pytest.raises(ValueError, match="feather"):
        Stroke([[0.0, 0.0]], 1.0, np.inf)


def test_an_eraser_leaves_nothing_under_it_and_all_else_as_it_was():
    line = Stroke([[0.0, 0.0], [60.0, 0.0], [60.0, 80.0]], radius_px=5.0, feather_px=3.0)
    far, dot = Stroke([[200.0, 200.0]], 5.0), Stroke([[61.0, 40.0]])
    erased = Protection((line, far, dot)).erased([[60.0, 36.0], [60.0, 44.0]], 8.0)
    first, second, third = erased.strokes
    assert third is far
    assert (first.radius_px, first.feather_px) == (5.0, 3.0)
    np.testing.assert_array_equal(first.points_px[:2], line.points_px[:2])
    np.testing.assert_allclose(first.points_px[-1], (60.0, 36.0 - 13.0), atol=13 / 8)
    np.testing.assert_allclose(second.points_px[0], (60.0, 44.0 + 13.0), atol=13 / 8)
    rubber = Stroke([[60.0, 36.0], [60.0, 44.0]]).samples_px(0.1)
    for part in (first, second):
        apart = np.linalg.norm(part.samples_px(0.5)[:, None] - rubber, axis=2)
        assert apart.min() >= 8.0 - 0.05
    untouched = Protection((line,)).erased([[0.0, 100.0]], 8.0)
    assert untouched.strokes[0] is line
    assert not Protection((dot,)).erased([[60.0, 40.0]], 2.0).strokes
