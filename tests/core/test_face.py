"""The face value: edits, maps, JSON and selection."""

import dataclasses
import json

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.base.geometry import Affine
from kogao_core.faces.face import Face, in_reading_order, select


def test_landmarks_cannot_be_changed_in_place():
    face = oval_face()
    with pytest.raises(ValueError, match="read-only"):
        face.outline[0] = 0.0


def test_dragging_a_point_keeps_the_lattice_anchor():
    face = oval_face()
    for moved in (
        face.with_outline_point(3, (0.0, 0.0)),
        face.with_eye_point(1, (9.0, 9.0)),
        face.with_mouth_point(0, (9.0, 9.0)),
        face.with_target(2, (5.0, 5.0)),
    ):
        assert moved.anchor == face.anchor
    assert face.with_outline_point(3, (0.0, 0.0)).outline[3].tolist() == [0.0, 0.0]


def test_mapping_there_and_back_is_the_identity():
    face = oval_face().with_target(4, (50.0, 60.0))
    turn = Affine.similarity(1.7, 33.0, (12.0, -5.0))
    back = face.mapped(turn).mapped(turn.inverse)
    np.testing.assert_allclose(back.points, face.points, atol=1e-9)
    np.testing.assert_allclose(back.targets, face.targets, atol=1e-9)
    np.testing.assert_allclose(back.anchor.origin_px, face.anchor.origin_px, atol=1e-9)
    assert face.mapped(turn).anchor.spacing_px == pytest.approx(1.7 * face.anchor.spacing_px)


def test_json_has_the_documented_fields():
    face = json.loads(json.dumps(oval_face().to_dict()))
    assert list(face) == ["box", "score", "outline", "eyes", "mouth", "confidence"]
    assert face["confidence"] is None, "nobody said how sure the points are"
    assert np.shape(face["outline"]) == (21, 2)
    assert np.shape(face["eyes"]) == (4, 2)
    assert np.shape(face["mouth"]) == (2, 2)
    x, y, width, height = face["box"]
    points = np.array(face["outline"])
    assert x == points[:, 0].min()
    assert x + width == pytest.approx(points[:, 0].max())
    assert y + height == pytest.approx(points[:, 1].max())


@pytest.mark.parametrize("outline", [np.zeros((2, 2)), np.zeros((21, 3))])
def test_a_broken_outline_is_refused(outline):
    face = oval_face()
    with pytest.raises(ValueError, match="points"):
        Face(outline, face.eyes, face.mouth)


def faces_at(*places):
    return [oval_face(center=place, size=0.3) for place in places]


@pytest.mark.parametrize(
    "counted",
    [
        # One row, however uneven, and whoever is larger.
        [(100, 230), (200, 150), (300, 210), (400, 140)],
        # A child in front of its parents, two people of very different height.
        [(100, 100), (200, 600), (300, 100)],
        [(100, 600), (200, 100)],
        # Two rows of two at least, neither of them level.
        [(100, 110), (300, 90), (50, 620), (200, 600), (350, 640)],
        [(100, 100), (300, 100), (50, 600), (200, 600), (100, 1100), (300, 1100)],
    ],
)
def test_faces_are_counted_as_people_count_them(counted):
    faces = faces_at(*counted)
    for seed in range(5):
        mixed = [faces[k] for k in np.random.default_rng(seed).permutation(len(faces))]
        assert [counted[faces.index(face)] for face in in_reading_order(mixed)] == counted


def test_selection():
    faces = [oval_face(size=0.3), oval_face(size=0.7), oval_face(size=0.5)]
    assert select(faces, "all") == faces
    assert select(faces, "largest") == [faces[1]]
    assert select(faces, "3,1,3") == [faces[0], faces[2]]
    assert select([], "largest") == []
    for wrong in ("0", "4", "1,x", "", "smallest"):
        with pytest.raises(ValueError, match="face"):
            select(faces, wrong)


def test_confidence_travels_with_its_points_and_a_hand_is_sure():
    face = dataclasses.replace(oval_face(), confidence=np.linspace(0.0, 0.9, 27))
    mapped = face.mapped(Affine.similarity(2.0, 30.0, (1.0, 2.0)))
    np.testing.assert_array_equal(mapped.confidence, face.confidence)
    for moved, row in (
        (face.with_outline_point(-1, (5.0, 5.0)), 20),
        (face.with_eye_point(1, (5.0, 5.0)), 22),
        (face.with_mouth_point(0, (5.0, 5.0)), 25),
    ):
        others = np.arange(27) != row
        assert moved.confidence[row] == 1.0
        np.testing.assert_array_equal(moved.confidence[others], face.confidence[others])
    aimed = face.with_target(2, (5.0, 5.0))
    np.testing.assert_array_equal(aimed.confidence, face.confidence)
    assert oval_face().with_outline_point(3, (5.0, 5.0)).confidence is None


@pytest.mark.parametrize("confidence", [np.ones(21), np.full(27, 1.5), np.full(27, np.nan)])
def test_a_broken_confidence_is_refused(confidence):
    with pytest.raises(ValueError, match=r"shape|between 0 and 1"):
        dataclasses.replace(oval_face(), confidence=confidence)
