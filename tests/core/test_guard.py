"""No fold is rendered unless asked for, and then it is reported."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from few_cases import few_of
from scenes import ALONE, field_of, oval_face, textured_photo

from kogao_core.pipeline import render
from kogao_core.recipe.recipe import LOSSLESS_PX, SETTINGS, Recipe
from kogao_core.warp.field import Field
from kogao_core.warp.guard import hold_back
from kogao_core.warp.lattice import groups
from kogao_core.warp.one_to_one import Shrinking, least_dets
from kogao_core.warp.protection import Falloff, Stroke

# The field of a face that moves alone is the steepest.
FOLDING = replace(ALONE, percent=12, lattice=0.25)


def densest_det(field):
    """Smallest det J on a grid three times finer than the guard looks at."""
    lowest = 1.0
    for lattice in field.lattices:
        left, top, right, bottom = lattice.reach_px
        step = lattice.grid.spacing_px / 24
        xs, ys = np.arange(left, right, step), np.arange(top, bottom, step)
        lowest = min(lowest, float(field.det_jacobian(xs, ys).min()))
    return lowest


def test_a_fold_is_held_back_and_said_and_shown_without_the_guard():
    photo, face = textured_photo(), oval_face()
    bare = render(photo, [face], replace(FOLDING, guard=False))
    assert bare.one_to_one.folds
    assert bare.shares == (1.0,)
    guarded = render(photo, [face], FOLDING)
    assert 0.2 < guarded.shares[0] < 1.0
    assert not guarded.one_to_one.folds
    assert densest_det(guarded.field) > 0.0


def test_the_share_is_nearly_the_largest():
    field = field_of(FOLDING, oval_face())
    _, (share,) = hold_back(field)
    more = Field((field.lattices[0].scaled(share + 0.08),))
    assert densest_det(more) < 0.02


def test_a_warp_without_folds_is_left_alone_to_the_bit():
    field = field_of(Recipe(percent=10), oval_face())
    guarded, shares = hold_back(field)
    assert guarded is field
    assert shares == (1.0,)


def test_a_face_that_reaches_no_fold_keeps_its_move_beside_some_that_do():
    row = [oval_face(center=(x, 170.0)) for x in (170.0, 370.0, 540.0)]
    crossed = row[0].with_target(3, row[0].outline[5]).with_target(5, row[0].outline[3])
    field = field_of(Recipe(percent=6), crossed, *row[1:])
    assert groups(field.lattices) == [[0, 1, 2]]
    held, shares = hold_back(field)
    assert shares[0] < 1.0
    assert shares[1:] == (1.0, 1.0)
    assert densest_det(held) > 0.0


def test_those_who_fold_each_other_in_turn_are_all_held_back():
    row = [oval_face(center=(x, 170.0)) for x in (170.0, 330.0, 490.0, 650.0)]
    held, shares = hold_back(field_of(FOLDING, *row))
    assert max(shares) < 1.0
    assert densest_det(held) > 0.0


@pytest.mark.parametrize("strokes", [(), (Stroke([[170.0, 250.0]], 6.0, 40.0),)])
def test_shares_of_some_displacements_are_measured_as_those_fields_are(strokes):
    row = [oval_face(center=(x, 170.0)) for x in (170.0, 330.0, 490.0)]
    field = dataclasses.replace(field_of(Recipe(percent=9), *row), falloff=Falloff(strokes))
    for k, lattice in enumerate(field.lattices):
        samples, lowest = Shrinking(field, lattice, {0, 1}, below=0.5), []
        for share in (0.0, 0.4, 1.0):
            shrunk = [one.scaled(share) for one in field.lattices[:2]]
            parts = dataclasses.replace(field, lattices=(*shrunk, field.lattices[2]))
            lowest.append(min(0.5, least_dets(parts, parts.lattices[k]).min()))
            found = samples.dets(share).min(initial=0.5)
            assert found == pytest.approx(lowest[-1], abs=1e-9)
        assert lowest[-1] < lowest[0]


def test_a_fade_that_would_fold_is_refused_and_the_move_kept():
    face = oval_face()
    field = field_of(Recipe(percent=8, lattice=0.5), face, fade_px=2.0)
    assert densest_det(field) <= 0.0
    guarded, (share,) = hold_back(field)
    assert share == 1.0
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


def test_a_harmless_fade_is_kept():
    face = oval_face()
    field = field_of(Recipe(percent=4, lattice=2), face, fade_px=0.5)
    guarded, shares = hold_back(field)
    assert guarded is field
    assert shares == (1.0,)


@pytest.mark.parametrize("seed", few_of(range(30), 6))
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
    field, shares = hold_back(field_of(recipe, face, fade_px=fade_px))
    assert 0.0 < shares[0] <= 1.0
    assert densest_det(field) > 0.0
