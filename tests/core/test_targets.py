"""Section 3.2: centre candidates and targets."""

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.faces.targets import aim, center_candidates
from kogao_core.recipe.recipe import Recipe


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
