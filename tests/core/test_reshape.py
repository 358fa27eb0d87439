"""Neighbours follow a landmark along the outline, and the other side follows mirrored."""

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.base.geometry import Affine
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import influence, moved, opposite, reflection, with_target_moved
from kogao_core.faces.targets import aim
from kogao_core.recipe.recipe import Recipe

BY = np.array([-12.0, 5.0])


@pytest.fixture
def face() -> Face:
    return oval_face()


def test_influence_falls_along_the_outline_and_not_through_the_air():
    # A hairpin: the ends lie beside each other, but far apart along the outline.
    outline = np.array([(0.0, 0.0), (0.0, 10.0), (0.0, 20.0), (1.0, 20.0), (1.0, 10.0), (1.0, 0.0)])
    weights = influence(outline, 0, 20.0)
    np.testing.assert_allclose(weights, [1.0, 0.5, 0.0, 0.0, 0.0, 0.0], atol=1e-12)


def test_influence_is_smooth_and_counts_px_not_landmarks():
    even = np.column_stack([np.linspace(0.0, 100.0, 1001), np.zeros(1001)])
    weights = influence(even, 500, 30.0)
    assert weights[500:801:100] == pytest.approx([1.0, 0.75, 0.25, 0.0]), "half a cosine wave"
    assert np.abs(np.diff(weights, 2)).max() < 1.1 * 0.5 * (np.pi * 0.1 / 30.0) ** 2, "no kink"
    uneven = np.delete(even, np.arange(501, 600), axis=0)
    np.testing.assert_array_equal(influence(uneven, 500, 30.0)[501:], weights[600:])


@pytest.mark.parametrize("reach_px", [0.0, 1e-9])
def test_without_reach_a_landmark_moves_alone_to_the_bit(face, reach_px):
    to = face.outline[5] + BY
    alone = face.with_outline_point(5, to)
    np.testing.assert_array_equal(moved(face, 5, to, reach_px).outline, alone.outline)


def test_neighbours_follow_by_their_influence(face):
    to, reach_px = face.outline[5] + BY, 3.5 * face.anchor.spacing_px
    soft = moved(face, 5, to, reach_px)
    expected = influence(face.outline, 5, reach_px)[:, None] * BY
    np.testing.assert_allclose(soft.outline - face.outline, expected, atol=1e-9)
    np.testing.assert_array_equal(soft.outline[5], to)
    assert (np.flatnonzero((soft.outline != face.outline).any(axis=1)) == range(2, 9)).all()
    assert soft.anchor == face.anchor
    np.testing.assert_array_equal(soft.eyes, face.eyes)


def test_the_other_side_makes_the_mirrored_move(face):
    to = face.outline[4] + BY
    both = moved(face, 4, to, symmetric=True)
    step = both.outline - face.outline
    np.testing.assert_allclose(step[16], [-BY[0], BY[1]], atol=1e-9)
    assert (np.flatnonzero(step.any(axis=1)) == [4, 16]).all()


@pytest.mark.parametrize("reach", [0.0, 3.0, 15.0])
def test_a_symmetric_face_stays_symmetric_however_far_neighbours_follow(face, reach):
    """A turned head: the midline is the face's, not the picture's."""
    head = face.mapped(Affine.similarity(1.3, 25.0, (40.0, -10.0)))
    to = head.outline[7] + BY
    both = moved(head, 7, to, reach * head.anchor.spacing_px, symmetric=True)
    np.testing.assert_array_equal(both.outline[7], to)
    np.testing.assert_allclose(reflection(head)(both.outline)[::-1], both.outline, atol=1e-6)


def test_the_chin_has_nothing_opposite_and_moves_freely(face):
    assert opposite(face, 10) is None
    to = face.outline[10] + BY
    np.testing.assert_array_equal(moved(face, 10, to, symmetric=True).outline[10], to)


def test_opposite_is_by_place_where_the_sides_have_different_numbers(face):
    fewer = Face(np.delete(face.outline, [1, 3], axis=0), face.eyes, face.mouth)
    assert opposite(fewer, 0) == len(fewer.outline) - 1
    one_sided = Face(face.outline[:9], face.eyes, face.mouth)
    assert opposite(one_sided, 4) is None


# -- targets ---------------------------------------------------------------------------------------


@pytest.fixture
def targets(face):
    return aim(face, Recipe(percent=6.0)).target_px


def test_a_target_moves_alone_as_it_did_where_nothing_follows(face, targets):
    to = targets[5] + BY
    alone = with_target_moved(face, targets, 5, to)
    np.testing.assert_array_equal(alone.targets, face.with_target(5, to).targets)
    assert np.isfinite(alone.targets).all(axis=1).nonzero()[0].tolist() == [5]


@pytest.mark.parametrize("symmetric", [False, True])
def test_targets_take_their_neighbours_along_as_landmarks_do(face, targets, symmetric):
    to, reach_px = targets[5] + BY, 3.5 * face.anchor.spacing_px
    soft = with_target_moved(face, targets, 5, to, reach_px, symmetric=symmetric)
    like = moved(face, 5, face.outline[5] + BY, reach_px, symmetric=symmetric)
    steps = like.outline - face.outline
    follow = steps.any(axis=1)
    assert 5 < follow.sum() < 21
    np.testing.assert_allclose(soft.targets[follow], (targets + steps)[follow], atol=1e-9)
    assert np.isnan(soft.targets[~follow]).all(), "the others stay automatic"
    np.testing.assert_array_equal(soft.targets[5], to)
    np.testing.assert_array_equal(soft.outline, face.outline)
    assert soft.anchor == face.anchor


def test_targets_set_by_hand_follow_from_where_they_are_and_stay_beyond_the_reach(face):
    near, far = (0.0, 7.0), (3.0, 3.0)
    face = face.with_target(6, face.outline[6] + near).with_target(15, face.outline[15] + far)
    targets = aim(face, Recipe(percent=6.0)).target_px
    reach_px = 3.0 * face.anchor.spacing_px
    soft = with_target_moved(face, targets, 5, targets[5] + BY, reach_px)
    share = influence(face.outline, 5, reach_px)[6]
    np.testing.assert_allclose(soft.targets[6], face.outline[6] + near + share * BY, atol=1e-9)
    np.testing.assert_array_equal(soft.targets[15], face.targets[15])


def test_a_landmark_near_the_midline_has_no_opposite(face):
    beside = [
        face.with_outline_point(10, face.outline[10] + (share * face.anchor.spacing_px, 0.0))
        for share in (0.2, 0.3)
    ]
    assert [opposite(one, 10) is None for one in beside] == [True, False]
