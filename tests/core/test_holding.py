"""Lines of the background stay straight and neighbours put, and no face pays for it."""

import dataclasses

import numpy as np
import pytest
from bent import bend_px
from edges_along import held_along
from scenes import oval_face

from kogao_core.additions.lens import away_px
from kogao_core.background import holding
from kogao_core.background.holding import NOTHING_HELD, Held
from kogao_core.base.geometry import Affine
from kogao_core.field.field import shown_at
from kogao_core.field.protection import Protection
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER, Recipe

WIDTH, HEIGHT = 960, 720
PHOTO = np.zeros((HEIGHT, WIDTH), np.uint8)
FACE = oval_face(WIDTH, HEIGHT, size=0.5)
LEFT, RIGHT, CHIN = FACE.outline[:, 0].min(), FACE.outline[:, 0].max(), FACE.outline[:, 1].max()
RADIUS = 0.25 * HEIGHT
DOOR = np.array([[(LEFT - 0.15 * RADIUS, 60.0), (LEFT - 0.15 * RADIUS, 660.0)]])
RAIL = np.array([[(200.0, CHIN + 100.0), (760.0, CHIN + 80.0)]])
HORIZON = np.array([[(20.0, 400.0), (LEFT - 3.0, 400.0)]])
PLANKS = np.array(
    [
        [(x, CHIN - 60.0), (x, 710.0)]
        for x in (LEFT - 10.0, LEFT + 10.0, LEFT + 30.0, RIGHT - 30.0, RIGHT + 10.0)
    ]
)


def turned_degrees(field, line):
    """The angle between the best straight line through places of a line before and after."""
    shown = shown_at(field, line[0] + np.linspace(0.0, 1.0, 24)[:, None] * (line[1] - line[0]))
    way = np.linalg.svd(shown - shown.mean(axis=0), full_matrices=False)[2][0]
    along = (line[1] - line[0]) / np.hypot(*(line[1] - line[0]))
    return float(np.degrees(np.arcsin(abs(way[0] * along[1] - way[1] * along[0]))))


def warped(lines, faces=(FACE,), **choices):
    held = held_along(lines, faces) if len(lines) else NOTHING_HELD
    return render(PHOTO, faces, Recipe(**choices), held=held)


@pytest.mark.parametrize("fit", ["approximation", "exact", "multilevel"])
@pytest.mark.parametrize(("percent", "most_px"), [(4, 0.75), (8, 1.6)])
@pytest.mark.parametrize("lines", [RAIL, np.vstack([DOOR, RAIL])], ids=["rail", "both"])
def test_a_line_stays_straight_and_landmarks_go_where_they_did(lines, percent, most_px, fit):
    made = warped(lines, percent=percent, fit=fit)
    assert bend_px(made.field, lines) < min(most_px, 0.4 * bend_px(made.unheld, lines))
    targets = made.pairs[0].target_px
    np.testing.assert_allclose(made.field.at(targets), made.unheld.at(targets), atol=2e-3)
    assert made.one_to_one.certified
    assert made.shares == (1.0,)


@pytest.mark.parametrize("lines", [PLANKS, np.vstack([RAIL, RAIL - (0.0, 12.0)])])
def test_nothing_is_blown_up_so_that_a_line_stays_straight(lines):
    made = warped(lines, percent=8)
    places = np.stack(np.meshgrid(np.arange(0, WIDTH, 6), np.arange(0, HEIGHT, 6)), axis=-1)
    held, free = (
        np.linalg.norm(field.at(places.reshape(-1, 2).astype(float)), axis=1).max()
        for field in (made.field, made.unheld)
    )
    assert made.field.lattices != made.unheld.lattices
    assert held < 1.35 * free


