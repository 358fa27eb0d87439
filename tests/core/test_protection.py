"""Protected places keep their pixels and the face beside them is undamaged."""

import dataclasses
import itertools

import cv2
import numpy as np
import pytest
from bent import bend_px
from edges_along import held_along
from few_cases import few_of
from scenes import oval_face, textured_photo

from kogao_core.additions.brush import Brushwork
from kogao_core.additions.pivot import attract_pivots
from kogao_core.background.lines import straight_lines
from kogao_core.base.geometry import Affine
from kogao_core.faces.targets import aim
from kogao_core.field.field import Field, shown_at
from kogao_core.field.measures import reduced
from kogao_core.field.one_to_one import protected_slopes
from kogao_core.field.protection import Protection, Stroke, axes, sampled, share
from kogao_core.paper.lattice import Grid, Lattice
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import SETTINGS, Recipe

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
def test_a_protected_door_frame_stays_and_the_face_beside_it_is_undamaged(fit):
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    line, recipe = door_frame(face), Recipe(percent=8, fit=fit)
    photo = photo_of(line)
    free = render(photo, [face], recipe)
    held = render(photo, [face], recipe, protection=Protection((Stroke(line, radius_px=4.0),)))
    before, after = bend_px(free.field, line[None]), bend_px(held.field, line[None])
    assert before > 1.5, "the frame doesn't bend without protection: nothing to show"
    assert after < 1e-9
    assert held.shares == (1.0,)
    assert held.one_to_one.certified
    columns, rows = round(line[0, 0]) + np.arange(-3, 4), np.arange(70, 650)
    np.testing.assert_array_equal(held.pixels[rows][:, columns], photo[rows][:, columns])


def strokes_round(face):
    """Layouts of strokes beside, across and round a face, each with its width."""
    width, (low, high) = np.ptp(face.outline[:, 0]), (face.box[1], face.box[1] + face.box[3])
    for away in (0.01, 0.04, 0.1, 0.18):
        for side, x in ((-1, face.outline[:, 0].min()), (1, face.outline[:, 0].max())):
            upright = [(x + side * away * width, y) for y in (low, high)]
            for radius in (0.0, 0.03 * width):
                yield Protection().with_stroke(upright, radius)
    ear, chin = face.outline[2], face.outline[10]
    yield Protection().with_stroke(ear + np.outer((-0.1, 0.05), (width, 0.0)), 5.0)
    yield Protection().with_stroke(chin + np.outer((-1.0, 1.0), (0.2 * width, 9.0)), 5.0)
    ring = [ear + 0.1 * width * np.array((np.cos(t), np.sin(t))) for t in np.arange(0.0, 6.5, 0.3)]
    yield Protection().with_stroke(ring, 3.0)
    both = Protection().with_stroke([ear - (12.0, 40.0), ear - (12.0, -40.0)], 4.0)
    yield both.with_stroke([ear - (52.0, 40.0), ear - (52.0, -40.0)], 4.0)


@pytest.mark.parametrize("percent", few_of([8.0, 4.0], 1))
def test_no_stroke_round_a_face_squeezes_the_picture_or_holds_the_whole_face_back(percent):
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    photo, recipe = textured_photo(WIDTH, HEIGHT), Recipe(percent=percent)
    unprotected = render(photo, [face], recipe)
    free, moved = unprotected.one_to_one.min_det, []
    for protection in strokes_round(face):
        made = render(photo, [face], recipe, protection=protection)
        assert made.shares == (1.0,)
        assert made.one_to_one.certified
        assert made.one_to_one.min_det > min(0.55, free)
        shares = np.array(made.protected_shares[0])
        apart = [
            np.hypot(*(s.points_px[:, None] - face.outline).transpose(2, 0, 1)).min(axis=0)
            for s in (Stroke(_dense(s.points_px)) for s in protection.strokes)
        ]
        far = np.min(apart, axis=0) > 0.3 * np.ptp(face.outline[:, 0])
        assert shares[far].min(initial=1.0) > 0.9
        assert shares[far].mean() > 0.98
        places = np.concatenate([_dense(s.points_px) for s in protection.strokes])
        moved.append(np.hypot(*unprotected.field.at(places).T).max())
    assert np.mean(np.array(moved) > 2.0) > 0.8, "the strokes are too far away to show anything"


