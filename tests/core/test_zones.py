"""Zones weigh the parts of an outline smoothly, and its sides can be evened out."""

import dataclasses

import numpy as np
import pytest
from scenes import mirrored, oval_face, textured_photo

from kogao_core.faces.landmarks.sources import template_face
from kogao_core.faces.targets import aim
from kogao_core.faces.zones import evened, gains, turn
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

GAINS = ("cheeks", "jaw", "chin", "left", "right")
MANY = Recipe(percent=6, cheeks=40, jaw=180, chin=90, left=150, right=20, even_out=70)


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


def moves(face, recipe):
    """How far each landmark moves, px."""
    return np.linalg.norm(aim(face, recipe).displacement_px, axis=1)


# -- nothing set is nothing done -------------------------------------------------------------------


def test_all_at_100_is_the_plain_target_to_the_bit():
    face = crooked()
    pairs = aim(face, Recipe(percent=7.3))
    plain = face.outline + 7.3 / 100.0 * (pairs.center_px - face.outline)
    assert pairs.target_px.tobytes() == plain.tobytes()
    assert evened(face, 0.0).tobytes() == face.outline.tobytes()


def test_switched_off_zones_render_the_same_bytes_as_none():
    photo, face = textured_photo(), crooked()
    without = render(photo, [face], Recipe(percent=6)).pixels
    off = dataclasses.replace(MANY, zones=False)
    assert render(photo, [face], off).pixels.tobytes() == without.tobytes()
    assert render(photo, [face], MANY).pixels.tobytes() != without.tobytes()


# -- zones -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("zone", "alone", "never"),
    [
        ("chin", [10], [*range(6), *range(15, 21)]),
        ("jaw", [], [10]),
        ("cheeks", [0, 1, 19, 20], [7, 8, 9, 10, 11, 12, 13]),
        ("left", [0, 3, 5], [15, 18, 20]),
        ("right", [15, 18, 20], [0, 3, 5]),
    ],
)
def test_a_zone_moves_what_it_is_called_by(zone, alone, never):
    face = template_face((240, 180), 200)
    rest = dict.fromkeys(({"left", "right"} if zone in {"left", "right"} else set(GAINS[:3])), 0.0)
    only = gains(face, Recipe(**{**rest, zone: 100.0}))
    np.testing.assert_allclose(only[alone], 1.0, atol=0.01)
    np.testing.assert_allclose(only[never], 0.0, atol=0.01)


def test_zones_share_every_landmark_smoothly():
    face = template_face((240, 180), 200)
    for zones in (GAINS[:3], GAINS[3:]):
        none = dict.fromkeys(zones, 0.0)
        weights = [gains(face, Recipe(**{**none, zone: 100.0})) for zone in zones]
        np.testing.assert_allclose(np.sum(weights, axis=0), 1.0, atol=1e-12)
        assert np.min(weights) >= -1e-12
        # No step, and no kink, where one passes into the other.
        assert np.abs(np.diff(weights, axis=1)).max() < 0.5
        assert np.abs(np.diff(weights, 2, axis=1)).max() < 0.35


@pytest.mark.parametrize("zone", GAINS)
def test_more_of_a_zone_moves_no_landmark_less(zone):
    before = np.zeros(21)
    for percent in (0, 30, 100, 150, 200):
        after = moves(crooked(), Recipe(percent=6, **{zone: percent}))
        assert (after >= before - 1e-9).all()
        before = after
    assert after.max() > 1.5 * moves(crooked(), Recipe(percent=6)).min()


def test_a_mirrored_photo_is_made_the_mirrored_result():
    photo, face = textured_photo(), crooked()
    other_photo, other = mirrored(photo, face)
    shape = {"width": 4, "jaw_width": -7, "forehead_height": 5}
    many = dataclasses.replace(MANY, left_width=-6, **shape)
    swapped = dataclasses.replace(MANY, left=MANY.right, right=MANY.left, right_width=-6, **shape)
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


def test_something_moves_at_zero_percent_where_sides_are_evened_out():
    photo = textured_photo()
    rendering = render(photo, [crooked()], Recipe(percent=0, even_out=50))
    assert rendering.pixels.tobytes() != photo.tobytes()
    assert rendering.residual.max_px < 0.01


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
