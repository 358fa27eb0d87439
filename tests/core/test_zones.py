"""Section 3.2: centres and targets; zones weigh parts of an outline, sides are evened out."""

import dataclasses

import numpy as np
import pytest
from scenes import mirrored, oval_face, textured_photo

from kogao_core.faces.landmarks.sources import template_face
from kogao_core.faces.targets import aim, center_candidates
from kogao_core.faces.zones import evened, turn, weights
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

ZONES = ("chin", "jaw", "cheeks", "left", "right")
MANY = Recipe(percent=6, cheeks_width=4, jaw_width=-5, chin_length=-2, left_width=-6, even_out=70)


def crooked(by: float = 1.0, **place):
    """An oval face that bulges on its left, and whose chin is drawn to its right."""
    face = oval_face(**place)
    middle = face.middle
    bulge = np.exp(-(((np.arange(21) - 6.0) / 2.5) ** 2))
    outline = middle + (1.0 + 0.08 * by * bulge[:, None]) * (face.outline - middle)
    outline[:, 0] += 5.0 * by * np.exp(-(((np.arange(21) - 10.0) / 2.0) ** 2))
    return dataclasses.replace(face, outline=outline)


def turned(face, share):
    """The face with its eyes and mouth moved across, as a turned head shows them."""
    by = np.array([share * (face.outline[20, 0] - face.outline[0, 0]) / 2.0, 0.0])
    return dataclasses.replace(face, eyes=face.eyes + by, mouth=face.mouth + by)


@pytest.mark.parametrize(("candidate", "tenths"), [(1, 10), (2, 8), (3, 6), (4, 4.7)])
def test_candidates_divide_the_line_as_the_paper_says(candidate, tenths):
    face = oval_face()
    center = center_candidates(face)[candidate - 1]
    to_eyes = np.linalg.norm(center - face.eye_center)
    to_mouth = np.linalg.norm(center - face.mouth_center)
    assert to_eyes / (to_eyes + to_mouth) == pytest.approx(tenths / 10)


@pytest.mark.parametrize("percent", [2, 4, 6, 8, 10])
def test_each_landmark_moves_percent_of_its_own_distance_towards_the_centre(percent):
    face = oval_face()
    pairs = aim(face, Recipe(percent=percent, center=3))
    to_center = pairs.center_px - face.outline
    np.testing.assert_allclose(-pairs.displacement_px, percent / 100 * to_center, atol=1e-12)


def test_a_target_placed_by_hand_stays_and_the_others_follow_the_slider():
    face = oval_face().with_target(5, (100.0, 120.0))
    for percent in (2, 8):
        pairs = aim(face, Recipe(percent=percent))
        np.testing.assert_array_equal(pairs.target_px[5], (100.0, 120.0))
    automatic = aim(oval_face(), Recipe(percent=8)).target_px
    np.testing.assert_array_equal(np.delete(pairs.target_px, 5, 0), np.delete(automatic, 5, 0))
    released = face.with_target(5, None)
    assert released.targets is None


# -- nothing set is nothing done -------------------------------------------------------------------


def test_without_a_shape_targets_are_the_plain_ones_to_the_bit():
    face = crooked()
    for scope in ("head", "face"):
        pairs = aim(face, Recipe(percent=7.3, scope=scope))
        plain = face.outline + 7.3 / 100.0 * (pairs.center_px - face.outline)
        np.testing.assert_allclose(pairs.target_px, plain, atol=1e-9)
        if scope == "face":
            assert pairs.target_px.tobytes() == plain.tobytes()
    assert evened(face, 0.0).tobytes() == face.outline.tobytes()


