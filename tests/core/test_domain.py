"""Section 4: the three domains, exact to the pixel."""

import dataclasses

import numpy as np
import pytest
from scenes import field_of, oval_face, textured_photo

from kogao_core.base.geometry import Box
from kogao_core.faces.targets import aim
from kogao_core.field.fade import domain_of, fade_of
from kogao_core.field.field import Field
from kogao_core.paper.domain import pixel_counts, threshold_mask
from kogao_core.paper.lattice import groups
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe

IMAGE = Box(0, 0, 480, 360)


def displacement_everywhere(field):
    displacement = field.on_grid(np.arange(IMAGE.right), np.arange(IMAGE.bottom))
    return np.hypot(displacement[0], displacement[1])


def test_control_point_domain_holds_every_pixel_that_moves_at_all():
    field = field_of()
    mask = domain_of(field, IMAGE, "control-points").mask(IMAGE)
    moved = displacement_everywhere(field) > 0.0
    assert moved[mask].mean() > 0.99
    assert not moved[~mask].any()


def test_three_by_three_neighbours_would_leave_a_seam():
    """Section 4.1 says 3 x 3; leaving out the rest of each landmark's 4 x 4 shows as a step."""
    recipe, face = Recipe(), oval_face(1920, 1440)
    field = field_of(recipe, face)
    lattice = field.lattices[0]
    nearest = np.round(
        (aim(face, recipe).target_px - lattice.grid.origin_px) / lattice.grid.spacing_px
    )
    near = np.zeros(lattice.shape, bool)
    for i, j in (nearest.astype(int) - lattice.first).tolist():
        near[max(0, j - 1) : j + 2, max(0, i - 1) : i + 2] = True
    cut = Field((dataclasses.replace(lattice, phi=lattice.phi * near[..., None]),))
    xs, ys = np.arange(0, 1920, 3), np.arange(0, 1440, 3)
    step_px = np.abs(field.on_grid(xs, ys) - cut.on_grid(xs, ys)).max()
    assert step_px > 3 / 32, "less than three steps of cv2.remap's grid: nobody would see it"


@pytest.mark.parametrize("threshold_px", [LOSSLESS_PX, 0.5, 2.0])
def test_threshold_domain_is_every_pixel_that_moves_further(threshold_px):
    field = field_of(Recipe(percent=8))
    expected = displacement_everywhere(field) > threshold_px
    np.testing.assert_array_equal(threshold_mask(field.lattices, IMAGE, threshold_px), expected)
    faded = dataclasses.replace(field, fade_px=threshold_px)
    cells = domain_of(faded, IMAGE, "threshold").mask(IMAGE)
    assert cells[expected].all()


@pytest.mark.parametrize("lattice", [0.1, 0.5, 1.0, 4.0])
def test_counts_of_faces_side_by_side_are_those_of_the_masks(lattice):
    places = [(90.0, 120.0), (190.0, 150.0), (250.0, 90.0), (470.0, 340.0)]
    faces = [oval_face(center=place, size=0.35) for place in places]
    field = field_of(Recipe(percent=9, lattice=lattice), *faces)
    reached = domain_of(field, IMAGE, "control-points").mask(IMAGE)
    for threshold_px in (LOSSLESS_PX, 0.7, 3.0):
        counts = pixel_counts(field.lattices, IMAGE, threshold_px)
        assert IMAGE.area == counts["image"] >= counts["control-points"] > counts["threshold"] > 0
        assert counts["control-points"] == reached.sum()
        assert counts["threshold"] == (displacement_everywhere(field) > threshold_px).sum()


def test_faces_share_the_threshold_with_those_they_reach_and_nobody_else():
    faces = [oval_face(center=place, size=0.25) for place in [(90, 90), (170, 90), (400, 280)]]
    field = field_of(Recipe(percent=9), *faces)
    assert sorted(groups(field.lattices)) == [[0, 1], [2]]
    domain = domain_of(field, IMAGE, "threshold")
    assert not (displacement_everywhere(field) > LOSSLESS_PX)[~domain.mask(IMAGE)].any()
    alone = domain_of(Field(field.lattices[2:]), IMAGE, "threshold")
    np.testing.assert_array_equal(domain.cells[2].active, alone.cells[0].active)


def test_bounds_hold_the_mask_tightly():
    domain = domain_of(field_of(), IMAGE, "threshold")
    mask, box = domain.mask(IMAGE), domain.bounds
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    assert (box.left, box.top) == (columns[0], rows[0])
    assert (box.right, box.bottom) == (columns[-1] + 1, rows[-1] + 1)


def test_only_a_threshold_above_lossless_fades():
    assert fade_of(Recipe()) == 0.0
    assert fade_of(Recipe(domain="image", threshold_px=1.0)) == 0.0
    assert fade_of(Recipe(threshold_px=1.0)) == 1.0


def test_no_seam_at_the_edge_of_a_large_threshold():
    """Neighbouring pixels part by less than three times what the field itself has.

    That is the steepest slope of a fade; a hard cut tears them.
    """
    recipe = Recipe(percent=10, threshold_px=1.0)
    rendering = render(textured_photo(), [oval_face()], recipe)
    spline = Field(rendering.field.lattices)
    hard = spline.on_grid(np.arange(480), np.arange(360))
    hard *= np.hypot(*hard) > 1.0

    def tear(displacement):
        return max(np.abs(np.diff(displacement, axis=axis)).max() for axis in (1, 2))

    faded = rendering.field.on_grid(np.arange(480), np.arange(360))
    untouched = spline.on_grid(np.arange(480), np.arange(360))
    assert tear(faded) < 3.0 * tear(untouched)
    assert tear(hard) > 0.9
