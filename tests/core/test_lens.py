"""What a lens stretched off its axis comes back; all else takes up the difference, unfolded."""

import dataclasses
from itertools import pairwise

import cv2
import numpy as np
import pytest
from bent import bend_px
from edges_along import held_along
from scenes import read_outside_px, textured_photo

import kogao_core as kogao
from kogao_core.additions.lens import (
    STRETCH_SEEN_PERCENT,
    distance_m,
    distance_note,
    nose_percent,
    stretch_percent,
)
from kogao_core.background.holding import Held
from kogao_core.base.geometry import Affine, Box
from kogao_core.faces.face import Face
from kogao_core.field.field import shown_at
from kogao_core.field.protection import Protection
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER, Recipe

WIDTH, HEIGHT = 900, 600
PHOTO = Box(0, 0, WIDTH, HEIGHT)
MIDDLE = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
LENS = Recipe(percent=0.0, lens=26.0)


def focal_px(focal_mm):
    """The frame is one of 36 x 24 mm."""
    return focal_mm / 36.0 * WIDTH


def on_axis(size=60.0, *, turned=0.0):
    """A face as the camera sees it that is aimed at it, its middle in (0, 0)."""
    turn = Affine.similarity(1.0, turned, (0.0, 0.0))
    face = kogao.template_face((0.0, 0.0), size)
    return face.mapped(turn.after(Affine(np.eye(2), -np.array(face.anchor.origin_px))))


def off_axis(face, offset, focal_mm):
    """The same face through the camera aimed at the middle of the photo: a homography."""
    f, far = focal_px(focal_mm), np.hypot(*offset)
    to = np.array([*offset, f]) / np.hypot(far, f)
    axis = np.cross([0.0, 0.0, 1.0], to)
    turn = cv2.Rodrigues(axis / max(np.linalg.norm(axis), 1e-12) * np.arccos(to[2]))[0]
    lens = np.diag([f, f, 1.0])

    def through(points):
        seen = (
            np.column_stack([points, np.ones(len(points))]) @ (lens @ turn @ np.linalg.inv(lens)).T
        )
        return seen[:, :2] / seen[:, 2:] + MIDDLE

    return Face(through(face.outline), through(face.eyes), through(face.mouth))


def residual(truth, face, field=None):
    """What is left of the truth after the best similarity, % of the distance of the eyes.

    Of the landmarks that the photo shows.
    """
    seen = ((face.points >= 0.0) & (face.points <= 2.0 * MIDDLE)).all(axis=1)
    after = face.points if field is None else shown_at(field, face.points)
    p, q = (points[seen] - points[seen].mean(axis=0) for points in (truth.points, after))
    p, q = p[:, 0] + 1j * p[:, 1], q[:, 0] + 1j * q[:, 1]
    scale = np.vdot(p, q) / np.vdot(p, p)
    left = np.sqrt((np.abs(q - scale * p) ** 2).mean())
    return 100.0 * left / (abs(scale) * truth.interocular_px)


def rendered(recipe, *faces, **more):
    return render(textured_photo(WIDTH, HEIGHT, 3), faces, recipe, **more)


def field_of(recipe, *faces):
    """What the whole photo is warped by, with only a corner of it drawn."""
    return render(np.zeros((8, 8), np.uint8), faces, recipe, whole=PHOTO).field


@pytest.mark.parametrize(("turned", "focal_mm"), [(0.0, 26.0), (25.0, 35.0)])
@pytest.mark.parametrize(
    "share", [(0.4, 0.1), (0.6, -0.3), (-0.75, 0.0), (0.0, 0.5), (-0.7, -0.4), (0.85, 0.2)]
)
def test_a_head_comes_back_as_if_the_camera_had_been_aimed_at_it(share, turned, focal_mm):
    truth = on_axis(turned=turned)
    face = off_axis(truth, np.array(share) * MIDDLE, focal_mm)
    before = residual(truth, face)
    made = rendered(dataclasses.replace(LENS, lens=focal_mm), face)
    assert residual(truth, face, made.field) < min(0.07, 0.02 * before)
    assert made.one_to_one.min_det >= 0.6
    assert made.one_to_one.certified
    assert made.shares == (1.0,)