# -- zones -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("zone", "alone", "never"),
    [
        ("chin", [10], [*range(6), *range(15, 21)]),
        ("jaw", [], [10]),
        ("cheeks", [], [0, 7, 8, 9, 10, 11, 12, 13, 20]),
        ("left", [0, 3, 5], [15, 18, 20]),
        ("right", [15, 18, 20], [0, 3, 5]),
    ],
)
def test_a_zone_moves_what_it_is_called_by(zone, alone, never):
    only = weights(template_face((240, 180), 200))[ZONES.index(zone)]
    np.testing.assert_allclose(only[alone], 1.0, atol=0.01)
    np.testing.assert_allclose(only[never], 0.0, atol=0.01)
    # Neither a step nor a kink at a zone's ends.
    assert only.min() >= 0.0
    assert only.max() > 0.7
    assert np.abs(np.diff(only)).max() < 0.5
    assert np.abs(np.diff(only, 2)).max() < 0.6


def test_cheeks_end_at_the_eye_line_and_are_widest_below_it():
    face = template_face((240, 180), 200)
    _, _, cheeks, left, right = weights(face)
    below = (face.outline[:, 1] - face.eye_center[1]) / (face.mouth_center - face.eye_center)[1]
    assert 0.3 < below[cheeks.argmax()] < 0.8
    assert cheeks[(below > 0.4) & (below < 0.6)].min() > 0.65
    assert cheeks[below < 0.1].max() < 0.1
    np.testing.assert_allclose(left + right, 1.0, atol=1e-12)


def test_a_mirrored_photo_is_made_the_mirrored_result():
    photo, face = textured_photo(), crooked()
    other_photo, other = mirrored(photo, face)
    many = dataclasses.replace(MANY, width=4, forehead_height=5)
    swapped = dataclasses.replace(many, left_width=0, right_width=-6)
    here, there = aim(face, many).target_px, aim(other, swapped).target_px
    np.testing.assert_allclose(there[::-1] * [-1, 1] + [photo.shape[1] - 1, 0], here, atol=1e-9)
    one, two = render(photo, [face], many).pixels, render(other_photo, [other], swapped).pixels
    apart = np.abs(one.astype(int) - two[:, ::-1])
    assert np.percentile(apart, 99.9) <= 2  # rounding of the map to 1/32 px
    assert np.percentile(np.abs(one.astype(int) - photo), 99.9) > 20


# -- evening out -----------------------------------------------------------------------------------


def unevenness(face, outline):
    """How far the outline differs from its mirror image, mean over landmarks, px."""
    other = dataclasses.replace(face, outline=outline)
    return float(np.linalg.norm(evened(other, 100.0) - outline, axis=1).mean())


def test_a_face_that_is_even_stays_as_it_is():
    face = oval_face()
    np.testing.assert_allclose(evened(face, 100.0), face.outline, atol=1e-9)


def test_the_more_it_is_evened_out_the_less_the_sides_differ():
    face = crooked()
    left = [unevenness(face, evened(face, percent)) for percent in (0, 25, 50, 75, 100)]
    assert left[0] > 1.0
    np.testing.assert_allclose(left, left[0] * np.array([1.0, 0.75, 0.5, 0.25, 0.0]), atol=0.2)
    assert (np.diff(left) < 0.0).all()


def test_the_more_a_head_is_turned_the_less_it_is_evened_out():
    shares = (0.0, 0.09, 0.15, 0.2, 0.26, 0.5)
    faces = [turned(crooked(), share) for share in shares]
    np.testing.assert_allclose([turn(face) for face in faces], shares, atol=1e-3)
    far = [np.abs(evened(face, 100.0) - face.outline).max() for face in faces]
    assert far[1] == pytest.approx(far[0], rel=0.15)
    assert far[1] > far[2] > far[3] > 0.0
    assert far[4:] == [0.0, 0.0]


@pytest.mark.parametrize("place", [[(0.0, 0.0)] * 21, [(5.0, float(k)) for k in range(21)]])
def test_an_outline_that_is_none_is_aimed_at_finite_places(place):
    for face in (oval_face(), dataclasses.replace(oval_face(), mouth=oval_face().eyes[1:3])):
        strange = dataclasses.replace(face, outline=np.array(place))
        assert np.isfinite(aim(strange, MANY).target_px).all()
