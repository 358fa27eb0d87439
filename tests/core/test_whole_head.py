"""Whole head: forehead and hair follow, the landmarks stay what they are, and nothing folds."""

import dataclasses

import numpy as np
import pytest
from kogao_core.warp.whole_head import forehead_pairs, heads_of, unfollowed
from scenes import mirrored, oval_face, textured_photo

from kogao_core.background.holding import Held
from kogao_core.background.lines import bends
from kogao_core.base.geometry import Affine, Box
from kogao_core.base.strict import Node
from kogao_core.faces.targets import aim
from kogao_core.pipeline import render
from kogao_core.projects.project import Original, Project, Sheet, from_node, to_dict
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import SETTINGS
from kogao_core.warp.fit import problems_of
from kogao_core.warp.protection import Protection

ON = Recipe(percent=8.0, whole_head=True)
OFF = dataclasses.replace(ON, whole_head=False)
FITS = SETTINGS["fit"].choices


def face_at(x=239.5, y=220.0, size=0.45, **more):
    return oval_face(center=(x, y), size=size, forehead=True, **more)


def rendered(recipe, *faces, photo=None, **more):
    photo = textured_photo() if photo is None else photo
    return render(photo, faces or [face_at()], recipe, **more)


def inward(rendering, points):
    """How far places come towards the first face's centre, % of their distance."""
    center = rendering.pairs[0].center_px
    away = points - center
    moved = rendering.field.at(points)
    return 100.0 * (moved * away).sum(axis=1) / (away**2).sum(axis=1)


# -- off is what it was ----------------------------------------------------------------------------


@pytest.mark.parametrize("fit", FITS)
def test_off_every_byte_is_that_of_a_face_without_a_forehead(fit):
    face = face_at()
    recipe = dataclasses.replace(OFF, fit=fit)
    without = rendered(recipe, dataclasses.replace(face, forehead=None))
    assert rendered(recipe, face).pixels.tobytes() == without.pixels.tobytes()
    # Nor does it do anything where nobody knows the forehead.
    unknown = rendered(
        dataclasses.replace(recipe, whole_head=True), dataclasses.replace(face, forehead=None)
    )
    assert unknown.pixels.tobytes() == without.pixels.tobytes()


def test_at_0_percent_nothing_moves():
    photo = textured_photo()
    still = rendered(dataclasses.replace(ON, percent=0.0), photo=photo)
    assert still.pixels.tobytes() == photo.tobytes()


# -- what follows ----------------------------------------------------------------------------------


@pytest.mark.parametrize("fit", FITS)
def test_the_forehead_comes_as_far_as_the_face_and_the_landmarks_as_before(fit):
    face = face_at()
    on, off = (rendered(dataclasses.replace(r, fit=fit), face) for r in (ON, OFF))
    assert on.achieved[0] == pytest.approx(off.achieved[0], abs=0.5)
    assert abs(on.achieved[0] - 8.0) < abs(off.achieved[0] - 8.0) + 0.01
    assert (inward(on, face.forehead) > 7.0).all()
    assert inward(on, face.forehead).max() < 10.0
    top = face.forehead[[6]]
    assert abs(inward(off, top)[0]) < 0.01


def test_an_exact_fit_still_meets_every_landmark():
    assert rendered(ON).residual.max_px < 2e-3


def test_it_fades_out_above_and_stays_below():
    face = face_at()
    on, off = rendered(ON, face), rendered(OFF, face)
    center = on.pairs[0].center_px
    top = face.forehead[6] - center
    shares = inward(on, center + np.outer(np.linspace(1.0, 2.4, 15), top))
    assert (np.diff(shares[2:]) <= 1e-6).all()
    assert abs(shares[-1]) < 0.05
    jaw = face.outline[7:14] - center
    lower = np.vstack([face.mouth, *(center + far * jaw for far in (0.8, 1.0, 1.1))])
    np.testing.assert_allclose(on.field.at(lower), off.field.at(lower), atol=0.05)


def test_zones_of_the_cheeks_and_sides_go_on_round_the_forehead():
    face = face_at()
    _, targets = forehead_pairs(face, dataclasses.replace(ON, left=50.0), aim(face, ON).center_px)
    way = np.linalg.norm(targets - face.forehead, axis=1)
    share = 100.0 * way / np.linalg.norm(face.forehead - aim(face, ON).center_px, axis=1)
    assert (np.diff(share) > 0.0).all()
    assert share[0] == pytest.approx(4.0, abs=0.2)
    assert share[-1] == pytest.approx(8.0, abs=0.2)
    still = rendered(dataclasses.replace(ON, cheeks=0.0), face)
    assert np.abs(still.field.at(face.forehead)).max() < 0.2


# -- what must not happen --------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_it_never_folds(seed):
    rng = np.random.default_rng(seed)
    for _ in range(4):
        recipe = dataclasses.replace(
            ON,
            percent=float(rng.uniform(1, 15)),
            center=int(rng.integers(1, 5)),
            lattice=float(rng.uniform(0.3, 3.0)),
            fit=str(rng.choice(FITS)),
            cheeks=float(rng.uniform(0, 200)),
            left=float(rng.uniform(0, 200)),
        )
        face = face_at(rng.uniform(150, 330), rng.uniform(120, 240), rng.uniform(0.3, 0.6))
        turn = Affine.similarity(1.0, float(rng.uniform(-40, 40)), (0.0, 0.0))
        middle = face.eye_center
        face = face.mapped(Affine(turn.matrix, middle - turn(middle)))
        sound = rendered(recipe, face).one_to_one
        assert not sound.folds
        assert sound.settled


