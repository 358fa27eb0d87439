"""Rivals do what their references say, and all methods are measured by the same rule."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.base.geometry import Affine, Box
from kogao_core.base.installed import adding
from kogao_core.faces.targets import Pairs
from kogao_core.lab.experiments import methods as comparing
from kogao_core.lab.experiments import methods_report
from kogao_core.lab.methods import (
    LIQUIFY,
    METHODS,
    MOVING_LEAST_SQUARES,
    PIECEWISE_AFFINE,
    RADIAL,
    THIN_PLATE,
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
by_name = pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)


def task_of(map_):
    """Return points spread over the picture, corners too, that an affine map moves."""
    rng = np.random.default_rng(6)
    target = rng.uniform((0, 0), (WIDTH - 1, HEIGHT - 1), (15, 2))
    corners = [(0, 0), (WIDTH - 1, 0), (0, HEIGHT - 1), (WIDTH - 1, HEIGHT - 1)]
    target = np.vstack([target, corners])
    pairs = Pairs(map_(target), target, target.mean(axis=0))

    class Free(WarpTask):
        def anchored(self, *, edges=True):  # noqa: ARG002
            return self.target_px, self.displacement_px

    return Free(Box(0, 0, WIDTH, HEIGHT), (pairs,), (FACE,), PAPER)


@by_name
def test_landmarks_get_where_they_should(method):
    misses = np.linalg.norm(
        method.fit(TASK).at(TASK.target_px) - TASK.displacement_px, axis=1
    ) / np.linalg.norm(TASK.displacement_px, axis=1)
    loose = method.name in ("approximation", "liquify")
    assert misses.mean() < (0.3 if loose else 0.01)


@by_name
def test_points_rows_and_pixels_agree(method):
    warp = method.fit(TASK)
    xs, ys = np.arange(0, WIDTH, 7), np.arange(0, HEIGHT, 5)
    points = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2).astype(float)
    one_by_one = warp.at(points).T.reshape(2, len(ys), len(xs))
    np.testing.assert_allclose(warp.on_grid(xs, ys), one_by_one, atol=1e-9)
    result = warp.pixels(PHOTO)
    assert (result.shape, result.dtype) == (PHOTO.shape, PHOTO.dtype)
    still = np.hypot(*warp.on_grid(np.arange(WIDTH), np.arange(HEIGHT))) < 1e-3
    np.testing.assert_array_equal(result[still], PHOTO[still])
    assert (result != PHOTO).any()


@pytest.mark.parametrize("fit", SETTINGS["fit"].choices)
def test_our_methods_are_the_pipelines(fit):
    (method,) = [one for one in METHODS if one.name == fit]
    recipe = replace(PAPER, fit=fit)
    rendered = render(PHOTO, [FACE], recipe).pixels
    np.testing.assert_array_equal(method.fit(TASK).pixels(PHOTO), rendered)


@pytest.mark.parametrize("method", [THIN_PLATE, PIECEWISE_AFFINE], ids=lambda method: method.name)
def test_affine_maps_are_reproduced(method):
    map_ = Affine(np.array([[1.05, 0.03], [-0.02, 0.96]]), np.array([2.0, -3.0]))
    shown = INSIDE + method.fit(task_of(map_)).at(INSIDE)
    np.testing.assert_allclose(shown, map_(INSIDE), atol=1e-6)


def test_moving_least_squares_reproduces_rigid_maps_and_refuses_to_scale():
    rigid = Affine.similarity(1.0, 7.0, (4.0, -2.0))
    shown = INSIDE + MOVING_LEAST_SQUARES.fit(task_of(rigid)).at(INSIDE)
    np.testing.assert_allclose(shown, rigid(INSIDE), atol=1e-9)
    scaled = Affine.similarity(1.2, 0.0, (0.0, 0.0))
    warp = MOVING_LEAST_SQUARES.fit(task_of(scaled))
    step = 1e-3
    slope = warp.at(INSIDE + np.array([step, 0.0])) - warp.at(INSIDE)
    assert np.abs(slope / step).mean() < 0.2 * 2.0  # a similarity would have 0.2 along x alone


@pytest.mark.parametrize("method", [RADIAL, LIQUIFY], ids=lambda method: method.name)
def test_local_methods_end_by_themselves(method):
    face = oval_face(WIDTH, HEIGHT, size=0.3)
    far = np.array([[2.0, 2.0], [WIDTH - 3.0, HEIGHT - 3.0]])
    warp = method.fit(WarpTask.of(PHOTO, [face], PAPER))
    assert np.abs(warp.at(far)).max() < 1e-3


def test_liquify_moves_landmarks_as_far_as_asked_on_average():
    moved = np.linalg.norm(LIQUIFY.fit(TASK).at(TASK.target_px), axis=1).mean()
    assert moved == pytest.approx(np.linalg.norm(TASK.displacement_px, axis=1).mean(), rel=0.05)


@pytest.mark.parametrize(
    "method", [THIN_PLATE, PIECEWISE_AFFINE, MOVING_LEAST_SQUARES, RADIAL], ids=lambda m: m.name
)
def test_what_stays_in_the_references_stays(method):
    """Eyes and mouth have features, meshes and handles, too; methods without end have edges."""
    warp = method.fit(TASK)
    assert np.abs(warp.at(np.vstack([FACE.eyes, FACE.mouth]))).max() < 1e-3
    if method is not RADIAL:
        corners = [(0, 0), (WIDTH - 1, 0), (0, HEIGHT - 1), (WIDTH - 1, HEIGHT - 1)]
        assert np.abs(warp.at(np.array(corners, float))).max() < 1e-3


@pytest.mark.parametrize("method", [m for m in METHODS if m.quick], ids=lambda m: m.name)
def test_run_as_anyone_would_a_rival_makes_the_same_picture(method):
    """On real photos 70 dB and more; noise is harder, and at this size the mesh is all seams."""
    photo = cv2.GaussianBlur(textured_photo(320, 240), (0, 0), 2)
    task = WarpTask.of(photo, [oval_face(320, 240)], PAPER)
    literal, quick = method.fit(task), method.quick(task)
    one, other = (warp.pixels(photo).astype(float) for warp in (literal, quick))
    assert 10.0 * np.log10(255**2 / np.square(one - other).mean()) > 60.0
    np.testing.assert_allclose(quick.at(INSIDE), literal.at(INSIDE))


def test_every_rival_is_run_both_ways(comparison):
    for one in comparison.methods:
        is_rival = one.method.library != "Kogao"
        assert (one.quick_ms is not None) == is_rival
        assert (one.quick_psnr_db is not None) == is_rival
    table = methods_report.report([comparison.views()], PAPER, 1).tables[0]
    assert table.rows[0][5] == "1.00"
    assert [row[6] == "\N{EN DASH}" for row in table.rows] == 3 * [True] + 5 * [False]


# ---- the comparison -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def comparison():
    steps = []
    found, failed = comparing.measure(
        Subject("made.png", PHOTO, (FACE,)), PAPER, repeats=1, progress=lambda *at: steps.append(at)
    )
    assert failed == []
    runs = 2 * (len(METHODS) + sum(method.quick is not None for method in METHODS))
    assert steps[-1] == (runs, runs)
    return found


def test_all_are_compared_by_the_same_rule(comparison):
    assert [one.method for one in comparison.methods] == list(METHODS)
    for one in comparison.methods:
        assert set(one.pictures) == {"result", "difference", "heat"}
        assert {picture.shape for picture in one.pictures.values()} == {PHOTO.shape}
        assert one.largest_px > 0.8 * comparison.asked_px


def test_a_run_that_warms_up_leaves_the_figures_of_one_that_is_made_for_them(comparison):
    subject = Subject("made.png", PHOTO, (FACE,))
    cold, _ = comparing.measure(subject, PAPER, repeats=1, warm_up=0)
    for one, other in zip(comparison.methods, cold.methods, strict=True):
        for name in ("min_det", "folded_share", "moved_share", "largest_px"):
            assert getattr(one, name) == getattr(other, name)
        for name, picture in one.pictures.items():
            np.testing.assert_array_equal(picture, other.pictures[name])


def test_figures_agree_with_the_engines_own(comparison):
    rendering = render(PHOTO, [FACE], PAPER)
    ours = comparison.methods[0]
    assert ours.residual_mean_px == pytest.approx(rendering.residual.mean_px)
    assert ours.min_det == pytest.approx(rendering.one_to_one.min_det, abs=0.02)
    counts = rendering.pixel_counts
    assert ours.moved_share == pytest.approx(counts["threshold"] / counts["image"])


def test_stretch_and_compression_and_landing_are_told_of_each(comparison):
    for one in comparison.methods:
        assert one.min_det < 1.0 < one.max_det
        warp = one.method.fit(TASK)
        landed = source = TASK.target_px + TASK.displacement_px
        for _ in range(100):
            landed = source - warp.at(landed)
        apart = np.linalg.norm(landed - TASK.target_px, axis=1).mean()
        assert one.landing_mean_px == pytest.approx(apart, abs=1e-3)


def test_folds_are_seen():
    folding = Recipe(percent=15.0, lattice=0.3, fit="exact", guard=False)
    found, _ = comparing.measure(
        Subject("made.png", PHOTO, (FACE,)), folding, methods=METHODS[1:2], repeats=1
    )
    assert found.methods[0].min_det < 0.0
    assert found.methods[0].folded_share > 0.0


def test_absent_libraries_are_named_and_the_others_compared(monkeypatch):
    monkeypatch.setattr(comparing, "find_spec", lambda name: None if name == "skimage" else name)
    (sentence,) = comparing.missing()
    assert "scikit-image" in sentence
    assert adding("experiments") in sentence
    methods = [PIECEWISE_AFFINE, METHODS[0]]
    found, _ = comparing.measure(
        Subject("made.png", PHOTO, (FACE,)), PAPER, methods=methods, repeats=1
    )
    assert [one.method.name for one in found.methods] == ["approximation"]


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


def test_the_report_shows_all(comparison):
    report = methods_report.report([comparison.views()], PAPER, 1)
    json.dumps(report.document, allow_nan=False)
    told = page(report, Made.now("kogao-cli"))
    assert told.count("<img") == 1 + 3 * len(METHODS)
    assert len(list(methods_report.pictures(comparison))) == 3 * len(METHODS)
    cost, effect = report.tables
    assert len(cost.rows) == len(effect.rows) == len(METHODS)
    assert cost.rows[0][5] == "1.00"