def test_strokes_beside_held_lines_keep_their_pixels_and_squeeze_nothing():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    photo, frame = textured_photo(WIDTH, HEIGHT), door_frame(face)
    held = held_along([frame, [(200.0, 640.0), (760.0, 620.0)]], [face])
    for protection in itertools.islice(strokes_round(face), 1, None, 4):
        made = render(photo, [face], RECIPE, protection=protection, held=held)
        assert made.shares == (1.0,)
        assert made.one_to_one.certified
        assert made.one_to_one.min_det > 0.45
        assert made.field.lattices != made.unheld.lattices
        places = np.concatenate([_dense(s.points_px) for s in protection.strokes])
        x, y = np.rint(places[((places > 0) & (places < (WIDTH - 1, HEIGHT - 1))).all(axis=1)]).T
        at = y.astype(int), x.astype(int)
        np.testing.assert_array_equal(made.pixels[at], photo[at])


@pytest.mark.parametrize("percent", [4.0, 8.0, -6.0])
def test_a_face_keeps_its_shape_beside_protected_places_and_shrinks_by_the_whole_amount(percent):
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    photo, recipe = np.zeros((HEIGHT, WIDTH), np.uint8), Recipe(percent=percent)
    (ear, chin), width = face.outline[[2, 10]], np.ptp(face.outline[:, 0])
    upright = Protection().with_stroke([ear - (0.05 * width, y) for y in (250.0, -200.0)], 8.0)
    below = Protection().with_stroke([chin + np.array((x, 14.0)) for x in (-80.0, 80.0)], 6.0)
    eye = Protection().with_stroke([face.eyes[:2].mean(axis=0)], 0.1 * width)
    for protection in (upright, below, eye):
        made = render(photo, [face], recipe, protection=protection)
        shown = shown_at(made.field, face.points)
        similarity, _ = cv2.estimateAffinePartial2D(face.points, shown, method=cv2.LMEDS)
        expected = face.points @ similarity[:, :2].T + similarity[:, 2]
        assert np.sqrt(((shown - expected) ** 2).sum(axis=1).mean()) < 0.01 * width
        assert np.linalg.det(similarity[:, :2]) == pytest.approx((1 - percent / 100) ** 2, rel=0.02)


def test_a_stroke_that_approaches_a_face_moves_its_targets_gradually():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    pairs, step = aim(face, RECIPE), 3.0
    x = np.arange(5.0, face.outline[:, 0].max(), step)
    strokes = [(Stroke([(at, 300.0), (at, 500.0)], 4.0),) for at in x]
    targets = np.array([attract_pivots([pairs], [face], one)[0].target_px for one in strokes])
    np.testing.assert_array_equal(targets[0], pairs.target_px)
    shifts = np.hypot(*np.diff(targets[:, 0], axis=0).T)
    assert 0.0 < shifts.max() < 0.3 * step


@pytest.mark.parametrize("step_px", [1e-9, 40.0])
def test_places_along_strokes_are_limited_and_stand_for_the_whole_length(step_px):
    strokes = Stroke([(0.0, 0.0), (3000.0, 4000.0)], 5.0), Stroke([(9.0, 9.0)], 5.0)
    places = sampled(strokes, step_px)
    assert len(places) <= 20_002
    assert places[:, 2].sum() == pytest.approx(5000.0 + 2.0 * 10.0)


def test_targets_placed_by_hand_and_faces_that_move_alone_ignore_protected_places():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    near = (Stroke(face.outline[:4] - (9.0, 0.0), 4.0),)
    targets = np.full_like(face.outline, np.nan)
    targets[3] = face.outline[3] + (2.0, 5.0)
    by_hand = dataclasses.replace(face, targets=targets)
    before = aim(by_hand, RECIPE)
    (after,) = attract_pivots([before], [by_hand], near)
    moved = np.hypot(*(after.target_px - before.target_px).T)
    assert moved[3] == 0.0
    np.testing.assert_allclose(np.delete(moved, 3), moved[0])
    assert moved[0] > 1.0
    alone = aim(face, Recipe(percent=8, scope="face"))
    (unchanged,) = attract_pivots([alone], [face], near)
    np.testing.assert_array_equal(unchanged.target_px, alone.target_px)
    np.testing.assert_array_equal(unchanged.center_px, alone.center_px)


