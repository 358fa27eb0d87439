"""Table 1 as printed, straight between its columns, and what it says about real pairs."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.faces.naturalness import judge, percent_of, worst
from kogao_core.faces.targets import aim
from kogao_core.paper.table1 import DISTANCES, STUDENTS, SUBJECTS, UNNATURAL
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER, Recipe


@pytest.mark.parametrize("center", [1, 2, 3, 4])
def test_published_distances_give_the_published_figures(center):
    for column, percent in enumerate(DISTANCES):
        found = judge(percent, center)
        assert found.unnatural == UNNATURAL[center - 1][column]
        assert found.published


def test_between_columns_it_lies_between_them():
    assert judge(7.0, 2).unnatural == pytest.approx((5.0 + 29.375) / 2)
    assert judge(5.0, 4).unnatural == pytest.approx((4.375 + 6.825) / 2)


def test_beyond_the_table_the_nearest_figure_holds_and_says_so():
    for percent, column in ((0.0, 0), (1.9, 0), (15.0, -1)):
        found = judge(percent, 3)
        assert found.unnatural == UNNATURAL[2][column]
        assert not found.published


def test_a_centre_that_nobody_was_asked_about_is_judged_by_the_worst():
    found = judge(4.0, len(UNNATURAL) + 1)
    assert found.unnatural == 4.375
    assert not found.published


def test_the_papers_choice_is_the_most_natural():
    table = np.array(UNNATURAL)
    assert (SUBJECTS, STUDENTS) == (25, 32)
    assert np.unravel_index(table.argmin(), table.shape) == (1, 1)
    assert not judge(6.0, 2).warns
    assert judge(6.1, 2).warns


def test_the_distance_is_read_off_the_pairs():
    face = oval_face()
    assert percent_of(aim(face, replace(PAPER, percent=5.5, center=3))) == pytest.approx(5.5)
    half = face.with_target(10, face.outline[10])
    assert percent_of(aim(half, Recipe(percent=4))) == pytest.approx(4 * 20 / 21)


def test_the_farthest_moved_face_counts():
    face = oval_face()
    recipes = [replace(PAPER, percent=p, center=c) for p, c in ((3, 2), (8, 4))]
    found = worst([(aim(face, recipe), recipe) for recipe in recipes])
    assert found.unnatural == pytest.approx(UNNATURAL[3][3])
    assert found.warns
    assert worst([]) is None


@pytest.mark.parametrize("more", [{"jaw_width": -12.0}, {"width": -9.0}, {"chin_length": 5.0}])
def test_it_never_speaks_for_parts_of_a_face(more):
    face, recipe = oval_face(), replace(PAPER, percent=8.0)
    assert worst([(aim(face, recipe), recipe)]).warns
    for parts in (replace(recipe, **more), replace(recipe, percent=0.0, **more)):
        found = worst([(aim(face, parts), parts)])
        assert not found.whole_face
        assert not found.warns


def test_it_speaks_for_faces_that_move_alone_and_says_so_of_others():
    face, recipe = oval_face(), replace(PAPER, percent=8.0)
    assert worst([(aim(face, recipe), recipe)]).face_alone
    other = replace(recipe, scope="head")
    found = worst([(aim(face, other), other)])
    assert not found.face_alone
    assert found.beyond_limit
    assert not found.warns, "nobody was asked"


def test_it_is_silent_where_the_outline_bends_between_landmarks():
    photo, face = textured_photo(500, 600), oval_face(500, 600)
    for lattice, follows in ((0.25, False), (0.35, False), (1.0, True), (2.0, True)):
        recipe = replace(PAPER, lattice=lattice)
        rendering = render(photo, [face], recipe)
        missed_px = rendering.residual.contour_max_px
        found = worst([(rendering.pairs[0], recipe)], missed_px)
        assert found.contour_follows == follows, lattice
