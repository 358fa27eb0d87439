"""What lies far from the photo, or asks for too much, is refused before it is tried."""

import dataclasses
import re

import numpy as np
import pytest
from scenes import ALONE, oval_face, textured_photo

from kogao_core.additions.brush import Brushwork
from kogao_core.additions.exact import _Design, _ridge_solution
from kogao_core.additions.fit import fit, spacing_px
from kogao_core.additions.limits import (
    MOST_CONTROL_POINTS,
    OutOfBounds,
    check_brushwork,
    check_corners,
    check_faces,
    check_protection,
    check_strokes,
    size_px,
)
from kogao_core.base.geometry import Box
from kogao_core.faces.face import Anchor, Face
from kogao_core.faces.targets import aim
from kogao_core.field.protection import Protection
from kogao_core.paper.fit import Problem, multilevel
from kogao_core.paper.lattice import Grid, Lattice, groups
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

IMAGE = Box(0, 0, 480, 360)


def moved_point(index, position):
    outline = oval_face().outline.copy()
    outline[index] = position
    return dataclasses.replace(oval_face(), outline=outline)


def rendered(faces, recipe=None, protection=None, size=(480, 360)):
    photo = np.zeros((size[1], size[0]), np.uint8)
    recipe = recipe or Recipe()
    return render(photo, faces, recipe, protection=protection or Protection(), threads=1)


def fitted(faces, recipe):
    pairs = [aim(face, recipe) for face in faces]
    return fit(pairs, [face.anchor for face in faces], [recipe] * len(faces))


# ---- places ---------------------------------------------------------------------------------


@pytest.mark.parametrize("position", [(1260.0, 90.0), (126_000.0, 90.0), (200.0, -900.0)])
def test_a_slipped_decimal_point_is_found_and_named(position):
    face = moved_point(3, position)
    with pytest.raises(OutOfBounds, match=r"landmark 4 of face 2 lies at .* ends at 479, 359"):
        check_faces([oval_face(), face], IMAGE, typed=True)


def test_faces_that_the_edge_crops_are_fine():
    half_out = oval_face(center=(0.0, 170.0))
    larger_than_the_photo = oval_face(1900, 1400, center=(240.0, 180.0))
    a_little_out = moved_point(0, (-30.0, 100.0))
    for typed in (True, False):
        check_faces([half_out, larger_than_the_photo, a_little_out], IMAGE, typed=typed)
    assert rendered([half_out, a_little_out]).shares == (1.0, 1.0)


def test_a_face_isnt_larger_for_one_point_far_away():
    assert size_px(moved_point(3, (1e6, 1e6))) < 1.1 * size_px(oval_face())
    assert 0.7 < size_px(oval_face()) / oval_face().box[3] < 1.3


def test_targets_far_outside_are_refused_and_automatic_ones_lie_nowhere():
    check_faces([oval_face().with_target(4, (10.0, 10.0))], IMAGE)
    with pytest.raises(OutOfBounds, match="target 5 of face 1"):
        check_faces([oval_face().with_target(4, (1e5, 10.0))], IMAGE)


@pytest.mark.parametrize(
    ("line", "width", "words"),
    [
        ([[0, 0], [1e9, 1e9]], 0.0, "corner 2 of protected line 1"),
        ([[1e308, 0], [5, 5]], 0.0, "corner 1 of protected line 1"),
        ([[0, 0], [5, 5]], 1e9, "is wider than"),
        ([[0, 0], [5, 5]] * 10_000, 0.0, "20000 corners"),
    ],
)
def test_protection_far_outside_too_wide_or_too_long_is_refused(line, width, words):
    with pytest.raises(OutOfBounds, match=words):
        check_protection(Protection().with_stroke(line, width), IMAGE)
    check_protection(Protection().with_stroke([[0, -300], [0, 700]], 60.0), IMAGE)


# ---- products -------------------------------------------------------------------------------


def test_hundreds_of_faces_on_one_another_are_refused():
    # The face alone: what surrounds each of many faces is sought among all others.
    with pytest.raises(OutOfBounds, match="5040 landmarks") as refused:
        fitted([oval_face()] * 240, ALONE)
    assert re.fullmatch(r"[^\n]{20,300}", str(refused.value))


def test_more_faces_in_one_place_than_anybody_has_are_refused():
    crowd, size = [oval_face()] * 20, size_px(oval_face())
    beside, aside = (oval_face(center=(239.5 + k * size, 172.8)) for k in (0.2, 0.3))
    check_faces([*crowd, aside], IMAGE)
    with pytest.raises(OutOfBounds, match="21 faces lie where face 1 does"):
        check_faces([*crowd, beside], IMAGE)


def push(radius_px, *points):
    return Brushwork().with_stroke("push", points, radius_px)


@pytest.mark.parametrize(
    ("check", "allowed", "refused"),
    [
        (check_corners, *(Protection().with_stroke([(5, 5)] * n) for n in (10_000, 10_001))),
        (lambda it: check_protection(it, IMAGE),
         *(Protection().with_stroke([(5, 5)], radius) for radius in (512.0, 513.0))),
        (lambda it: check_brushwork(it, IMAGE), push(1024, (5, 5)), push(1025, (5, 5))),
        (check_strokes, *(push(100, (0, 0), (end, 0)) for end in (409_000, 410_000))),
        (check_strokes, *(push(4, (0, 0), (side, side)) for side in (1_010, 1_020))),
    ],
)  # fmt: skip
def test_strokes_up_to_a_limit_are_allowed(check, allowed, refused):
    check(allowed)
    with pytest.raises(OutOfBounds):
        check(refused)