@pytest.mark.parametrize("percent", [4, 8])
@pytest.mark.parametrize("lines", [DOOR, PLANKS], ids=["door", "planks"])
def test_the_face_within_its_outline_is_as_it_would_be(lines, percent):
    made = warped(lines, percent=percent)
    brows = FACE.eyes - (0.0, 0.15 * RADIUS)
    places = np.vstack([FACE.eyes, brows, FACE.mouth, 0.5 * (FACE.outline + FACE.eye_center)])
    moved = np.abs(made.unheld.at(FACE.outline)).max()
    assert made.field.lattices != made.unheld.lattices
    assert np.abs(made.field.at(places) - made.unheld.at(places)).max() < 0.25 * moved


@pytest.mark.parametrize("percent", [4, 8])
def test_no_corner_of_an_eye_goes_along_however_near_to_the_outline(percent):
    wide = FACE.eyes + np.array([(-15.0, 0.0), (0.0, 0.0), (0.0, 0.0), (15.0, 0.0)])
    face = dataclasses.replace(FACE, eyes=wide)
    bars = [[(LEFT - x, 60.0), (LEFT - x + lean, 660.0)] for x in (8, 18, 30) for lean in (0, 9)]
    made = warped(np.array(bars), (face,), percent=percent)
    moved = np.abs(made.pairs[0].displacement_px).max()
    corners = np.vstack([face.eyes, face.mouth])
    assert made.field.lattices != made.unheld.lattices
    assert np.abs(made.field.at(corners) - made.unheld.at(corners)).max() < 0.202 * moved


def test_a_short_line_may_shift_as_a_whole_and_does_not_turn():
    short = np.array([[(LEFT - 25.0, 250.0), (LEFT - 25.0, 330.0)]])
    made = warped(short, percent=8, scope="face")
    assert np.abs(made.field.at(short[0])[:, 0]).min() > 1.0
    assert turned_degrees(made.unheld, short[0]) > 1.5
    assert turned_degrees(made.field, short[0]) < 0.5 * turned_degrees(made.unheld, short[0])
    assert bend_px(made.field, short) < 0.8 * bend_px(made.unheld, short)


@pytest.mark.parametrize("percent", [6, 10])
def test_a_line_cut_by_the_head_makes_no_roof(percent):
    left, right = ([[(x, 470.0), (x + 230.0, 470.0)]] for x in (60.0, 670.0))
    made = warped(np.array([*left, *right]), percent=percent)
    for (line,) in (left, right):
        line = np.array(line)
        assert turned_degrees(made.unheld, line) > 1.5
        assert turned_degrees(made.field, line) < 0.3 * turned_degrees(made.unheld, line)


@pytest.mark.parametrize("percent", [4, 8])
def test_a_line_that_somebody_stands_before_is_straight_on_either_side_of_them(percent):
    x, y = LEFT + 5.0, CHIN - 120.0
    above_the_head, beside_the_jaw = np.array([[[(x, 5.0), (x, 90.0)]], [[(x, y), (x, y + 80.0)]]])
    made = warped(np.vstack([above_the_head, beside_the_jaw]), percent=percent)
    assert bend_px(made.field, beside_the_jaw) < 0.8 * bend_px(made.unheld, beside_the_jaw)


@pytest.mark.parametrize(("point", "length"), [(15, 40.0), (14, 40.0), (16, 80.0)])
def test_a_line_that_would_bend_more_for_being_held_is_let_go(point, length):
    x, y = FACE.outline[point] + (5.0, 5.0)
    below_the_jaw = np.array([[(x, y), (x, y + length)]])
    made = warped(np.vstack([below_the_jaw, DOOR]), percent=8)
    assert bend_px(made.field, below_the_jaw) < bend_px(made.unheld, below_the_jaw) + 0.5
    assert bend_px(made.field, DOOR) < 0.4 * bend_px(made.unheld, DOOR)


def test_a_line_may_slide_and_shift():
    made = warped(DOOR, percent=8)
    along = DOOR[0, 0] + np.linspace(0.2, 0.8, 50)[:, None] * (DOOR[0, 1] - DOOR[0, 0])
    moved = np.abs(made.field.at(along))
    assert moved.max(axis=0).min() > 1.0
    assert bend_px(made.field, DOOR) < 0.3 * bend_px(made.unheld, DOOR)


