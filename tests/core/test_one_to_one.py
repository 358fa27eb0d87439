"""The one-to-one report against dense looks, and its proof against everything."""

import numpy as np
import pytest
from few_cases import few_of
from scenes import field_of, oval_face

from kogao_core.field.field import Field
from kogao_core.field.one_to_one import (
    INJECTIVE_BOUND,
    certify,
    check_one_to_one,
    fade_is_safe,
    least_det,
    lower_bound,
)
from kogao_core.paper.lattice import Grid, Lattice
from kogao_core.recipe.recipe import Recipe


def dense_det(lattice, step=0.02):
    left, top, right, bottom = lattice.reach_px
    h = lattice.grid.spacing_px * step
    return Field((lattice,)).det_jacobian(np.arange(left, right, h), np.arange(top, bottom, h))


def test_mild_warp_is_certified_by_the_choi_and_lee_bound():
    field = field_of(Recipe(percent=4))
    lattice = field.lattices[0]
    assert lattice.magnitude_px.max() < INJECTIVE_BOUND * lattice.grid.spacing_px
    report = check_one_to_one(field)
    assert report.certified
    assert not report.folds
    assert 0.7 < report.min_det < 1.0


def test_a_warp_beyond_that_bound_is_certified_cell_by_cell():
    field = field_of(Recipe(percent=10))
    lattice = field.lattices[0]
    assert lattice.magnitude_px.max() > INJECTIVE_BOUND * lattice.grid.spacing_px
    assert check_one_to_one(field).certified


@pytest.mark.parametrize("seed", few_of(range(40), 6))
def test_lower_bound_is_below_every_determinant_and_not_far(seed):
    rng = np.random.default_rng(seed)
    phi = rng.normal(0.0, rng.uniform(0.5, 4.0), (4, 5, 2))
    lattice = Lattice(Grid((3.0, 5.0), 10.0), (0, 0), phi)
    det = dense_det(lattice)
    bound = lower_bound(lattice, lattice.reached)
    assert bound <= det.min() + 1e-9
    assert (bound > 0.0) == (det.min() > 0.0) or det.min() < 0.15, "the bound is too loose to use"


def test_fold_is_found_where_a_dense_look_finds_it():
    field = field_of(Recipe(percent=12, lattice=0.25))
    report = check_one_to_one(field)
    assert report.folds
    assert not report.certified
    xs, ys = np.arange(100, 380, 0.25), np.arange(50, 310, 0.25)
    det = field.det_jacobian(xs, ys)
    assert report.min_det == pytest.approx(det.min(), rel=0.1)
    rows, columns = np.nonzero(det < -0.1)
    for x, y in zip(xs[columns[::97]], ys[rows[::97]], strict=True):
        assert any(
            left <= x <= left + w and top <= y <= top + h for left, top, w, h in report.folded_cells
        )


@pytest.mark.parametrize("fade_px", few_of([1.0, 0.02, 0.2, 3.0], 1))
def test_a_fade_called_safe_never_folds_and_mild_ones_are_called_safe(fade_px):
    safe = []
    for percent in (1, 4, 8):
        for ratio in (0.5, 1, 2):
            field = field_of(Recipe(percent=percent, lattice=ratio), fade_px=fade_px)
            safe.append(fade_is_safe(field))
            xs, ys = np.arange(110, 370, 0.5), np.arange(60, 320, 0.5)
            if safe[-1] and certify(field):
                assert field.det_jacobian(xs, ys).min() > 0.0
    assert any(safe)


def test_a_fade_is_safe_up_to_a_slope_of_a_third():
    (lattice,) = field_of(Recipe(percent=4)).lattices
    steepest = lattice.refined().refined().steepest.max()
    parts = (lattice.scaled(slope / steepest) for slope in (0.33, 0.34))
    assert [fade_is_safe(Field((part,), fade_px=1e3)) for part in parts] == [True, False]


def test_overlapping_fields_are_certified_only_while_gentle():
    left, right = oval_face(center=(170.0, 170.0)), oval_face(center=(350.0, 170.0))
    assert certify(field_of(Recipe(percent=4), left, right))
    assert not certify(field_of(Recipe(percent=15), left, right))
    far = oval_face(center=(900.0, 170.0))
    assert certify(field_of(Recipe(), left, far))


@pytest.mark.parametrize(
    ("apart", "percent", "lattice"),
    few_of([(0.3, 4, 1), (0.7, 9, 0.5), (1.0, 9, 0.5), (0.3, 15, 0.3), (0.9, 15, 0.3)], 3),
)
def test_faces_that_overlap_report_what_every_sample_says(apart, percent, lattice):
    places = [(150.0, 170.0), (150.0 + 200.0 * apart, 170.0), (160.0, 170.0 + 240.0 * apart)]
    field = field_of(Recipe(percent=percent, lattice=lattice), *map(oval_at, places))
    lowest, folded = 1.0, 0
    for lattice_ in field.lattices:
        (left, top, _, _), h = lattice_.reach_px, lattice_.grid.spacing_px
        rows, columns = lattice_.reached.shape
        xs, ys = (a + h / 8 * (np.arange(8 * n) + 0.5) for a, n in ((left, columns), (top, rows)))
        det = field.det_jacobian(xs, ys).reshape(rows, 8, columns, 8).min(axis=(1, 3))
        lowest, folded = min(lowest, det.min()), folded + np.count_nonzero(det <= 0.0)
    report = check_one_to_one(field)
    assert report.min_det == pytest.approx(lowest, abs=1e-12)
    assert len(report.folded_cells) == folded
    assert least_det(field, 0.5) == pytest.approx(min(lowest, 0.5), abs=1e-12)


def test_touching_faces_without_a_proof_are_settled_down_to_a_small_det():
    field = field_of(Recipe(percent=12, lattice=0.3), oval_at((150, 170)), oval_at((290, 170)))

    def reduced_to(det):
        low, high = 0.0, 1.0
        for _ in range(14):
            middle = (low + high) / 2.0
            part = Field(tuple(lattice.scaled(middle) for lattice in field.lattices))
            low, high = (middle, high) if least_det(part) > det else (low, middle)
        return check_one_to_one(part)

    assert least_det(field) < 0.0
    assert [reduced_to(det).settled for det in (0.07, 0.035)] == [True, False]


def oval_at(place):
    return oval_face(center=place, size=0.6)


@pytest.mark.parametrize("seed", few_of(range(6), 1))
def test_a_fold_between_the_samples_is_never_called_settled(seed):
    phi = np.random.default_rng(seed).normal(0.0, 40.0, (6, 6, 2))

    def report_of(share):
        return check_one_to_one(Field((Lattice(Grid((0.0, 0.0), 10.0), (0, 0), share * phi),)))

    low, high = 0.0, 1.0
    assert report_of(low).settled
    assert report_of(high).folds
    for _ in range(40):
        middle = (low + high) / 2.0
        low, high = (low, middle) if report_of(middle).folds else (middle, high)
    # So near to a fold that samples show none where there is one.
    report = report_of(low)
    assert dense_det(Lattice(Grid((0.0, 0.0), 10.0), (0, 0), low * phi), 0.004).min() < 0.0
    assert not report.folds
    assert not report.settled