def test_more_than_a_hundred_people_who_touch_are_worked_on():
    pitch = 60.0
    places = [((k % 10 + 0.5) * pitch, (k // 10 + 0.5) * pitch) for k in range(120)]
    crowd = [oval_face(600, 600, center=place, size=0.09) for place in places]
    for recipe in (Recipe(fit="approximation"), Recipe(fit="multilevel")):
        lattices = fitted(crowd, recipe)
        assert len(groups(lattices)) == 1, "the faces don't touch: this test shows nothing"
        assert all(lattice.phi.any() for lattice in lattices)


@pytest.mark.parametrize(
    "recipe",
    [Recipe(lattice=0.1, threshold_px=1.0), Recipe(lattice=0.1, fit="multilevel", threshold_px=1)],
)
def test_what_many_faces_and_a_fine_lattice_take_together_is_refused(recipe):
    places = [(x, y) for x in range(100, 4000, 400) for y in range(100, 3000, 400)]
    faces = [oval_face(400, 400, center=place) for place in places]
    with pytest.raises(OutOfBounds, match=f"at most {MOST_CONTROL_POINTS}"):
        fitted(faces, recipe)
    assert rendered(faces[:1], Recipe(lattice=0.1)).field.lattices[0].phi.any()


def test_a_frame_far_smaller_than_its_face_is_refused():
    small = dataclasses.replace(oval_face(9600, 7200), pinned_anchor=Anchor((4800.0, 3600.0), 1e-9))
    with pytest.raises(OutOfBounds, match="control points"):
        rendered([small])


@pytest.mark.parametrize("shape", [(60, 20), (20, 60)])
def test_many_places_and_many_control_points_are_solved_alike(shape):
    """Whichever matrix is smaller: least squares, and the shortest such solution."""
    rng = np.random.default_rng(3)
    weights, displacements = rng.normal(size=shape), rng.normal(size=(shape[0], 2))
    rows = np.arange(shape[0])
    half = shape[1] // 2
    parts = [_Design(rows, weights[:, :half]), _Design(rows[5:], weights[5:, half:])]
    weights[:5, half:] = 0.0
    expected, *_ = np.linalg.lstsq(weights, displacements, rcond=None)
    solved = _ridge_solution(parts, displacements, np.zeros(len(displacements)), np.inf)
    np.testing.assert_allclose(solved, expected, atol=1e-6)


# ---- lattices -------------------------------------------------------------------------------


def test_a_warp_distance_of_nothing_keeps_the_lattice_coarse():
    face = oval_face(4800, 3600)
    still = Recipe(percent=0, lattice_unit="warp")
    spacing = spacing_px(aim(face, still), face.anchor, still)
    assert spacing == pytest.approx(0.05 * face.anchor.spacing_px)
    (lattice,) = fit([aim(face, still)], [face.anchor], [still])
    assert np.prod(lattice.shape) < 60_000
    assert not lattice.phi.any()


def test_at_0_percent_nothing_is_fitted(monkeypatch):
    monkeypatch.setattr("kogao_core.additions.exact._ridge_solution", None)
    photo = textured_photo()
    result = render(photo, [oval_face(), oval_face(size=0.3)], Recipe(percent=0), threads=1)
    np.testing.assert_array_equal(result.pixels, photo)


def test_a_multilevel_fit_stops_at_the_least_spacing():
    grid = Grid((0.0, 0.0), 8.0)
    target = np.array([[20.0, 20.0], [21.0, 20.0]])
    apart = Problem(grid, target, np.array([[3.0, 0.0], [-3.0, 0.0]]))
    assert multilevel(apart).grid.spacing_px == 1.0
    assert multilevel(dataclasses.replace(apart, least_px=3.0)).grid.spacing_px == 4.0


def test_a_lattice_cut_to_the_image_is_the_same_there():
    rng = np.random.default_rng(2)
    lattice = Lattice(Grid((13.7, -4.2), 31.0), (-9, -7), rng.normal(0, 3, (30, 40, 2)))
    image = Box(0, 0, 320, 200)
    cut = lattice.within(image)
    assert cut.phi.size < 0.3 * lattice.phi.size
    xs, ys = np.arange(320), np.arange(200)
    np.testing.assert_array_equal(cut.on_grid(xs, ys), lattice.on_grid(xs, ys))
    elsewhere = Lattice(lattice.grid, (500, 500), lattice.phi).within(image)
    assert not elsewhere.on_grid(xs, ys).any()


def test_a_huge_frame_costs_no_more_than_the_photo():
    huge = dataclasses.replace(oval_face(), pinned_anchor=Anchor((240.0, 180.0), 1e7))
    domain = rendered([huge], Recipe(lattice=8.0)).domain
    assert domain.cells[0].active.size < 10_000


# ---- coordinates that are none --------------------------------------------------------------


@pytest.mark.parametrize(
    ("part", "bad"), [("outline", np.nan), ("eyes", np.inf), ("mouth", -np.inf)]
)
def test_a_face_refuses_coordinates_that_are_no_numbers(part, bad):
    face = oval_face()
    points = {name: getattr(face, name).copy() for name in ("outline", "eyes", "mouth")}
    points[part][1, 0] = bad
    with pytest.raises(ValueError, match=f"face's {part} can't be used.*finite"):
        Face(**points)


def test_half_a_target_and_an_anchor_without_size_are_refused():
    with pytest.raises(ValueError, match="only one coordinate"):
        oval_face().with_target(3, (np.nan, 5.0))
    for origin, spacing in (((0.0, np.nan), 5.0), ((0.0, 0.0), 0.0), ((0.0, 0.0), np.inf)):
        with pytest.raises(ValueError, match="anchor"):
            Anchor(origin, spacing)