def test_at_usual_settings_the_guard_has_no_more_to_do_than_before():
    on, off = rendered(ON), rendered(OFF)
    assert on.shares == off.shares == (1.0,)
    assert on.one_to_one.min_det > off.one_to_one.min_det - 0.05


@pytest.mark.parametrize("fit", FITS)
def test_a_mirrored_photo_gives_the_mirrored_result(fit):
    photo, face = textured_photo(), face_at(210.0)
    recipe = dataclasses.replace(ON, fit=fit)
    expected = rendered(recipe, face, photo=photo).pixels[:, ::-1].astype(int)
    there, reflected = mirrored(photo, face)
    difference = np.abs(rendered(recipe, reflected, photo=there).pixels - expected)
    assert difference.mean() < 0.05
    assert (difference > 3).mean() < 1e-3


@pytest.mark.parametrize("y", [70.0, 110.0, 150.0])
def test_nothing_is_drawn_in_across_the_edge_of_the_photo(y):
    face = face_at(y=y)
    on = rendered(ON, face)
    edge = np.column_stack([np.arange(480.0), np.zeros(480)])
    most = np.abs(on.pairs[0].displacement_px).max()
    assert -on.field.at(edge)[:, 1].min() < 0.1 * most


def test_a_part_of_a_photo_moves_as_it_does_in_the_whole():
    photo, face = textured_photo(), face_at(y=150.0)
    part = Box(60, 70, 420, 330)
    there = Affine(np.eye(2), np.array([-part.left, -part.top], np.float64))
    whole = Box(-part.left, -part.top, 480 - part.left, 360 - part.top)
    alone = render(photo[part.slices], [face.mapped(there)], ON, whole=whole)
    points = np.random.default_rng(3).uniform((100, 90), (380, 300), (200, 2))
    np.testing.assert_allclose(
        alone.field.at(there(points)), rendered(ON, face).field.at(points), atol=1e-3
    )


def test_protected_places_above_the_face_stay():
    face = face_at()
    brim = face.forehead[6] + [(-60.0, -25.0), (60.0, -25.0)]
    free, held = rendered(ON, face), rendered(ON, face, protection=Protection().with_stroke(brim))
    along = brim[0] + np.linspace(0.0, 1.0, 30)[:, None] * (brim[1] - brim[0])
    assert np.abs(free.field.at(along)).max() > 3.0
    assert np.abs(held.field.at(along)).max() < 0.1
    assert held.residual.max_px < 0.05


def test_a_line_above_the_face_is_held():
    face = face_at()
    y = face.forehead[6, 1] - 60.0
    frame = np.array([[(150.0, y), (330.0, y - 6.0)]])
    free, held = rendered(ON, face), rendered(ON, face, held=Held(frame))
    (loose,), (kept,) = bends(free.field, frame), bends(held.field, frame)
    assert loose.bend_px > 0.5
    assert kept.bend_px < 0.3 * loose.bend_px
    assert held.residual.max_px < 2e-3


@pytest.mark.parametrize(("lattice", "takes_part"), [(1.0, True), (0.5, True), (0.2, False)])
def test_of_very_many_control_points_those_above_the_face_take_no_part_in_holding(
    lattice, takes_part
):
    face, recipe = face_at(), dataclasses.replace(ON, lattice=lattice)
    pairs = aim(face, recipe)
    heads = heads_of([face], [pairs.center_px], [recipe], Box(0, 0, 480, 360), Protection())
    (problem,) = problems_of([pairs], [face.anchor], [recipe], heads=heads)
    assert (len(problem.moving_nodes) > len(problem.own_nodes)) == takes_part
    assert len(problem.moving_nodes) <= 2000


@pytest.mark.parametrize("fit", FITS)
def test_a_neighbour_goes_where_it_went(fit):
    faces = [face_at(190.0, 240.0, 0.35), face_at(290.0, 130.0, 0.35)]
    recipe = dataclasses.replace(ON, fit=fit)
    on, off = rendered(recipe, *faces), rendered(dataclasses.replace(OFF, fit=fit), *faces)
    np.testing.assert_allclose(on.achieved, off.achieved, atol=0.5)
    if fit == "exact":
        assert on.residual.max_px < 0.01


# -- files and words -------------------------------------------------------------------------------


def test_projects_carry_the_forehead_and_older_ones_have_none():
    face = face_at()
    sheet = Sheet((face,), recipe=ON)
    written = to_dict(Project(Original("me.jpg", "0" * 64, 480, 360), "automatic", sheet))
    again = from_node(Node(written)).automatic
    assert again.recipe.whole_head
    assert again.faces[0].forehead.tobytes() == face.forehead.tobytes()
    del written["automatic"]["faces"][0]["forehead"]
    del written["automatic"]["recipe"]["whole_head"]
    older = from_node(Node(written)).automatic
    assert older.faces[0].forehead is None
    assert not older.recipe.whole_head


def test_it_is_said_where_it_does_nothing():
    known, unknown = face_at(), oval_face()
    assert not unfollowed([known, unknown], OFF)
    assert not unfollowed([known], ON)
    assert unfollowed([known, unknown], ON).startswith("whole head does nothing for 1 face,")
    assert unfollowed([unknown] * 2, ON).startswith("whole head does nothing for 2 faces,")
    own = dataclasses.replace(unknown, recipe=OFF)
    assert not unfollowed([known, own], ON)
    assert "whole head" in ON.amount
    assert "whole head" not in OFF.amount
