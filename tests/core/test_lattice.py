"""Section 2.1: eq. (1) and (2) against other people's B-splines."""

import numpy as np
import pytest
import SimpleITK
from numpy.testing import assert_equal
from scipy.interpolate import BSpline

from kogao_core.warp.field import Field
from kogao_core.warp.lattice import Grid, Lattice, NodeWindow, basis, basis_slope, matrices

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


def test_weights_are_a_partition_of_unity():
    np.testing.assert_allclose(basis(np.linspace(0, 0.999, 50)).sum(-1), 1.0, atol=1e-12)
    np.testing.assert_allclose(basis_slope(np.linspace(0, 0.999, 50)).sum(-1), 0.0, atol=1e-12)


def test_weights_are_never_negative():
    assert basis(np.linspace(0, 1, 101)).min() >= 0.0


def test_slope_is_the_derivative_of_the_basis():
    s, step = np.linspace(0.01, 0.99, 30), 1e-6
    numeric = (basis(s + step) - basis(s - step)) / (2 * step)
    np.testing.assert_allclose(basis_slope(s), numeric, atol=1e-8)


def test_evaluator_matches_the_literal_equation(lattice, points):
    expected = [literal_eq_1(lattice, point) for point in points]
    np.testing.assert_allclose(lattice.at(points), expected, atol=1e-12)


def test_evaluator_matches_scipy(lattice, points):
    """A tensor product of scipy's B-splines over the same knots."""

    def axis_weights(coords, axis, count):
        knots = lattice.grid.nodes_px(lattice.first[axis] - 2, count + 4, axis)
        elements = [
            BSpline.basis_element(knots[k : k + 5], extrapolate=False)(coords) for k in range(count)
        ]
        return np.nan_to_num(np.column_stack(elements))

    bx = axis_weights(points[:, 0], 0, lattice.shape[1])
    by = axis_weights(points[:, 1], 1, lattice.shape[0])
    expected = np.einsum("nj,ni,jic->nc", by, bx, lattice.phi)
    np.testing.assert_allclose(lattice.at(points), expected, atol=1e-9)


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


def test_weights_of_many_windows_are_those_of_each_alone():
    rng = np.random.default_rng(4)
    windows = [
        NodeWindow(
            Grid(tuple(rng.normal(0, 9, 2)), h), (rng.uniform(-99, 99, n), rng.random(m)), *of
        )
        for h, n, m, of in (
            (9.25, 30, 7, ((-2, 1), (3, 5))),
            (0.7, 1, 0, ((0, 0), (40, 1))),
            (31.0, 12, 50, ((-9, -3), (20, 18))),
        )
    ]
    kinds = (basis, basis_slope)
    for window, found in zip(windows, matrices(windows, kinds), strict=True):
        assert_equal(found, matrices([window], kinds)[0])
        for (bx, by), weigh in zip(found, kinds, strict=True):
            for axis, weights in enumerate((bx, by)):
                cell, s = window.grid.locate(window.coords_px[axis], axis)
                nodes = window.first[axis] + np.arange(window.shape[1 - axis])
                each = nodes - (cell[:, None] - 1)
                own = np.take_along_axis(weigh(s), each.clip(0, 3), 1)
                assert_equal(weights, np.where((each >= 0) & (each < 4), own, 0.0))
    assert matrices([]) == []


@pytest.mark.parametrize("size_px", [0.4, 5.0, 40.0, 400.0])
def test_most_in_rectangles_is_the_largest_of_the_cells_they_touch(lattice, size_px):
    values = np.random.default_rng(5).random((2, *lattice.reached.shape))
    left, top, right, bottom = lattice.reach_px
    x, y = np.arange(left - 50, right + 50, size_px), np.arange(top - 50, bottom + 50, size_px)
    spans = np.stack([x, x + size_px]), np.stack([y, y + size_px])
    found = lattice.most_in(values, spans)
    edges = np.linspace(0, 1, int(size_px / 2) + 2)
    inside = (x[:, None] + size_px * edges).ravel(), (y[:, None] + size_px * edges).ravel()
    (column, row) = (lattice.grid.locate(at, axis)[0] for axis, at in enumerate(inside))
    edged = np.pad(values, [(0, 0), (1, 1), (1, 1)])
    column = (column - lattice.first_cell[0] + 1).clip(0, edged.shape[2] - 1)
    row = (row - lattice.first_cell[1] + 1).clip(0, edged.shape[1] - 1)
    each = edged[:, row[:, None], column].reshape(2, len(y), len(edges), len(x), len(edges))
    assert_equal(found, each.max(axis=(2, 4)))


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


def test_bezier_form_is_the_same_field(lattice):
    """The Bezier form evaluated with Bernstein's polynomials is the spline."""
    s = np.linspace(0.0, 1.0, 5)
    bernstein = np.stack([(1 - s) ** 3, 3 * s * (1 - s) ** 2, 3 * s**2 * (1 - s), s**3], axis=1)
    j, i = 4, 6
    cell = bernstein @ lattice.bezier[j, i] @ bernstein.T
    x, y = (
        lattice.grid.nodes_px(lattice.first_cell[axis] + index, 2, axis)
        for axis, index in ((0, i), (1, j))
    )
    expected = lattice.on_grid(x[0] + s * GRID.spacing_px, y[0] + s * GRID.spacing_px)
    np.testing.assert_allclose(cell, expected, atol=1e-12)


def test_reached_cells_are_the_four_by_four_round_each_control_point():
    phi = np.zeros((6, 7, 2))
    phi[2, 4, 1] = 1e-30
    lattice = Lattice(Grid((0.0, 0.0), 10.0), (3, -2), phi)
    assert np.argwhere(lattice.reached).tolist() == [
        [j, i] for j in range(2, 6) for i in range(4, 8)
    ]


def test_window_cuts_and_pads_with_zeros(lattice):
    cut = lattice.window((-4, 0), (4, 20))
    np.testing.assert_array_equal(cut[1:, 2:13], lattice.phi[:3])
    cut[1:, 2:13] = 0.0
    assert not cut.any()
    assert not lattice.window((100, 100), (3, 3)).any()