def _dense(line):
    """The corners of a line and places between them, (N, 2)."""
    t = np.linspace(0.0, 1.0, 50)[:, None]
    return np.concatenate([a + t * (b - a) for a, b in itertools.pairwise(line)])


def test_a_far_stroke_changes_nothing():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    far = Protection().with_stroke([[20.0, 20.0], [20.0, 700.0]], 10.0)
    photo = textured_photo(WIDTH, HEIGHT)
    free, held = render(photo, [face], RECIPE), render(photo, [face], RECIPE, protection=far)
    np.testing.assert_allclose(free.pixels.astype(int), held.pixels, atol=3)  # rounding
    places = np.arange(0, WIDTH, 3), np.arange(0, HEIGHT, 3)
    np.testing.assert_array_equal(free.field.on_grid(*places), held.field.on_grid(*places))
    assert set(held.protected_shares[0]) == {1.0}


def test_protection_holds_with_faces_that_touch_brush_strokes_and_lens_correction():
    row = [oval_face(WIDTH, HEIGHT, size=0.36, center=(x, 360.0)) for x in (300.0, 560.0)]
    work = Brushwork().with_stroke("push", [(430.0, 330.0), (470.0, 350.0)], 60.0)
    work = work.with_stroke("restore", [(240.0, 420.0), (280.0, 460.0)], 50.0, 1.0)
    still = Protection().with_stroke([(432.0, 100.0), (440.0, 640.0)], 5.0)
    still = still.with_stroke([(180.0, 300.0), (200.0, 420.0), (260.0, 500.0)], 6.0)
    recipe, photo = Recipe(percent=6, lens=24.0), textured_photo(WIDTH, HEIGHT)
    made = render(photo, row, recipe, protection=still, brushwork=work)
    assert made.one_to_one.min_det > 0.1
    places = np.stack(np.meshgrid(np.arange(160, 460), np.arange(90, 660)), -1).reshape(-1, 2)
    covered = share(still.strokes, *places.T.astype(np.float64), np.ones((2, len(places)))) == 0.0
    assert covered.sum() > 4000
    x, y = places[covered].T
    np.testing.assert_array_equal(made.pixels[y, x], photo[y, x])
    density = np.arange(400.0, 480.0, 0.7), np.arange(250.0, 450.0, 0.7)
    assert made.field.det_jacobian(*density).min() > 0.0


def test_a_landmark_counts_as_reduced_below_95_percent_of_its_way():
    assert reduced([(1.0, 0.97), (0.93, 0.4)]) == [0.93, 0.4]


def test_the_faded_displacement_has_the_slopes_it_says_and_keeps_its_bound():
    rng = np.random.default_rng(4)
    lattice = Lattice(Grid((0.0, 0.0), 20.0), (-2, -2), rng.normal(0.0, 2.0, (14, 14, 2)))
    strokes = (
        Stroke([[40.0, 30.0], [90.0, 60.0], [110.0, 150.0]], 3.0),
        Stroke([[150.0, 50.0]], 9.0),
    )
    field = Field((lattice,), 0.0, Protection(strokes))
    xs, ys, step = np.arange(0.0, 200.0, 1.7), np.arange(0.0, 190.0, 2.3), 1e-5
    faded, (along_x, along_y) = field.on_grid(xs, ys), field.slopes(xs, ys)
    assert (faded == 0.0).all(axis=0).any()
    points = np.stack(np.meshgrid(xs, ys), -1).reshape(-1, 2)
    np.testing.assert_allclose(field.at(points).T.reshape(faded.shape), faded, atol=1e-12)
    numeric_x = (field.on_grid(xs + step, ys) - field.on_grid(xs - step, ys)) / (2 * step)
    numeric_y = (field.on_grid(xs, ys + step) - field.on_grid(xs, ys - step)) / (2 * step)
    # Inside the bend of a line the slope jumps: a few points may sit there.
    wrong = np.abs(np.stack([numeric_x - along_x, numeric_y - along_y])).max(axis=(0, 1)) > 1e-4
    assert wrong.mean() < 0.001
    norms = np.linalg.norm(np.stack([along_x, along_y]).transpose(2, 3, 1, 0), ord=2, axis=(2, 3))
    kept = share(strokes, *axes(xs, ys), Field((lattice,)).on_grid(xs, ys))
    assert norms[kept < 1.0].max() <= max(slope.max() for _, slope in protected_slopes(field))


