"""Rivals do what their references say, and all methods are measured in the same way."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.base.geometry import Affine, Box
from kogao_core.faces.targets import FacePairs
from kogao_core.lab.experiments import methods as comparing
from kogao_core.lab.experiments import methods_report
from kogao_core.lab.methods import (
    METHODS,
    MOVING_LEAST_SQUARES,
    RADIAL,
    THIN_PLATE,
    Interpolated,
    WarpTask,
)
from kogao_core.lab.reports.report import Made, page
from kogao_core.lab.subjects import Subject
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER, SETTINGS, Recipe

WIDTH, HEIGHT = 240, 180
PHOTO = textured_photo(WIDTH, HEIGHT)
FACE = oval_face(WIDTH, HEIGHT)
TASK = WarpTask.of(PHOTO, [FACE], PAPER)
INSIDE = np.random.default_rng(5).uniform((45, 45), (195, 135), (50, 2))
RIVALS = [method for method in METHODS if method.name not in SETTINGS["fit"].choices]
by_name = pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)


def task_of(map_):
    """Return points spread over the picture, corners too, that an affine map moves."""
    rng = np.random.default_rng(6)
    target = rng.uniform((0, 0), (WIDTH - 1, HEIGHT - 1), (15, 2))
    corners = [(0, 0), (WIDTH - 1, 0), (0, HEIGHT - 1), (WIDTH - 1, HEIGHT - 1)]
    target = np.vstack([target, corners])
    pairs = FacePairs(map_(target), target, target.mean(axis=0))

    class Free(WarpTask):
        def anchored(self, *, edges=True):  # noqa: ARG002
            return self.target_px, self.displacement_px

    return Free(Box(0, 0, WIDTH, HEIGHT), (pairs,), (FACE,), PAPER)


@by_name
def test_landmarks_move_to_their_targets(method):
    misses = np.linalg.norm(
        method.fit(TASK).at(TASK.target_px) - TASK.displacement_px, axis=1
    ) / np.linalg.norm(TASK.displacement_px, axis=1)
    assert misses.mean() < {"approximation": 0.3, "moving": 0.06}.get(method.name, 0.02)


@by_name
def test_points_grid_and_pixels_agree(method):
    warp = method.fit(TASK)
    xs, ys = np.arange(0, WIDTH, 7), np.arange(0, HEIGHT, 5)
    points = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2).astype(float)
    one_by_one = warp.at(points).T.reshape(2, len(ys), len(xs))
    np.testing.assert_allclose(warp.on_grid(xs, ys), one_by_one, atol=1e-9)
    result = warp.pixels(PHOTO)
    x, y = warp.on_grid(np.arange(WIDTH), np.arange(HEIGHT)).astype(np.float32)
    x, y = x + np.arange(WIDTH, dtype=np.float32), y + np.arange(HEIGHT, dtype=np.float32)[:, None]
    expected = cv2.remap(PHOTO, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    apart = np.abs(result.astype(int) - expected)
    assert apart.mean() < 0.5
    assert (apart > 12).mean() < 1e-3
    assert (result != PHOTO).any()


@pytest.mark.parametrize("fit", SETTINGS["fit"].choices)
def test_our_methods_are_the_pipelines(fit):
    (method,) = [one for one in METHODS if one.name == fit]
    recipe = replace(PAPER, fit=fit)
    rendered = render(PHOTO, [FACE], recipe).pixels
    np.testing.assert_array_equal(method.fit(TASK).pixels(PHOTO), rendered)


def test_thin_plates_reproduce_affine_maps():
    map_ = Affine(np.array([[1.05, 0.03], [-0.02, 0.96]]), np.array([2.0, -3.0]))
    shown = INSIDE + THIN_PLATE.fit(task_of(map_)).at(INSIDE)
    np.testing.assert_allclose(shown, map_(INSIDE), atol=1e-6)


def test_moving_least_squares_reproduces_rigid_maps_and_refuses_to_scale():
    rigid = Affine.similarity(1.0, 7.0, (4.0, -2.0))
    shown = INSIDE + MOVING_LEAST_SQUARES.fit(task_of(rigid)).at(INSIDE)
    np.testing.assert_allclose(shown, rigid(INSIDE), atol=1e-9)
    scaled = Affine.similarity(1.2, 0.0, (0.0, 0.0))
    warp = MOVING_LEAST_SQUARES.fit(task_of(scaled))
    step = 8.0
    slope = warp.at(INSIDE + np.array([step, 0.0])) - warp.at(INSIDE)
    assert np.abs(slope / step).mean() < 0.2 * 2.0  # a similarity would have 0.2 along x alone


def test_gaussians_end_and_copy_the_rest_of_the_photo():
    face = oval_face(WIDTH, HEIGHT, size=0.2)
    warp = RADIAL.fit(WarpTask.of(PHOTO, [face], PAPER))
    far = np.array([[2.0, 2.0], [WIDTH - 3.0, HEIGHT - 3.0]])
    assert np.abs(warp.at(far)).max() < 1.0 / 64.0
    assert isinstance(warp, Interpolated)
    assert warp.nodes.shape[1] * warp.step_px < 0.8 * WIDTH, "only a box of the photo"
    np.testing.assert_array_equal(warp.pixels(PHOTO)[:4], PHOTO[:4])


@pytest.mark.parametrize("method", RIVALS, ids=lambda method: method.name)
def test_fixed_points_of_the_references_stay(method):
    """Eyes and mouth are features and handles, too; methods without end have edges."""
    warp = method.fit(TASK)
    assert np.abs(warp.at(np.vstack([FACE.eyes, FACE.mouth]))).max() < 0.15
    if method in (THIN_PLATE, MOVING_LEAST_SQUARES):
        corners = [(0, 0), (WIDTH - 1, 0), (0, HEIGHT - 1), (WIDTH - 1, HEIGHT - 1)]
        assert np.abs(warp.at(np.array(corners, float))).max() < 0.05


# ---- the comparison -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def comparison():
    steps = []
    found, failed = comparing.measure(
        Subject("made.png", PHOTO, (FACE,)), PAPER, repeats=1, progress=lambda *at: steps.append(at)
    )
    assert failed == []
    assert steps[-1] == (2 * len(METHODS), 2 * len(METHODS))
    return found


def test_all_are_compared_in_the_same_way(comparison):
    assert [one.method for one in comparison.methods] == list(METHODS)
    for one in comparison.methods:
        assert set(one.pictures) == {"result", "difference", "heat"}
        assert {picture.shape for picture in one.pictures.values()} == {PHOTO.shape}
        assert one.largest_px > 0.8 * comparison.asked_px
        assert one.min_det < 1.0 < one.max_det
        warp = one.method.fit(TASK)
        landed = source = TASK.target_px + TASK.displacement_px
        for _ in range(100):
            landed = source - warp.at(landed)
        apart = np.linalg.norm(landed - TASK.target_px, axis=1).mean()
        assert one.landing_mean_px == pytest.approx(apart, abs=1e-3)


def test_figures_agree_with_the_engines_own(comparison):
    rendering = render(PHOTO, [FACE], PAPER)
    ours = comparison.methods[0]
    assert ours.residual_mean_px == pytest.approx(rendering.residual.mean_px)
    assert ours.min_det == pytest.approx(rendering.one_to_one.min_det, abs=0.02)
    counts = rendering.pixel_counts
    assert ours.moved_share == pytest.approx(counts["threshold"] / counts["image"])


def test_folds_are_seen():
    folding = Recipe(percent=15.0, lattice=0.3, fit="exact", guard=False)
    found, _ = comparing.measure(
        Subject("made.png", PHOTO, (FACE,)), folding, methods=METHODS[1:2], repeats=1
    )
    assert found.methods[0].min_det < 0.0
    assert found.methods[0].folded_share > 0.0


def unsolvable(_):
    raise np.linalg.LinAlgError("Singular matrix")


def test_points_that_a_method_cannot_take_are_named():
    singular = replace(THIN_PLATE, fit=unsolvable)
    found, failed = comparing.measure(
        Subject("made.png", PHOTO, (FACE,)), PAPER, methods=[singular, METHODS[0]], repeats=1
    )
    (sentence,) = failed
    assert "made.png: Thin-plate spline can't be fitted" in sentence
    assert [one.method.name for one in found.methods] == ["approximation"]


def test_the_report_has_one_table_for_each_class_of_sizes(comparison):
    larger = replace(comparison, longer_side_px=1400)
    report = methods_report.report([comparison.views(), larger.views()], PAPER, 1)
    json.dumps(report.document, allow_nan=False)
    told = page(report, Made.now("kogao-cli"))
    assert told.count("<img") == 2 * (1 + 3 * len(METHODS))
    assert len(list(methods_report.pictures(comparison))) == 3 * len(METHODS)
    captions = [table.caption for table in report.tables if "Computing time" in table.caption]
    assert captions == ["Computing time: 1 photo of 240 px", "Computing time: 1 photo of 1400 px"]
    for table in report.tables:
        assert len(table.rows) == len(METHODS)
    assert report.tables[0].rows[0][5] == "1.00"