@pytest.mark.parametrize("fit", ["exact", "approximation", "multilevel"])
def test_the_small_face_goes_on_top(fit):
    truth = on_axis()
    face = off_axis(truth, (300.0, -60.0), 26.0)
    made = rendered(dataclasses.replace(LENS, percent=5.0, fit=fit), face)
    assert made.achieved[0] == pytest.approx(5.0, abs=1e-3 if fit == "exact" else 1.5)
    aimed_at = off_axis(truth, (0.0, 0.0), 26.0)
    small = dataclasses.replace(LENS, percent=5.0, fit=fit, lens="off")

    def shape(of, recipe):
        seen = shown_at(field_of(recipe, of), np.vstack([of.eyes, of.mouth]))
        return np.ptp(seen[:, 0]) / np.ptp(seen[:, 1])

    wanted = shape(aimed_at, small)
    assert shape(face, dataclasses.replace(small, lens=26.0)) == pytest.approx(wanted, rel=0.01)
    assert shape(face, small) > 1.05 * wanted


@pytest.mark.parametrize("recipe", [Recipe(), PAPER, Recipe(percent=0.0)])
def test_off_and_nothing_of_it_change_no_byte(recipe):
    face = off_axis(on_axis(), (300.0, 0.0), 26.0)
    plain = rendered(recipe, face).pixels
    for other in ({"lens": "off", "lens_amount": 30.0}, {"lens": "auto"}):
        made = rendered(dataclasses.replace(recipe, **other), face)
        np.testing.assert_array_equal(made.pixels, plain)


def test_a_face_on_the_axis_keeps_every_byte():
    photo = textured_photo(WIDTH, HEIGHT, 3)
    x, y = MIDDLE - np.array(kogao.template_face((0, 0), 120).anchor.origin_px)
    face = kogao.template_face((x, y), 120)
    np.testing.assert_array_equal(render(photo, [face], LENS).pixels, photo)


def test_the_amount_is_a_share_of_it_and_each_face_may_have_its_own():
    left, right = (off_axis(on_axis(), (x, 0.0), 26.0) for x in (-320.0, 320.0))
    field = field_of(LENS, left, right)
    half = field_of(dataclasses.replace(LENS, lens_amount=50.0), left, right)
    np.testing.assert_allclose(half.at(left.points), field.at(left.points) / 2.0, atol=0.3)
    off = dataclasses.replace(left, recipe=dataclasses.replace(LENS, lens_amount=0.0))
    alone = field_of(LENS, off, right)
    assert np.abs(alone.at(left.points)).max() < 0.1
    np.testing.assert_allclose(alone.at(right.points), field.at(right.points), atol=0.1)


@pytest.mark.parametrize("recipe", [LENS, dataclasses.replace(LENS, percent=6.0)])
@pytest.mark.parametrize("center", [(20.0, 300.0), (875.0, 80.0), (450.0, 10.0), (870.0, 590.0)])
def test_a_head_cut_by_the_photos_edge_slides_along_it(center, recipe):
    face = kogao.template_face(center, 150)
    made = rendered(recipe, face)
    assert read_outside_px(made.field, PHOTO) < 0.02
    assert made.one_to_one.min_det >= 0.5


def test_half_a_face_at_the_edge_is_right_all_the_same():
    truth = on_axis(90.0)
    face = off_axis(truth, (425.0, 0.0), 26.0)
    assert face.outline[:, 0].max() > WIDTH
    made = rendered(LENS, face)
    assert residual(truth, face, made.field) < 1.0 < residual(truth, face)


@pytest.mark.parametrize("apart", [30.0, 65.0, 130.0])
def test_faces_that_touch_share_one_field(apart):
    truth = on_axis()
    faces = [off_axis(truth, (360.0 - k * apart, 8.0 * k), 26.0) for k in range(4)]
    made = rendered(LENS, *faces)
    assert made.shares == (1.0,) * 4
    assert made.one_to_one.min_det >= 0.6
    for face in faces:
        assert residual(truth, face, made.field) < 0.95


def test_a_line_beside_the_head_stays_straight():
    face = off_axis(on_axis(), (330.0, 0.0), 26.0)
    line = np.array([[(690.0, 20.0), (690.0, 580.0)]])
    photo = textured_photo(WIDTH, HEIGHT, 3)
    made = render(photo, [face], LENS, held=held_along(line, [face]))
    width, free_px = np.ptp(face.outline[:, 0]), bend_px(made.unheld, line)
    assert bend_px(made.field, line) < 0.0025 * width < 0.01 * free_px * width


