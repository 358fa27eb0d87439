"""The composed field: derivatives, fade and the one-to-one report."""

import numpy as np
import pytest
from scenes import field_of, oval_face

from kogao_core.additions.guard import limited
from kogao_core.field.field import fade, shown_at
from kogao_core.recipe.recipe import Recipe


def test_displacements_of_several_faces_add_up():
    faces = [oval_face(center=(170.0, 170.0)), oval_face(center=(330.0, 150.0), size=0.2)]
    both = field_of(Recipe(), *faces)
    points = np.random.default_rng(0).uniform((50, 50), (430, 300), (100, 2))
    expected = both.lattices[0].at(points) + both.lattices[1].at(points)
    np.testing.assert_allclose(both.at(points), expected, atol=1e-12)
    xs, ys = np.sort(points, axis=0).T
    expected = both.lattices[0].on_grid(xs, ys) + both.lattices[1].on_grid(xs, ys)
    np.testing.assert_allclose(both.on_grid(xs, ys), expected, atol=1e-12)


@pytest.mark.parametrize("fade_px", [0.0, 1.5])
def test_det_jacobian_is_that_of_the_displacement_with_its_fade(fade_px):
    field = field_of(Recipe(percent=8), fade_px=fade_px)
    xs, ys = np.linspace(130, 350, 41), np.linspace(80, 290, 37)
    step = 1e-5
    along_x = (field.on_grid(xs + step, ys) - field.on_grid(xs - step, ys)) / (2 * step)
    along_y = (field.on_grid(xs, ys + step) - field.on_grid(xs, ys - step)) / (2 * step)
    numeric = (1 + along_x[0]) * (1 + along_y[1]) - along_x[1] * along_y[0]
    np.testing.assert_allclose(field.det_jacobian(xs, ys), numeric, atol=1e-6)


def test_fade_is_zero_below_t_whole_above_2t_and_smooth_between():
    length = np.linspace(0, 3, 3001)
    factor = fade(length, 1.0)
    assert not factor[length <= 1.0].any()
    assert (factor[length >= 2.0] == 1.0).all()
    assert np.abs(np.diff(factor)).max() < 2e-3
    assert (fade(length, 0.0) == 1.0).all()


def test_points_and_grid_agree():
    field = field_of(Recipe(percent=8), fade_px=1.0)
    xs, ys = np.linspace(130, 350, 21), np.linspace(80, 290, 17)
    points = np.stack(np.meshgrid(xs, ys), -1).reshape(-1, 2)
    np.testing.assert_allclose(field.on_grid(xs, ys).reshape(2, -1).T, field.at(points), atol=1e-12)


def test_a_grid_that_does_not_ascend_is_refused():
    field, ascending = field_of(Recipe()), np.arange(0.0, 480.0, 7.0)
    mixed = np.random.default_rng(0).permutation(ascending)
    for ask in (field.on_grid, field.det_jacobian):
        for places in ((mixed, ascending), (ascending, mixed), (ascending[::-1], ascending)):
            with pytest.raises(ValueError, match="must ascend"):
                ask(*places)


@pytest.mark.parametrize("seed", [7, 22, 30])
def test_every_point_is_found_however_near_the_warp_comes_to_a_fold(seed):
    rng, face = np.random.default_rng(seed), oval_face()
    for index in rng.integers(0, 21, 3):
        face = face.with_target(int(index), face.outline[index] + rng.normal(0, 25, 2))
    field, (limit,) = limited(field_of(Recipe(percent=12, lattice=0.25), face))
    assert limit.share < 1.0
    left, top, right, bottom = field.lattices[0].reach_px
    points = rng.uniform((left, top), (right, bottom), (800, 2))
    shown = shown_at(field, points)
    np.testing.assert_allclose(shown + field.at(shown), points, rtol=0.0, atol=1e-3)
