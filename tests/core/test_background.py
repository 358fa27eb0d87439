"""The meter of lines goes by the background: lines of people are left out, others cut at them."""

import dataclasses
import re

import cv2
import numpy as np
import pytest
from few_cases import few_of
from scenes import oval_face
from threadpoolctl import threadpool_info, threadpool_limits

from kogao_core.background import find as backgrounds
from kogao_core.background.find import BackgroundFinder, held_of, measure
from kogao_core.background.holding import NOTHING_HELD, Held
from kogao_core.background.lines import straight_lines
from kogao_core.background.people import PersonLook, PersonMask
from kogao_core.base.assets import AssetMissing
from kogao_core.base.geometry import Affine, Box
from kogao_core.faces.landmarks import ModelRefused
from kogao_core.field.protection import NOTHING
from kogao_core.pipeline import render
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.recipe import Recipe

WIDTH, HEIGHT = 960, 720
FACE = oval_face(WIDTH, HEIGHT, size=0.5)
RECIPE = Recipe(percent=8)
MISSING = "network that tells people apart is missing or damaged .*, so lines of hair"


class Finder:
    """Stands in for the network: people are where it is told."""

    def __init__(self, opacity=None, missed=0):
        self.opacity, self.missed = opacity, missed

    def find(self, _photo, faces):
        if isinstance(self.opacity, Exception):
            raise self.opacity
        if self.opacity is None:
            return PersonMask((), len(faces))
        # A look is square: the photo's own pixels, and nothing known below it.
        still = Affine.similarity(1.0, 0.0, (0.0, 0.0))
        return PersonMask((PersonLook(self.opacity, still, 1.0),), self.missed, (0,))


def photo_with(*lines):
    photo = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    for start, end in lines:
        cv2.line(photo, start, end, (200, 200, 200), 5, cv2.LINE_AA)
    return photo


def found_in(photo, finder, others=()):
    return BackgroundFinder(finder).find(photo, [FACE], others)


def people(left, top, right, bottom):
    opacity = np.zeros((WIDTH, WIDTH), np.float32)
    opacity[top:bottom, left:right] = 1.0
    return opacity


LEFT, RIGHT = FACE.outline[:, 0].min(), FACE.outline[:, 0].max()
BODY = people(int(LEFT), 100, int(RIGHT), HEIGHT)


def test_a_shelf_behind_a_person_is_cut_on_both_sides():
    photo = photo_with(((20, 660), (940, 660)))
    found = found_in(photo, Finder(BODY))
    assert found.note == ""
    apart = 0.03 * max(FACE.box[2:])
    for low, high in np.sort(found.lines[..., 0]):
        assert high < int(LEFT) - apart / 2 or low > int(RIGHT) + apart / 2
    assert {bool(low < WIDTH / 2) for low, _ in np.sort(found.lines[..., 0])} == {True, False}
    assert any(high > LEFT - 3 * apart for _, high in np.sort(found.lines[..., 0]) if high < LEFT)


@pytest.mark.parametrize(
    ("opacity", "words"),
    [
        (None, "couldn't be told from the background, so lines of hair"),
        (AssetMissing("gone"), MISSING),
        (ModelRefused("bad"), MISSING),
    ],
)
def test_without_a_mask_all_but_the_faces_lines_count_and_it_is_said(opacity, words):
    collar, on_face = ((420, 660), (540, 700)), ((440, 360), (520, 360))
    photo = photo_with(collar, on_face)
    found = found_in(photo, Finder(opacity))
    assert re.search(words, found.note)
    assert found.lines[..., 1].min() > 600
    assert len(found.lines) > 0
    assert found.held() is NOTHING_HELD


def test_who_could_not_be_told_from_the_background_is_counted():
    photo = photo_with(((30, 60), (30, 660)))
    found = found_in(photo, Finder(BODY, missed=2))
    assert "2 faces couldn't be told" in found.note


