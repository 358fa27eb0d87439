"""A retouch is read from an original and its edited copy, and expressed in settings."""

import dataclasses

import cv2
import numpy as np
import pytest
from few_cases import few_of
from real_photos import picture_of
from scenes import oval_face
from scipy.interpolate import RBFInterpolator

from kogao_core.base.geometry import Box
from kogao_core.faces.landmarks import MeshSource
from kogao_core.faces.landmarks.pixels import Pyramid
from kogao_core.field.field import shown_at
from kogao_core.field.measures import measures
from kogao_core.pipeline import render
from kogao_core.reading.controls import CONTROLS, NOTHING_PERCENT, fit_controls, style
from kogao_core.reading.displacement import read_faces
from kogao_core.reading.flow import NotRead, aligned
from kogao_core.recipe.recipe import SETTINGS, Recipe


@pytest.fixture(scope="module")
def scene(source: MeshSource, portrait):
    """The sample on a textured ground, and its face."""
    picture = picture_of(portrait, 600.0)
    ground = np.random.default_rng(3).integers(60, 200, (45, 40, 3), np.uint8)
    wide = cv2.resize(ground, (800, 900), interpolation=cv2.INTER_CUBIC)
    height, width = picture.shape[:2]
    wide[150 : 150 + height, 100 : 100 + width] = picture
    (face,) = source.find(wide)
    return wide, face


def retouched(picture, face, **settings):
    """Return a toned, smoothed and compressed result, and where it shows the outline."""
    recipe = Recipe(**{"percent": 0.0, "hold_background": False, **settings})
    rendering = render(picture, [face], recipe)
    toned = np.clip(255.0 * (rendering.pixels / 255.0) ** 0.9, 0, 255).astype(np.uint8)
    smooth = cv2.addWeighted(toned, 0.6, cv2.bilateralFilter(toned, 7, 25, 7), 0.4, 0)
    stored = cv2.imencode(".jpg", smooth, [cv2.IMWRITE_JPEG_QUALITY, 88])[1]
    return cv2.imdecode(stored, cv2.IMREAD_COLOR), shown_at(rendering.field, face.outline)


def error_percent(reading, outline):
    away = np.linalg.norm(reading.outline - outline, axis=1).mean()
    return 100.0 * away / measures(reading.face).width_px


def test_an_outline_is_read_beneath_tone_smoothing_and_compression(scene):
    """And settings explain the retouch."""
    picture, face = scene
    copy, outline = retouched(picture, face, percent=5.0, jaw_width=-4.0)
    (reading,) = read_faces(picture, copy, [face])
    assert error_percent(reading, outline) < 0.3
    assert reading.moved_percent > 2.0
    found = fit_controls(reading, Box.of(picture))
    assert found.unexplained_percent < 0.3
    assert found.recipe.percent == pytest.approx(5.0, abs=0.8)
    assert any(getattr(found.recipe, name) for name in CONTROLS[1:])


def test_a_cropped_turned_and_reduced_copy_is_aligned(scene):
    picture, face = scene
    copy, outline = retouched(picture, face, percent=5.0)
    turn = cv2.getRotationMatrix2D((400.0, 450.0), 1.5, 0.8)
    turn[:, 2] -= 30.0, 20.0
    crop = cv2.warpAffine(copy, turn, (700, 820), flags=cv2.INTER_AREA)
    (reading,) = read_faces(picture, crop, [face])
    assert error_percent(reading, outline) < 0.4


def test_nothing_moved_reads_as_nothing_moved(scene):
    picture, face = scene
    (reading,) = read_faces(picture, retouched(picture, face)[0], [face])
    assert reading.moved_percent < NOTHING_PERCENT
    assert max(abs(reading.narrower(row)) for row in range(8)) < 0.5


def thin_plate(picture, face, percent):
    """Return a copy whose outline shrinks and whose border stays, and where it shows the outline.

    Such a warp moves the background around the head, too.
    """
    height, width = picture.shape[:2]
    ring = [(x * (width - 1), y * (height - 1)) for x in (0, 0.5, 1) for y in (0, 0.5, 1)]
    fixed = [*face.points[len(face.outline) :], *(one for one in ring if one != ring[4])]
    middle = face.outline.mean(axis=0)
    targets = face.outline + percent / 100.0 * (middle - face.outline)
    backward = RBFInterpolator(
        np.vstack([targets, fixed]), np.vstack([face.outline, fixed]), kernel="thin_plate_spline"
    )
    grid = np.stack(np.meshgrid(np.arange(0, width + 8, 8), np.arange(0, height + 8, 8)), axis=-1)
    coarse = backward(grid.reshape(-1, 2).astype(float)).reshape(grid.shape).astype(np.float32)
    y, x = np.mgrid[:height, :width].astype(np.float32) / 8.0
    way = cv2.remap(coarse, x, y, cv2.INTER_LINEAR)
    return cv2.remap(picture, way, None, cv2.INTER_CUBIC), targets


@pytest.mark.parametrize("percent", few_of([8.0, 2.0], 1))
def test_a_background_that_moves_too_widens_the_interval(scene, percent):
    """The interval holds the true move, and is wider than with a still background."""
    picture, face = scene
    copy, outline = thin_plate(picture, face, percent)
    (reading,) = read_faces(picture, copy, [face])
    true = np.linalg.norm(outline - face.outline, axis=1).mean() / measures(face).width_px * 100.0
    assert abs(reading.moved_percent - true) < reading.moved_doubt_percent
    (still,) = read_faces(picture, retouched(picture, face, percent=percent)[0], [face])
    assert 1.5 * still.moved_doubt_percent < reading.moved_doubt_percent < true


def test_another_picture_and_a_small_face_are_refused(scene):
    picture, face = scene
    with pytest.raises(NotRead):
        read_faces(picture, np.ascontiguousarray(picture[::-1]), [face])
    small = cv2.resize(picture, None, fx=0.15, fy=0.15, interpolation=cv2.INTER_AREA)
    with pytest.raises(NotRead, match="too small"):
        read_faces(picture, small, [face])
    with pytest.raises(NotRead, match="no face"):
        read_faces(picture, picture, [])


def test_a_style_is_the_median_of_each_control():
    assert set(CONTROLS) <= set(SETTINGS)
    recipe, spread = style([Recipe(percent=percent) for percent in (2.0, 5.0, 14.0)])
    assert recipe == dataclasses.replace(Recipe(), percent=5.0)
    assert spread["percent"] == 3.0
    assert spread[CONTROLS[1]] == 0.0


def test_another_expression_is_refused(scene):
    picture, face = scene
    laughing = picture.copy()
    middle = np.round(face.mouth_center).astype(int).tolist()
    half = round(float(np.linalg.norm(np.diff(face.mouth, axis=0))) / 2.0)
    cv2.ellipse(
        laughing, middle, (round(0.6 * half), round(0.12 * half)), 0, 0, 360, (90, 45, 45), -1
    )
    with pytest.raises(NotRead, match="another photo"):
        read_faces(picture, retouched(laughing, face)[0], [face])


def test_hair_round_a_close_head_is_no_background():
    small = np.random.default_rng(5).integers(0, 255, (75, 75, 3), np.uint8)
    close = cv2.resize(small, (600, 600), interpolation=cv2.INTER_CUBIC)
    face = oval_face(600, 600, size=0.62)
    found = aligned(Pyramid(close), Pyramid(np.roll(close, 3, axis=0)), [face])
    np.testing.assert_array_equal(found.to_after.opencv, np.eye(2, 3))
