"""Distortion grows with the distance, is 24 variants a photo, and stands beside table 1."""

import dataclasses
import json

import numpy as np
import pytest
from scenes import oval_face, textured_photo
from scipy.stats import spearmanr

from kogao_core.lab.experiments import distortion
from kogao_core.lab.reports.report import Made, page
from kogao_core.lab.subjects import Subject
from kogao_core.paper.table1 import UNNATURAL
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER

PLAIN = Subject("plain.png", np.full((180, 240, 3), 90, np.uint8), (oval_face(240, 180),))


@pytest.fixture(scope="module")
def result():
    photo = textured_photo()
    photo[:, 130:134] = 255  # a door frame beside the face
    photo[:, 134:138] = 0
    subject = Subject("made.png", photo, (oval_face(),))
    return distortion.DistortionResult(tuple(distortion.measure(subject)), PAPER)


def grid(result, name):
    found = [one for one in result.distortions if one.variant.kind == "table1"]
    return np.array([getattr(one, name) for one in found]).reshape(4, 5)


def test_there_are_twenty_variants_and_four_lattices(result):
    kinds = [one.variant.kind for one in result.distortions]
    assert (kinds.count("table1"), kinds.count("figure11")) == (20, 4)
    records = distortion.report(result).records
    published = [r["published_unnatural_percent"] for r in records if r["kind"] == "table1"]
    assert published == [value for row in UNNATURAL for value in row]
    json.dumps(distortion.report(result).document, allow_nan=False)


@pytest.mark.parametrize("name", ["local_area", "rise", "photo_turn", "residual"])
def test_distortion_grows_with_the_distance(result, name):
    values = grid(result, name)
    assert (values > 0.0).all()
    assert (np.diff(values, axis=1) > 0.0).all()


def test_the_face_gets_smaller_by_what_was_asked(result):
    """Every outline point moves p % of the way to the centre, so areas shrink by (1 - p)^2."""
    area = grid(result, "face_area")
    asked = 100.0 * ((1.0 - np.array([0.02, 0.04, 0.06, 0.08, 0.10])) ** 2 - 1.0)
    np.testing.assert_allclose(area, np.tile(asked, (4, 1)), rtol=0.2)


def test_what_is_compressed_stands_beside_what_is_stretched(result):
    """The map goes backward: the face shrinks where det J is above 1."""
    smallest, largest = grid(result, "min_det"), grid(result, "max_det")
    assert (smallest < 1.0).all()
    assert (largest > 1.0).all()
    assert (np.diff(largest, axis=1) > 0.0).all()
    captions = {table.caption for table in distortion.report(result).tables}
    assert "smallest det J, sampled: stretch" in captions
    assert "largest det J, sampled: compression" in captions
    (face,), step = [oval_face()], 0.5
    field = render(textured_photo(), [face], PAPER).field
    (x, y), (w, h) = face.box[:2], face.box[2:]
    det = field.det_jacobian(np.arange(x - w, x + 2 * w, step), np.arange(y - h, y + 2 * h, step))
    one = next(d for d in result.distortions if (d.variant.center, d.variant.percent) == (2, 4.0))
    np.testing.assert_allclose([one.min_det, one.max_det], [det.min(), det.max()], atol=0.005)


def test_where_landmarks_land_is_told_from_the_miss_at_the_targets(result):
    face, eyes = oval_face(), 100.0 / oval_face().interocular_px
    (one, *_) = [d for d in result.distortions if d.variant.percent == 10.0]
    rendering = render(textured_photo(), [face], one.variant.recipe(PAPER))
    (pairs,) = rendering.pairs
    landed = pairs.source_px.copy()
    for _ in range(200):  # by hand: x = source - d(x)
        landed = pairs.source_px - rendering.field.at(landed)
    apart = np.linalg.norm(landed - pairs.target_px, axis=1).mean()
    assert one.landing == pytest.approx(eyes * apart, rel=1e-3)
    assert one.residual == pytest.approx(eyes * rendering.residual.mean_px)
    assert abs(one.landing - one.residual) > 1e-3 * one.residual


def test_smaller_lattices_come_closer_to_folding(result):
    sizes = [one for one in result.distortions if one.variant.kind == "figure11"]
    dets = [one.min_det for one in sizes]
    assert dets == sorted(dets)
    spacings = np.array([one.spacing_px for one in sizes])
    lattices = np.array([one.variant.lattice for one in sizes])
    np.testing.assert_allclose(spacings / lattices, oval_face().anchor.spacing_px)


def test_a_recipe_that_moves_nothing_and_a_photo_without_lines_have_a_report():
    base = dataclasses.replace(PAPER, threshold_px=16.0)
    found = tuple(distortion.measure(PLAIN, base))
    assert {(one.local_area, one.photo_turn) for one in found} == {(0.0, None)}
    report = distortion.report(distortion.DistortionResult(found, base))
    assert page(report, Made.now("kogao-cli"))
    report.json(Made.now("kogao-cli"))  # which refuses NaN
    (growth,) = [table for table in report.tables if "Growth of" in table.caption]
    for words in ("local change", "in the photo"):
        (row,) = [row for row in growth.rows if words in row[0]]
        assert set(row[1:]) == {"\N{EN DASH}"}


def test_rank_correlation_is_spearmans():
    for a, b in np.random.default_rng(0).integers(0, 6, (5, 2, 20)).astype(float):
        expected = spearmanr(a, b).statistic
        assert distortion.rank_correlation(a, b) == pytest.approx(expected)