@pytest.mark.parametrize("percent", [4, 8, 12, 15])
def test_a_line_that_meets_the_jaw_gives_way_and_the_face_does_not(percent):
    across = np.array([[(20.0, 330.0), (940.0, 420.0)], [(LEFT + 2.0, 60.0), (LEFT + 2.0, 660.0)]])
    held = warped(np.vstack([HORIZON, across]), percent=percent)
    free = warped((), percent=percent)
    assert held.shares == free.shares
    assert held.achieved == pytest.approx(free.achieved, abs=0.02)
    assert held.one_to_one.certified == free.one_to_one.certified
    assert held.one_to_one.min_det >= min(0.5, 0.9 * free.one_to_one.min_det)
    assert held.residual.contour_max_px < free.residual.contour_max_px + 0.02 * RADIUS


def test_switched_off_or_nothing_known_it_changes_no_bit():
    (before,) = warped((), percent=8).field.lattices
    off = warped(DOOR, percent=8, hold_background=False)
    (after,) = off.field.lattices
    assert (after.grid, after.first) == (before.grid, before.first)
    np.testing.assert_array_equal(after.phi, before.phi)
    assert not PAPER.hold_background


def test_what_is_far_from_every_line_moves_as_it_did():
    far = np.array([[(930.0, 20.0), (930.0, 700.0)]])
    made = warped(far, percent=8)
    points = np.random.default_rng(1).uniform((0, 0), (WIDTH, HEIGHT), (500, 2))
    was, unseen = made.unheld.at(points), holding._UNSEEN * FACE.anchor.spacing_px
    np.testing.assert_allclose(made.field.at(points), was, atol=unseen)
    near = away_px(points, FACE.outline) < FACE.anchor.spacing_px
    assert near.sum() > 30
    np.testing.assert_allclose(made.field.at(points[near]), was[near], atol=0.05)


def test_a_smaller_photo_holds_the_same():
    half = Affine.resize(0.5, 0.5)
    large = warped(DOOR, percent=8).field
    faces, held = [FACE.mapped(half)], held_along(DOOR, [FACE]).mapped(half)
    small = render(PHOTO[::2, ::2], faces, Recipe(percent=8), held=held).field
    points = np.random.default_rng(1).uniform((200, 100), (700, 650), (200, 2))
    np.testing.assert_allclose(small.at(half(points)), large.at(points) / 2.0, atol=0.02)


def test_protected_places_stay_where_a_line_is_held_beside_them():
    still = Protection().with_stroke([(LEFT - 40.0, 300.0), (LEFT - 40.0, 420.0)])
    made = render(PHOTO, [FACE], Recipe(percent=6), protection=still, held=held_along(RAIL, [FACE]))
    points = np.column_stack([np.full(40, LEFT - 40.0), np.linspace(300.0, 420.0, 40)])
    assert np.abs(made.field.at(points)).max() < 1e-9


def test_a_neighbour_is_not_dragged_along():
    beside = oval_face(WIDTH, HEIGHT, center=(RIGHT + 172.0, 380.0), size=0.5)
    held = Held(neighbours=(np.insert(beside.outline, 2, 0.0, axis=1),), others=(beside,))
    made = render(PHOTO, [FACE], Recipe(percent=8), held=held)
    alone = render(PHOTO, [FACE], Recipe(percent=8), held=NOTHING_HELD)
    width = np.ptp(beside.outline[:, 0])
    assert np.abs(alone.field.at(beside.outline)).max() > 0.04 * width
    assert np.abs(made.field.at(beside.outline)).max() < 0.002 * width
    assert made.residual.max_px < 0.01