def test_halves_left_and_right_of_a_person_are_one_line():
    photo = photo_with(((20, 660), (940, 660)))
    done, finder = Applied([FACE], RECIPE, NOTHING), BackgroundFinder(Finder(BODY))
    told = measure(photo, render(photo, [FACE], RECIPE), done, finder).lines
    sides = {bool(line.start_px[0] < WIDTH / 2) for line in told}
    assert sides == {True, False}
    for y in (656, 664):  # both edges of the shelf
        one = [line for line in told if abs(line.start_px[1] - y) < 2]
        assert len(one) == 2
        assert len({(line.number, line.rise_permille) for line in one}) == 1
    assert all(line.clearness > 0.9 for line in told)


def test_lines_of_people_and_where_nobody_looked_are_not_sought():
    collar, door = ((420, 640), (540, 700)), ((30, 60), (30, 660))
    photo = photo_with(collar, door)
    assert {bool(x < 100) for x in straight_lines(photo)[..., 0].ravel()} == {True, False}
    still = Affine.similarity(1.0, 0.0, (0.0, 0.0))
    found = straight_lines(photo, people=PersonMask((PersonLook(BODY, still, 1.0),)))
    on_collar = (np.abs(found.mean(axis=1) - np.mean(collar, axis=0)) < 40).all(axis=1)
    assert any(abs(x - 30) < 5 for x in found[..., 0].ravel())
    assert not on_collar.any()
    aside = Affine.similarity(1.0, 0.0, (300.0, 0.0))
    found = straight_lines(photo, people=PersonMask((PersonLook(BODY[:, 300:], aside, 1.0),)))
    assert (found[..., 0] > 290).all()


def test_lines_of_a_large_photo_are_sought_at_half_its_size():
    half = photo_with(((30, 60), (50, 660)))
    large = straight_lines(half.repeat(2, axis=0).repeat(2, axis=1))
    np.testing.assert_allclose(large, 2.0 * straight_lines(half) + 0.5)


@pytest.mark.parametrize(("length", "counts"), [(6, False), (10, True)])
def test_a_few_pixels_are_no_line(length, counts):
    photo = np.full((80, 80, 3), 90, np.uint8)
    cv2.line(photo, (40, 30), (40, 30 + length), (220, 220, 220), 2)
    assert bool(len(straight_lines(photo))) is counts


def test_lines_that_are_let_go_are_not_held_and_the_meter_says_so():
    door, shelf = ((30, 60), (30, 660)), ((700, 60), (700, 300))
    photo = photo_with(door, shelf)
    seen = found_in(photo, Finder(BODY))
    upright = [tuple(map(tuple, line.tolist())) for line in seen.lines if line[0, 0] < 100]
    (every,), (some,) = seen.held().edges, seen.held(upright).edges
    on_door = every.places_px[:, 0, 0] < 200
    assert every.weights[on_door].max() > 100.0 > 0.0 == some.weights[on_door].max()
    np.testing.assert_array_equal(every.weights[~on_door], some.weights[~on_door])
    wide = dataclasses.replace(RECIPE, lattice=4.0, percent=4.0)
    done = Applied([FACE], wide, NOTHING, loose=tuple(upright))
    finder = BackgroundFinder(Finder(BODY))
    rendering = render(photo, [FACE], wide, held=held_of(photo, done, finder))
    told = measure(photo, rendering, done, finder).lines
    assert {line.holding for line in told if line.start_px[0] > 100} == {"held"}
    assert {line.holding for line in told if line.start_px[0] < 100} == {"let go"}


@pytest.mark.parametrize(
    ("percent", "free", "degrees", "word"),
    [(8.0, False, 0.63, "held"), (3.0, True, 2.2, "held"), (8.0, True, 6.4, "gave way")],
)
def test_only_a_line_that_hardly_turns_is_said_to_be_held(percent, free, degrees, word):
    photo, recipe = photo_with(((int(RIGHT) + 40, 60), (int(RIGHT) + 40, 400))), Recipe(percent)
    done, finder = Applied([FACE], recipe, NOTHING), BackgroundFinder(Finder(BODY))
    held = Held() if free else held_of(photo, done, finder)
    worst = measure(photo, render(photo, [FACE], recipe, held=held), done, finder).lines[0]
    assert worst.turn_degrees == pytest.approx(degrees, rel=0.5 if not free else 0.1)
    assert worst.holding == word