def test_the_frame_is_found_and_bends_as_seen():
    face = oval_face(WIDTH, HEIGHT, size=0.5)
    line = door_frame(face)
    photo = photo_of(line)
    rendering = render(photo, [face], RECIPE)
    found = straight_lines(photo)
    upright = [ends for ends in found if abs(ends[0, 0] - ends[1, 0]) < 3]
    assert any(abs(ends[:, 0].mean() - line[0, 0]) < 6 for ends in upright)
    rows = np.arange(80, 640)
    bright = np.where(rendering.pixels[rows, :, 0] > 220, 1.0, 0.0)
    seen = (bright * np.arange(WIDTH)).sum(axis=1) / np.maximum(1.0, bright.sum(axis=1))
    straight = np.polyval(np.polyfit(rows, seen, 1), rows)
    assert bend_px(rendering.field, line[None]) == pytest.approx(
        np.abs(seen - straight).max(), abs=0.8
    )


def test_no_lines_in_a_plain_picture():
    assert straight_lines(np.full((300, 400, 3), 90, np.uint8)).shape[0] == 0
    noise = np.random.default_rng(0).integers(0, 2, (5, 40), np.uint8) * 255
    for small in (noise, noise.T, noise[:1, :1]):
        assert straight_lines(small).shape[0] == 0
    assert straight_lines(np.zeros((9, 65535), np.uint8)).shape[0] == 0  # no row is left of it


def test_strokes_follow_their_image_and_broken_ones_are_refused():
    stroke = Stroke(np.array([[0.0, 0.0], [30.0, 40.0]]), 3.0)
    moved = Protection((stroke,)).mapped(Affine.similarity(2.0, 0.0, (1.0, 1.0)))
    np.testing.assert_allclose(moved.strokes[0].points_px[1], (61.0, 81.0))
    assert moved.strokes[0].radius_px == 6.0
    for broken in (np.zeros((0, 2)), [[np.nan, 0.0]]):
        with pytest.raises(ValueError, match="stroke"):
            Stroke(broken)
    for radius in (-1.0, np.inf):
        with pytest.raises(ValueError, match="radius"):
            Stroke([[0.0, 0.0]], radius)


def test_an_eraser_leaves_nothing_under_it_and_all_else_as_it_was():
    line = Stroke([[0.0, 0.0], [60.0, 0.0], [60.0, 80.0]], radius_px=5.0)
    far, dot = Stroke([[200.0, 200.0]], 5.0), Stroke([[61.0, 40.0]])
    erased = Protection((line, far, dot)).erased([[60.0, 36.0], [60.0, 44.0]], 8.0)
    first, second, third = erased.strokes
    assert third is far
    assert first.radius_px == 5.0
    np.testing.assert_array_equal(first.points_px[:2], line.points_px[:2])
    np.testing.assert_allclose(first.points_px[-1], (60.0, 36.0 - 13.0), atol=13 / 8)
    np.testing.assert_allclose(second.points_px[0], (60.0, 44.0 + 13.0), atol=13 / 8)
    rubber = _dense(np.array([[60.0, 36.0], [60.0, 44.0]]))
    for part in (first, second):
        apart = np.linalg.norm(_dense(part.points_px)[:, None] - rubber, axis=2)
        assert apart.min() >= 13.0 - 0.1
    untouched = Protection((line,)).erased([[0.0, 100.0]], 8.0)
    assert untouched.strokes[0] is line
    assert not Protection((dot,)).erased([[60.0, 40.0]], 2.0).strokes
