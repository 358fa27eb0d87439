"""The pivot of a head, and the Amount that the photo allows."""

import numpy as np
import pytest
from scenes import textured_photo

from kogao_core.base.geometry import Affine, Box
from kogao_core.faces.head import HeadFrame, limited, pivot_and_share
from kogao_core.faces.landmarks.sources import template_face
from kogao_core.faces.targets import aim
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

FACE = template_face((1000.0, 1000.0), 280.0)
FRAME = HeadFrame.of(FACE)
E = FRAME.height_px


def photo(above, below, beside=3.0):
    """A photo that ends so far above the eyes, below the chin and beside the axis, in E."""
    x, y = FRAME.eyes_px
    ends = x - beside * E, y - above * E, x + beside * E, y + (1.0 + below) * E
    return Box(*(round(end) for end in ends))


def pivot(above, below, percent=6.0, **more):
    """How far the pivot lies above the eyes, in E, and the Amount that is left, %."""
    at, share = pivot_and_share(FACE, percent, photo(above, below, **more))
    return float((FRAME.eyes_px - at) @ FRAME.down) / E, 100.0 * share


def test_with_space_above_the_eyes_stay_and_without_space_the_crown_does():
    assert abs(pivot(4.0, 2.0)[0]) < 0.15
    assert pivot(1.05, 2.0)[0] == pytest.approx(1.05, abs=0.02)
    heights = [pivot(above, 2.0)[0] for above in (1.05, 1.2, 1.5, 2.0, 4.0)]
    assert (np.diff(heights) < 0.0).all()


def test_the_amount_is_lowered_only_where_hair_and_chin_both_lack_space():
    for above, below in ((4.0, 2.0), (1.05, 2.0), (4.0, 0.05)):
        assert pivot(above, below)[1] == pytest.approx(6.0, abs=0.1)
    assert 1.5 < pivot(1.05, 0.05)[1] < 5.5
    assert pivot(1.05, 0.05, percent=-6.0)[1] == pytest.approx(-pivot(1.05, 0.05)[1])
    doses = [pivot(1.05, below)[1] for below in (0.05, 0.15, 0.25, 0.4, 0.8)]
    assert (np.diff(doses) >= 0.0).all()


def test_a_rendering_says_that_it_lowered_the_amount():
    tight = photo(1.1, 0.1, beside=1.5)
    there = Affine(np.eye(2), -np.array([tight.left, tight.top], np.float64))
    made = render(
        textured_photo(tight.width, tight.height), [FACE.mapped(there)], Recipe(percent=9)
    )
    assert made.note.startswith("1 head fills the photo: Amount lowered to ")
    assert f"{made.achieved[0]:.1f} %" in made.note
    assert not made.one_to_one.folds


@pytest.mark.parametrize("above", [1.0, 1.05, 1.2, 1.6, 2.5])
@pytest.mark.parametrize("percent", [4.0, 8.0])
def test_a_pixel_more_at_the_photos_edge_is_a_small_step_of_the_head(above, percent):
    points = FRAME.eyes_px + E * np.array([(0.0, -1.05), (0.0, 0.0), (0.0, 1.0), (0.6, 0.0)])

    def moved(above, below):
        at, share = pivot_and_share(FACE, percent, photo(above, below))
        return share / (1.0 - share) * (points - at)

    step = 8.0 / E
    for below in np.arange(0.02, 1.5, 0.05):
        now = moved(above, below)
        for other in (moved(above + step, below), moved(above, below + step)):
            assert np.abs(other - now).max() < 8.0 * 0.1 * percent


def test_a_dragged_landmark_leaves_the_pivot_where_it_is():
    dragged = FACE.with_outline_point(5, FACE.outline[5] + (9.0, 4.0))
    both = (aim(face, Recipe(), photo=photo(1.3, 1.0)) for face in (FACE, dragged))
    assert len({tuple(pairs.center_px) for pairs in both}) == 1


def test_a_limited_move_is_whole_far_below_the_limit_and_never_beyond_it():
    most = np.array([0.0, 1.0, 10.0, 1e3])
    assert (np.abs(limited(np.full(4, -5.0), most)) <= most).all()
    assert float(limited(5.0, 1e3)) == pytest.approx(5.0)
    assert float(limited(0.0, 0.0)) == 0.0
