"""No fold is rendered unless asked for, and then it is reported."""

from dataclasses import replace

import numpy as np
import pytest
from few_cases import few_of
from scenes import ALONE, field_of, oval_face, textured_photo

from kogao_core.additions.guard import LEAST_DET, Limit, limited
from kogao_core.paper.lattice import groups
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import LOSSLESS_PX, SETTINGS, Recipe

# The field of a face that moves alone is the steepest.
FOLDING = replace(ALONE, percent=12, lattice=0.25)


def densest_det(field):
    """Smallest det J on a grid twice as fine as the guard's."""
    lowest = 1.0
    for lattice in field.lattices:
        left, top, right, bottom = lattice.reach_px
        step = lattice.grid.spacing_px / 16
        xs, ys = np.arange(left, right, step), np.arange(top, bottom, step)
        lowest = min(lowest, float(field.det_jacobian(xs, ys).min()))
    return lowest


def test_a_fold_is_held_back_and_said_and_shown_without_the_guard():
    photo, face = textured_photo(), oval_face()
    bare = render(photo, [face], replace(FOLDING, guard=False))
    assert bare.one_to_one.folds
    assert bare.shares == (1.0,)
    guarded = render(photo, [face], FOLDING)
    assert 0.1 < guarded.shares[0] < 1.0
    assert not guarded.one_to_one.folds
    assert densest_det(guarded.field) > LEAST_DET - 0.05


def test_a_limit_acts_only_near_the_cells_that_need_it():
    face = oval_face(960, 720, size=0.5)
    away = face.outline[5] + (face.outline[5] - face.outline[10]) * 0.3
    field = field_of(Recipe(percent=4), face.with_target(4, away))
    held, (limit,) = limited(field)
    assert limit.share < 0.9
    assert densest_det(field) < 0.2 < LEAST_DET - 0.05 < densest_det(held)
    apart = np.hypot(*(face.outline - face.outline[4]).T) / face.anchor.spacing_px
    assert np.hypot(*np.subtract(limit.place_px, away)) < 3.0 * face.anchor.spacing_px
    near = apart < 7.0
    assert near.sum() < 15
    before, after = (one.at(face.outline) for one in (field, held))
    np.testing.assert_allclose(after[~near], before[~near], atol=1e-9)
    assert np.abs(after[near] - before[near]).max() > 1.0


@pytest.mark.parametrize(
    ("recipe", "fade_px"), [(Recipe(percent=10), 0.0), (Recipe(percent=4, lattice=2), 0.5)]
)
def test_a_warp_without_folds_and_a_harmless_fade_are_left_alone_to_the_bit(recipe, fade_px):
    field = field_of(recipe, oval_face(), fade_px=fade_px)
    guarded, limits = limited(field)
    assert guarded is field
    assert limits == (Limit(),)


def test_a_face_that_reaches_no_fold_keeps_its_move_beside_some_that_do():
    row = [oval_face(center=(x, 170.0)) for x in (170.0, 370.0, 540.0)]
    crossed = row[0].with_target(3, row[0].outline[5]).with_target(5, row[0].outline[3])
    field = field_of(Recipe(percent=6), crossed, *row[1:])
    assert groups(field.lattices) == [[0, 1, 2]]
    held, limits = limited(field)
    assert limits[0].share < 1.0
    free, _ = limited(field_of(Recipe(percent=6), *row))
    last = row[2].outline
    assert np.abs(held.at(last) - free.at(last)).max() < 0.1 * np.abs(free.at(last)).max()
    assert densest_det(held) > LEAST_DET - 0.05


def test_those_who_fold_each_other_in_turn_are_all_held_back():
    row = [oval_face(center=(x, 170.0)) for x in (170.0, 330.0, 490.0)]
    held, limits = limited(field_of(FOLDING, *row))
    assert max(limit.share for limit in limits) < 1.0
    assert densest_det(held) > LEAST_DET - 0.05


def test_a_fade_that_would_fold_is_refused_and_the_move_kept():
    face = oval_face()
    field = field_of(Recipe(percent=8, lattice=0.5), face, fade_px=2.0)
    assert densest_det(field) <= 0.0
    guarded, limits = limited(field)
    assert limits[0].share > 0.8
    assert guarded.fade_px == 0.0
    assert densest_det(guarded) > 0.0


def test_where_a_fade_is_refused_the_domain_is_the_lossless_one():
    photo, face = textured_photo(), oval_face()
    refused = replace(ALONE, percent=8, lattice=0.5, threshold_px=2.0)
    lossless = replace(refused, threshold_px=LOSSLESS_PX)
    done, plain = (render(photo, [face], recipe) for recipe in (refused, lossless))
    np.testing.assert_array_equal(done.pixels, plain.pixels)
    assert done.threshold_px == LOSSLESS_PX
    assert done.pixel_counts == plain.pixel_counts


@pytest.mark.parametrize("seed", few_of(range(30), 3))
def test_no_random_drag_renders_a_fold(seed):
    """Landmarks and targets thrown about, over the range of the sliders."""
    rng = np.random.default_rng(seed)
    face = oval_face()
    for _ in range(rng.integers(1, 6)):
        index = int(rng.integers(21))
        spot = face.outline[index] + rng.normal(0, rng.uniform(2, 60), 2)
        face = (
            face.with_target(index, spot)
            if rng.random() < 0.5
            else face.with_outline_point(index, spot)
        )
    fits = SETTINGS["fit"].choices
    recipe = Recipe(
        percent=rng.uniform(0, 15),
        center=int(rng.integers(1, 5)),
        lattice=float(np.exp(rng.uniform(np.log(0.25), np.log(4)))),
        fit=fits[seed % 3],
    )
    fade_px = rng.uniform(0.02, 2.0) if rng.random() < 0.5 else 0.0
    field, limits = limited(field_of(recipe, face, fade_px=fade_px))
    assert 0.0 < limits[0].share <= 1.0
    assert densest_det(field) > 0.0
