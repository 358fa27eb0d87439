"""Metrics of landmarks, on curves whose distances are known."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from benchmarks.labelled import OURS
from kogao_resources.training import evaluate
from kogao_resources.training.evaluate import Labels

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import template_face


def half_circle(radius: float) -> Array:
    angles = np.linspace(np.pi, 0.0, 400)
    return np.column_stack([np.cos(angles), np.sin(angles)]) * radius


def labelled(face: Face) -> Labels:
    return Labels(face.eyes, face.mouth, face.outline)


@pytest.fixture
def face() -> Face:
    return template_face((300.0, 300.0), 200.0)


def test_distance_between_concentric_half_circles_is_the_difference_of_their_radii() -> None:
    distances = evaluate.distance_to_line(half_circle(110.0), half_circle(100.0))
    assert distances == pytest.approx(10.0, abs=0.01)


def test_points_beyond_an_open_line_are_measured_to_its_end() -> None:
    line = np.array([[0.0, 0.0], [10.0, 0.0]])
    distances = evaluate.distance_to_line(np.array([[13.0, 4.0], [5.0, 2.0]]), line)
    assert distances.tolist() == [5.0, 2.0]


def test_errors_are_in_percent_of_the_outer_inter_ocular_distance(face: Face) -> None:
    unit = face.interocular_px / 100.0
    moved = dataclasses.replace(face, eyes=face.eyes + np.array([3.0, 4.0]) * unit)
    assert evaluate.errors(moved, labelled(face)).eyes == pytest.approx(5.0)


@pytest.mark.parametrize("scale", [0.1, 7.0])
def test_errors_do_not_depend_on_the_scale_of_the_picture(face: Face, scale: float) -> None:
    other = template_face((304.0, 301.0), 206.0, 4.0)
    grown = Affine.similarity(scale, 30.0, (5.0, 6.0))
    expected = evaluate.errors(other, labelled(face))
    assert evaluate.errors(other.mapped(grown), labelled(face.mapped(grown))) == pytest.approx(
        expected
    )


def test_hidden_points_are_not_scored(face: Face) -> None:
    labels = labelled(face)
    wrong = dataclasses.replace(labels, jaw=labels.jaw + np.eye(21)[:, :1] * 500.0)
    seen = np.ones(27, bool)
    seen[[4, 5, 6]] = False  # all of the mouth, and one of the jaw
    assert evaluate.errors(face, wrong).jaw > 10.0
    measured = evaluate.errors(face, dataclasses.replace(wrong, seen=seen))
    assert measured.jaw == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(measured.mouth)


def test_repeatability_is_symmetric_in_the_passes_up_to_their_units(face: Face) -> None:
    first = labelled(face)
    second = dataclasses.replace(first, jaw=half_circle(90.0) + 300.0, mouth=first.mouth + 2.0)
    assert evaluate.repeatability(first, second) == pytest.approx(
        evaluate.repeatability(second, first)
    )
    assert evaluate.repeatability(first, second).mouth == pytest.approx(
        np.sqrt(8.0) / first.unit_px
    )


def test_the_face_at_the_labels_is_picked_and_a_neighbour_is_not(face: Face) -> None:
    neighbour = face.mapped(Affine.similarity(1.0, 0.0, (250.0, 0.0)))
    near = template_face((304.0, 300.0), 210.0)
    assert evaluate.nearest([neighbour, near], labelled(face)) is near
    assert evaluate.nearest([neighbour], labelled(face)) is None


def test_summary_leaves_out_what_is_missing() -> None:
    assert evaluate.summary([1.0, np.nan, 3.0]) == pytest.approx((2.0, 2.9, 3.0))
    assert np.isnan(evaluate.summary([np.nan])).all()


def test_a_missed_face_lies_beyond_every_limit() -> None:
    shares = evaluate.share_below([1.0, 2.0, np.inf, np.nan], [0.5, 1.0, 1e9])
    assert shares == pytest.approx([0.0, 1 / 3, 2 / 3])


def test_our_labels_cover_turned_heads_and_repeat_within_a_percent_or_so() -> None:
    faces = json.loads(OURS.read_text(encoding="utf-8"))["faces"]
    assert len({one["id"] for one in faces}) == len(faces) >= 36
    assert sum("turned" in one["tags"] for one in faces) >= len(faces) / 3
    passes = [(Labels.of(one["first"]), Labels.of(one["second"])) for one in faces]
    apart = [evaluate.repeatability(first, second) for first, second in passes]
    assert np.nanmean(apart, axis=0)[2] < 1.2
    assert np.nanmax(apart) < 6.0
