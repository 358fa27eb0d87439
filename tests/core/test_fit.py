"""Sections 2.1, 2.2 and 3.3: the three fits."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import ALONE, oval_face

from kogao_core.additions.fit import fit, spacing_px
from kogao_core.faces.targets import aim
from kogao_core.field.field import Field, residual
from kogao_core.field.one_to_one import check_one_to_one
from kogao_core.paper.basis import basis
from kogao_core.paper.fit import Problem, approximate
from kogao_core.paper.lattice import Grid, Lattice
from kogao_core.recipe.recipe import Recipe


def solve(face, recipe):
    pairs = aim(face, recipe)
    return Field(fit([pairs], [face.anchor], [recipe])), pairs


def test_approximation_of_one_landmark_is_the_equation_and_hits_it():
    problem = Problem(Grid((0.0, 0.0), 10.0), np.array([[23.0, 37.0]]), np.array([[3.0, -2.0]]))
    lattice = approximate(problem)
    np.testing.assert_allclose(lattice.at([[23.0, 37.0]]), [[3.0, -2.0]], atol=1e-12)
    w = basis(0.7)[:, None] * basis(0.3)[None, :]
    np.testing.assert_allclose(lattice.phi[..., 0], 3.0 * w / (w**2).sum(), atol=1e-12)
    assert lattice.first == (1, 2)


def test_shared_control_points_minimise_equation_4():
    """No change of any one control point makes the sum of squares of eq. (4) smaller."""
    rng = np.random.default_rng(5)
    target, displacement = rng.uniform(20, 60, (6, 2)), rng.normal(0, 3, (6, 2))
    grid = Grid((0.0, 0.0), 12.0)
    lattice = approximate(Problem(grid, target, displacement))

    def error(phi, row, column):
        total = 0.0
        for c in range(len(target)):
            one = approximate(Problem(grid, target[c : c + 1], displacement[c : c + 1]))
            j, i = row + lattice.first[1] - one.first[1], column + lattice.first[0] - one.first[0]
            if 0 <= j < 4 and 0 <= i < 4:
                u, v = target[c] / 12.0
                w = basis(v - np.floor(v))[j] * basis(u - np.floor(u))[i]
                total += (w * (phi - one.phi[j, i, 0])) ** 2
        return total

    for row in range(lattice.shape[0]):
        for column in range(lattice.shape[1]):
            phi = lattice.phi[row, column, 0]
            best = error(phi, row, column)
            assert best <= error(phi + 1e-3, row, column) + 1e-12
            assert best <= error(phi - 1e-3, row, column) + 1e-12


@pytest.mark.parametrize("ratio", [0.25, 0.5, 1.0, 2.0, 4.0])
@pytest.mark.parametrize("percent", [4.0, 10.0])
def test_exact_fit_hits_every_landmark(ratio, percent):
    field, pairs = solve(oval_face(), Recipe(percent=percent, lattice=ratio, fit="exact"))
    assert residual(field, [pairs]).max_px < 0.05


def test_multilevel_hits_nearly_and_approximation_leaves_a_tenth():
    face = oval_face(1920, 1440)
    move = aim(face, Recipe()).warp_distance_px

    def missed_px(name):
        field, pairs = solve(face, Recipe(fit=name))
        return residual(field, [pairs]).mean_px

    missed = {name: missed_px(name) for name in ("approximation", "multilevel", "exact")}
    assert 0.05 * move < missed["approximation"] < 0.25 * move
    assert missed["multilevel"] < 0.05
    assert missed["exact"] < 1e-3


def test_landmarks_on_top_of_each_other_give_a_finite_compromise():
    face = oval_face()
    face = face.with_outline_point(4, face.outline[5]).with_target(4, face.outline[5] + 6.0)
    field, pairs = solve(face, Recipe())
    assert np.isfinite(field.lattices[0].phi).all()
    assert field.lattices[0].magnitude_px.max() < 100.0
    assert residual(field, [pairs]).max_px < 10.0


def test_overlapping_faces_are_solved_together():
    left, right = oval_face(center=(170.0, 170.0)), oval_face(center=(345.0, 170.0))
    recipe = Recipe(percent=6)
    pairs = [aim(face, recipe) for face in (left, right)]
    field = Field(fit(pairs, [left.anchor, right.anchor], [recipe] * 2))
    assert residual(field, pairs).max_px < 0.05
    alone = Field(fit(pairs[:1], [left.anchor], [recipe])).at(pairs[1].target_px)
    assert np.abs(alone).max() > 0.5, "the fields don't overlap: this test shows nothing"


def test_cheek_to_cheek_both_give_way_instead_of_folding():
    left, right = oval_face(center=(170.0, 170.0)), oval_face(center=(325.0, 170.0))
    recipe = replace(ALONE, percent=4.0)
    pairs = [aim(face, recipe) for face in (left, right)]
    field = Field(fit(pairs, [left.anchor, right.anchor], [recipe] * 2))
    report = check_one_to_one(field)
    assert report.min_det > 0.0
    assert 0.05 < residual(field, pairs).mean_px < 0.25 * pairs[0].warp_distance_px


def test_spacing_is_measured_in_landmark_steps_or_warp_distances():
    face = oval_face()
    step = np.linalg.norm(np.diff(face.outline, axis=0), axis=1).mean()
    pairs = aim(face, Recipe(percent=4))
    assert spacing_px(pairs, face.anchor, Recipe(lattice=2)) == pytest.approx(2 * step)
    by_warp = Recipe(lattice=1.5, lattice_unit="warp")
    moved = np.linalg.norm(pairs.displacement_px, axis=1).mean()
    assert spacing_px(pairs, face.anchor, by_warp) == pytest.approx(1.5 * moved)
    tiny = oval_face(size=0.02)
    assert spacing_px(aim(tiny, Recipe()), tiny.anchor, Recipe(lattice=0.5)) == 1.0


def test_a_lattice_of_one_warp_distance_scallops_and_of_one_spacing_does_not():
    """Figure 8c."""
    face, found = oval_face(1920, 1440), []
    for unit in ("warp", "spacing"):
        field, pairs = solve(face, Recipe(lattice_unit=unit))
        contour = residual(field, [pairs]).contour_max_px / pairs.warp_distance_px
        found.append((contour, check_one_to_one(field).min_det))
    (scalloped, low), (smooth, high) = found
    assert scalloped > 0.7
    assert low < 0.3
    assert smooth < 0.15
    assert high > 0.75


def test_dragging_one_landmark_leaves_far_control_points_exactly_alone():
    face = oval_face(4800, 3600)
    recipe = replace(ALONE, percent=4.0)
    before, _ = solve(face, recipe)
    after, _ = solve(face.with_outline_point(0, face.outline[0] + (3.0, 2.0)), recipe)
    a, b = before.lattices[0], after.lattices[0]
    assert a.grid == b.grid
    far = b.window(a.first, a.shape)
    same = (far == a.phi).all(axis=-1)
    assert same[:, a.shape[1] // 2 :].mean() > 0.9
    assert not same.all()
    assert [bool((a.phi * 2.0**bits % 1.0).any()) for bits in (11, 12)] == [True, False]


def test_fields_add_up_whatever_the_spacing_of_their_grids():
    one = Lattice(Grid((0.0, 0.0), 20.0), (0, 0), np.ones((4, 4, 2)))
    both = one.refined().plus(one)
    assert both.grid.spacing_px == 10.0
    np.testing.assert_allclose(both.at([[30.0, 30.0]]), 2.0 * one.at([[30.0, 30.0]]))
