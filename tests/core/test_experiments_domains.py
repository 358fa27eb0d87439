"""Figures 14 and 15: counts are the pipeline's, and errors those of thresholds alone."""

import dataclasses

import numpy as np
import pytest
from opencv import needs_rounded_positions
from scenes import oval_face, textured_photo

from kogao_core.lab.experiments import domains
from kogao_core.lab.reports.report import Made, page
from kogao_core.lab.reports.spread import Spread
from kogao_core.lab.subjects import Subject
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import LOSSLESS_PX, PAPER


@pytest.fixture(scope="module")
def measured():
    subject = Subject("a photo (1).png", textured_photo(), (oval_face(),))
    found = domains.measure(subject, PAPER, repeats=1)
    pictures = dict(domains.pictures(subject.stem, found.masks))
    assert list(pictures) == ["a-photo-1-png-control-points.png", "a-photo-1-png-threshold.png"]
    for name, picture in zip(("control-points", "threshold"), pictures.values(), strict=True):
        assert picture.shape == (360, 480)
        assert (picture == 255).sum() == found.counts[name]
        white = (found.shown[name] == 255).all(axis=2)
        np.testing.assert_array_equal(white & (picture == 0), picture == 0)
    assert not (found.masks["threshold"] & ~found.masks["control-points"]).any()
    return found


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_counts_are_the_pipelines(measured, dtype):
    rendering = render(textured_photo(dtype=dtype), [oval_face()], PAPER)
    assert measured.counts == rendering.pixel_counts
    assert set(measured.computing_ms) == set(measured.counts)


@needs_rounded_positions
def test_the_lossless_threshold_changes_no_byte(measured):
    for step in measured.steps:
        if step.threshold_px <= LOSSLESS_PX:
            assert step.cut.max_levels == step.fade.max_levels == 0.0
            assert step.cut.psnr_db is step.fade.psnr_db is None


def test_larger_thresholds_save_more_and_err_more(measured):
    pixels = [step.pixels for step in measured.steps]
    assert pixels == sorted(pixels, reverse=True)
    assert len(set(pixels)) == len(pixels)
    late = [step for step in measured.steps if step.threshold_px >= 0.125]
    for kind in ("cut", "fade"):
        psnr = [getattr(step, kind).psnr_db for step in late]
        assert psnr == sorted(psnr, reverse=True)
        assert 20.0 < psnr[-1] < psnr[0]


def test_a_cut_leaves_a_seam_of_its_threshold_and_a_fade_a_smaller_one(measured):
    for step in measured.steps[1:]:
        assert 0.8 * step.threshold_px < step.cut.seam_px <= step.threshold_px * 1.05
        if step.threshold_px > LOSSLESS_PX:
            assert 0.0 < step.fade.seam_px < step.cut.seam_px


def test_errors_are_in_levels_of_255_at_any_depth():
    found = []
    for dtype in (np.uint8, np.uint16):
        subject = Subject("a.png", textured_photo(dtype=dtype), (oval_face(),))
        step = domains.measure(subject, PAPER, thresholds=[1.0], repeats=1).steps[0]
        found.append((step.cut.max_levels, step.cut.psnr_db))
    np.testing.assert_allclose(found[0], found[1], rtol=0.05)


def test_no_warp_has_no_domain_and_no_error():
    still = dataclasses.replace(PAPER, percent=0.0)
    subject = Subject("a.png", textured_photo(), (oval_face(),))
    found = domains.measure(subject, still, repeats=1)
    assert found.counts == {"image": 480 * 360, "control-points": 0, "threshold": 0}
    assert {step.cut for step in found.steps} == {domains.Error(0.0, None, 0.0)}
    assert "<table" in page(domains.report([found], still), Made.now("kogao-cli"))


def photo_with(levels, psnr_db, pixels):
    """A photo with one threshold, of made-up figures."""
    error = domains.Error(levels, psnr_db, 0.1)
    counts = {"image": 1000, "control-points": pixels, "threshold": pixels}
    computing = {name: Spread.of([1.0]) for name in counts}
    step = domains.ThresholdErrors(0.5, pixels, error, error, True)
    return domains.Domains(
        photo="a.png",
        width=40,
        height=25,
        faces=1,
        counts=counts,
        computing_ms=computing,
        steps=(step,),
        shown={},
        masks={},
    )


def test_medians_come_first_and_lie_between_the_middle_two_of_an_even_number():
    photos = (photo_with(10.0, 50.0, 100), photo_with(11.0, 41.0, 103), photo_with(90.0, 40.0, 900))
    counts, errors = domains.report([photo_with(1.0, None, 90), *photos], PAPER).tables
    assert [row[0] for row in counts.rows[:5]] == [*["median of 4"] * 3, "a.png", "a.png"]
    assert [row[2] for row in counts.rows[:3]] == ["1000", "101.5", "101.5"]
    assert errors.rows[0][2:4] == ("10.5", "45.5")


def test_half_of_the_photos_without_an_error_leave_no_median():
    clean, cut = photo_with(0.0, None, 90), photo_with(3.0, 40.0, 90)
    errors = domains.report([clean, cut], PAPER).tables[1]
    assert errors.rows[0][3] == "\N{EN DASH}"