def test_neighbours_and_protected_places_stay():
    face = off_axis(on_axis(), (330.0, 0.0), 26.0)
    beside = np.column_stack([np.full(60, 660.0), np.linspace(240.0, 420.0, 60)])
    made = rendered(LENS, face, held=Held(neighbours=(np.insert(beside, 2, 0.0, axis=1),)))
    assert np.abs(made.field.at(beside)).max() < 0.5
    line = Protection().with_stroke([(660.0, 240.0), (660.0, 420.0)], radius_px=2.0)
    made = rendered(LENS, face, protection=line)
    assert not made.field.at(beside).any()
    assert made.one_to_one.certified


def test_the_result_is_a_continuous_function_of_where_a_face_is():
    """From the axis to the edge and over it: no step is larger than those beside it by much."""
    fields = []
    for x in np.linspace(450.0, 895.0, 90):
        face = kogao.template_face((x, 250.0), 90)
        fields.append(field_of(LENS, face).at(face.points))
    steps = [np.abs(b - a).max() for a, b in pairwise(fields)]
    assert max(steps) < 2.0  # px, where the face itself goes 5 px


def test_the_meter_says_how_much_longer_a_head_is_than_wide():
    for slope, reported in ((0.0, False), (0.11, False), (0.18, True), (0.5, True)):
        face = off_axis(on_axis(30.0), (slope * focal_px(26.0), 0.0), 26.0)
        percent = stretch_percent(face, 26.0, PHOTO)
        assert percent == pytest.approx(100.0 * (np.hypot(1.0, slope) - 1.0), abs=0.02)
        assert (percent >= STRETCH_SEEN_PERCENT) is reported


def adult(distance, aside, *, yaw=0.0, nod=0.0):
    """An adult's eyes and mouth so many metres from a camera of 26 mm, aside of its axis.

    `distance` to the middle of the eyes, `aside` its (x, y) in the photo from the middle, px.
    """
    to = np.array([*aside, focal_px(26.0)])
    eyes = np.array([(x, 0.0, 0.0) for x in (-0.0435, -0.015, 0.015, 0.0435)])
    turn = cv2.Rodrigues(np.array([0.0, np.radians(yaw), 0.0]))[0]
    turn = turn @ cv2.Rodrigues(np.array([np.radians(nod), 0.0, 0.0]))[0]
    faced = cv2.Rodrigues(np.cross([0.0, 0.0, 1.0], to / np.linalg.norm(to)))[0]
    there = np.vstack([eyes, [(-0.025, 0.068, 0.0), (0.025, 0.068, 0.0)]]) @ (faced @ turn).T
    there = there + distance * to / np.linalg.norm(to)
    seen = focal_px(26.0) * there[:, :2] / there[:, 2:] + MIDDLE
    return Face(np.vstack([seen, seen[::-1]]), seen[:4], seen[4:])


@pytest.mark.parametrize("aside", [(0.0, 0.0), (300.0, -100.0), (-380.0, 200.0)])
@pytest.mark.parametrize("distance", [0.3, 0.8, 3.0])
def test_how_far_the_camera_was_is_said_wherever_the_face_is(distance, aside):
    assert distance_m(adult(distance, aside), 26.0, PHOTO) == pytest.approx(distance, rel=0.02)
    for turned in ({"yaw": 35.0}, {"nod": 25.0}):
        found = distance_m(adult(distance, aside, **turned), 26.0, PHOTO)
        assert found == pytest.approx(distance, rel=0.1)


def test_a_nose_is_told_of_where_the_camera_was_near():
    assert nose_percent(1.5) == pytest.approx(0.0)
    assert 15.0 < nose_percent(0.4) < 20.0 < nose_percent(0.33)
    assert all(a > b for a, b in pairwise(map(nose_percent, (0.1, 0.3, 0.6, 1.0, 3.0))))
    assert "about 40 cm from the camera (36 to 44)" in distance_note(0.4)
    assert "a nose looks 16 % larger" in distance_note(0.4)
    assert distance_note(2.0) == "about 2.0 m from the camera (1.8 to 2.2)"