def test_faces_that_reach_into_each_other_keep_their_landmarks_and_the_line():
    other = oval_face(WIDTH, HEIGHT, center=(RIGHT + 175.0, 380.0), size=0.5)
    line = np.array([[(RIGHT + 18.0, 60.0), (RIGHT + 18.0, 260.0)]])
    # Away from the photo's edge, which holds faces, too.
    inwards = Affine(np.eye(2), np.array([-150.0, 0.0]))
    faces, line = [face.mapped(inwards) for face in (FACE, other)], inwards(line[0])[None]
    made = warped(line, faces, percent=5)
    assert bend_px(made.field, line) < 0.5 * bend_px(made.unheld, line)
    assert made.residual.max_px < 0.05
    assert made.one_to_one.settled


def test_a_threshold_that_was_proven_stays_so():
    made = warped(DOOR, percent=8, threshold_px=1.0)
    assert made.unheld.fade_px == made.field.fade_px > 0.0
    assert made.one_to_one.edges_proven


def counted(counts, name):
    """A method of the equations that counts its calls."""
    plain = getattr(holding._Steady, name)

    def method(*given):
        counts[name] += 1
        return plain(*given)

    return method


def test_a_drag_builds_and_solves_the_dragged_face_alone_and_keeps_the_newest(monkeypatch):
    counts = {"__init__": 0, "_solved": 0}
    for name in counts:
        monkeypatch.setattr(holding._Steady, name, counted(counts, name))
    far = FACE.mapped(Affine.resize(0.3, 0.3))
    held = held_along(DOOR, [FACE, far])
    for step in range(4):
        moved = FACE.with_outline_point(10, FACE.outline[10] + (0.0, 2.0 * step))
        render(PHOTO, [moved, far], Recipe(percent=6), held=held)
    # Each build makes a small and a large set of equations; DOOR is out of reach of `far`.
    assert counts == {"__init__": 4 + 2 * 4 - 2, "_solved": 4 + 1}
    assert len(held.built) == 2


def test_equations_end_at_the_photos_edge():
    tight = PHOTO[: int(CHIN) + 50, int(LEFT) - 60 : int(RIGHT) + 60]
    face = FACE.mapped(Affine(np.eye(2), np.array([60.0 - int(LEFT), 0.0])))
    sizes = []
    for photo, one in ((PHOTO, FACE), (tight, face)):
        held = held_along([one.outline[[2, 2]] - [(30.0, 40.0), (30.0, -160.0)]], [one])
        render(photo, [one], Recipe(percent=6), held=held)
        (_, (steady,)) = held.built[0]
        sizes.append(len(steady._whitening))
    assert sizes[1] < 0.6 * sizes[0]


def test_earlier_settings_on_the_same_photo_change_nothing():
    small = FACE.mapped(Affine.resize(0.4, 0.4))
    x = small.outline[:, 0].min() - 60.0
    held = held_along(np.array([[(x, 5.0), (x, 700.0)]]), [small])
    held = dataclasses.replace(held, neighbours=(np.array([[x, 150.0, 0.0]]),))
    far = {"percent": 15.0, "width": -15.0, "length": -15.0, "jaw_width": -15.0}
    fresh = render(PHOTO, [small], Recipe(**far), held=dataclasses.replace(held, built={}))
    render(PHOTO, [small], Recipe(percent=4), held=held)
    later = render(PHOTO, [small], Recipe(**far), held=held)
    (expected,), (found,) = fresh.field.lattices, later.field.lattices
    np.testing.assert_array_equal(found.phi, expected.phi)


def test_a_line_through_a_face_that_is_left_alone_hardly_moves_it():
    apart = oval_face(WIDTH, HEIGHT, center=(RIGHT + 200.0, 400.0), size=0.3)
    through = np.array([[(RIGHT + 20.0, 400.0), (950.0, 380.0)]])
    held = dataclasses.replace(held_along(through, [FACE], (apart.points,)), others=(apart,))
    made = render(PHOTO, [FACE], Recipe(percent=8), held=held)
    moved = np.abs(made.field.at(apart.points)).max()
    assert moved < 0.05
