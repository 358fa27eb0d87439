"""Section 2.1: eq. (1) and (2) against other people's B-splines."""

import numpy as np
import pytest
import SimpleITK

from kogao_core.field.field import Field
from kogao_core.paper.basis import basis
from kogao_core.paper.lattice import Grid, Lattice

GRID = Grid((13.3, -4.7), 9.25)


@pytest.fixture
def lattice():
    phi = np.random.default_rng(1).normal(0, 3, (9, 11, 2))
    return Lattice(GRID, (-2, 1), phi)


@pytest.fixture
def points(lattice):
    """Points all over the lattice and beyond its edges."""
    x = lattice.grid.nodes_px(lattice.first[0] - 3, lattice.shape[1] + 6, 0)
    y = lattice.grid.nodes_px(lattice.first[1] - 3, lattice.shape[0] + 6, 1)
    unit = np.random.default_rng(2).random((400, 2))
    low, high = np.array([x[0], y[0]]), np.array([x[-1], y[-1]])
    return low + unit * (high - low)


def literal_eq_1(lattice, point):
    """Eq. (1), term by term, with the paper's indices."""
    x = (point[0] - lattice.grid.origin_px[0]) / lattice.grid.spacing_px
    y = (point[1] - lattice.grid.origin_px[1]) / lattice.grid.spacing_px
    i, j = int(np.floor(x)) - 1, int(np.floor(y)) - 1
    s, t = x - np.floor(x), y - np.floor(y)
    total = np.zeros(2)
    for k in range(4):
        for m in range(4):
            column, row = i + k - lattice.first[0], j + m - lattice.first[1]
            if 0 <= row < lattice.shape[0] and 0 <= column < lattice.shape[1]:
                total += basis(s)[k] * basis(t)[m] * lattice.phi[row, column]
    return total


def test_evaluator_matches_the_literal_equation(lattice, points):
    expected = [literal_eq_1(lattice, point) for point in points]
    np.testing.assert_allclose(lattice.at(points), expected, atol=1e-12)


def test_evaluator_matches_simpleitk(lattice):
    """SimpleITK's BSplineTransform with the same coefficients, inside its domain."""
    rows, columns = lattice.shape
    transform = SimpleITK.BSplineTransform(2, 3)
    mesh = (columns - 3, rows - 3)
    h = lattice.grid.spacing_px
    x = lattice.grid.nodes_px(lattice.first[0], columns, 0)
    y = lattice.grid.nodes_px(lattice.first[1], rows, 1)
    transform.SetTransformDomainOrigin((x[1], y[1]))
    transform.SetTransformDomainPhysicalDimensions((mesh[0] * h, mesh[1] * h))
    transform.SetTransformDomainMeshSize(mesh)
    transform.SetParameters(lattice.phi.transpose(2, 0, 1).ravel().tolist())
    unit = np.random.default_rng(3).random((200, 2)) * 0.998 + 0.001
    points = np.array([x[1], y[1]]) + unit * (np.array(mesh) * h)
    expected = [np.subtract(transform.TransformPoint(p.tolist()), p) for p in points]
    np.testing.assert_allclose(lattice.at(points), expected, atol=1e-9)


def test_grid_evaluation_and_slopes_agree_with_points(lattice):
    xs, ys = np.linspace(-10, 90, 23), np.linspace(0, 80, 19)
    grid = np.stack(np.meshgrid(xs, ys), -1).reshape(-1, 2)
    dense = lattice.on_grid(xs, ys)
    np.testing.assert_allclose(dense.reshape(2, -1).T, lattice.at(grid), atol=1e-12)
    step = 1e-5
    for axis, slope in enumerate(Field((lattice,)).slopes(xs, ys)):
        shift = np.eye(2)[axis] * step
        numeric = (lattice.at(grid + shift) - lattice.at(grid - shift)) / (2 * step)
        np.testing.assert_allclose(slope.reshape(2, -1).T, numeric, atol=1e-7)


def test_refined_lattice_is_the_same_field(lattice, points):
    np.testing.assert_allclose(lattice.refined().at(points), lattice.at(points), atol=1e-12)


def test_cell_bound_holds_is_tight_and_is_zero_outside(lattice, points):
    length = np.hypot(*lattice.at(points).T)
    column, _ = lattice.grid.locate(points[:, 0], 0)
    row, _ = lattice.grid.locate(points[:, 1], 1)
    first, bound = lattice.first_cell, lattice.bound_px
    assert bound.max() < 1.5 * length.max()
    for k, displacement in enumerate(length):
        i, j = column[k] - first[0], row[k] - first[1]
        inside = 0 <= j < bound.shape[0] and 0 <= i < bound.shape[1]
        assert displacement <= (bound[j, i] if inside else 0.0) + 1e-12


def test_reached_cells_are_the_four_by_four_round_each_control_point():
    phi = np.zeros((6, 7, 2))
    phi[2, 4, 1] = 1e-30
    lattice = Lattice(Grid((0.0, 0.0), 10.0), (3, -2), phi)
    assert np.argwhere(lattice.reached).tolist() == [
        [j, i] for j in range(2, 6) for i in range(4, 8)
    ]