def test_a_line_found_a_little_elsewhere_is_still_the_one_let_go():
    seen = found_in(photo_with(((30, 60), (30, 660))), Finder(BODY))
    line = seen.lines[0]
    again = tuple(map(tuple, (line + np.array([0.2 * seen.shortest_px, 40.0])).tolist()))
    elsewhere = tuple(map(tuple, (line + np.array([0.5 * seen.shortest_px, 0.0])).tolist()))
    assert seen.is_loose(line, [again])
    assert not seen.is_loose(line, [elsewhere])


def test_a_recipe_that_holds_nothing_looks_for_nothing():
    photo, finder = photo_with(), BackgroundFinder(Finder(RuntimeError("looked")))
    done = Applied([FACE], Recipe(hold_background=False), NOTHING)
    assert held_of(photo, done, finder) is NOTHING_HELD


def test_looking_wakes_no_threads_of_blas():
    """Small products woke the second thread, which took ten times the processor time."""
    counts = []

    class Counting(Finder):
        def find(self, photo, faces):
            counts.extend(one["num_threads"] for one in threadpool_info() if "blas" in one.values())
            return super().find(photo, faces)

    with threadpool_limits(2, "blas"):
        found_in(photo_with(), Counting(BODY))
    assert set(counts) == {1}


def test_a_figure_apart_and_a_face_left_alone_are_neighbours():
    apart = BODY.copy()
    apart[100:, int(RIGHT) + 60 : int(RIGHT) + 160] = 1.0
    apart[20:42, 20:42] = 1.0  # too small for a person
    apart[20:68, int(RIGHT) + 200 : int(RIGHT) + 248] = 1.0  # just large enough
    (points,) = found_in(photo_with(), Finder(apart)).neighbours
    assert points[:, 0].min() > RIGHT + 50
    assert RIGHT + 240 < points[:, 0].max() < RIGHT + 258
    small = points[:, 0] > RIGHT + 180
    assert (points[~small, 2] == 0.0).all()
    assert points[small, 2].min() > 3.0 * FACE.anchor.spacing_px
    touching = BODY.copy()
    touching[100:, int(LEFT) :] = 1.0
    assert len(found_in(photo_with(), Finder(touching)).neighbours[0]) == 0
    other = oval_face(WIDTH, HEIGHT, center=(RIGHT + 160.0, 340.0), size=0.5)
    (points,) = found_in(photo_with(), Finder(touching), [other]).neighbours
    middle = (FACE.box[0] + FACE.box[2] / 2 + other.box[0] + other.box[2] / 2) / 2
    assert len(points) > 50
    assert np.sort(points[:, 0])[len(other.points)] > middle - 10


def test_a_photo_is_looked_at_once_for_the_same_faces(monkeypatch):
    sought = []
    monkeypatch.setattr(
        backgrounds, "straight_lines", lambda *photo: sought.append(1) or straight_lines(*photo)
    )
    photo, finder = photo_with(((30, 60), (30, 660))), BackgroundFinder(Finder(BODY))
    first = finder.find(photo, [FACE])
    assert finder.find(photo, [FACE]) is first
    assert len(sought) == 1
    finder.find(photo, [FACE.with_outline_point(3, (300.0, 300.0))])
    finder.find(photo.copy(), [FACE])
    assert len(sought) == 3


@pytest.mark.parametrize("side", few_of([160, 60], 1))
def test_a_figure_that_grows_surer_comes_without_a_step(side):
    """Neither the size nor the opacity of a figure beside decides by a threshold."""
    moved, photo = [], photo_with()
    for opacity in np.linspace(0.45, 0.95, 26):
        body = BODY.copy()
        body[260 : 260 + side, int(RIGHT) + 60 : int(RIGHT) + 60 + side] = opacity
        held = found_in(photo, Finder(body)).held()
        field = render(photo[:8, :8], [FACE], RECIPE, held=held, whole=Box.of(photo)).field
        moved.append(field.at(np.array([[RIGHT + 60.0, 300.0], [RIGHT + 90.0, 270.0]])))
    steps = np.abs(np.diff(moved, axis=0)).max(axis=(1, 2))
    assert np.abs(moved[-1] - moved[0]).max() > 1.0
    assert steps.max() < 0.25 * np.abs(moved[-1] - moved[0]).max()
