"""Accuracy and detection on photographs; needs the shared folder and the networks."""

import json
from pathlib import Path

import numpy as np
import pytest
from kogao_resources.training.evaluate import distance_to_line
from real_photos import Scene, picture_of
from scenes import apart_percent

from kogao_core.base.geometry import Affine
from kogao_core.faces.landmarks import MeshSource
from kogao_core.faces.landmarks.mesh import LEAST_IN_COMPANY, LEAST_SCORE

LABELS = Path(__file__).parents[1] / "labels" / "faces.json"
# Every face that a person would call visible, between eyes and mouth, in thousandths of width and
# height, from left to right, listed by looking. The man at (381, 368) is half behind a head.
VISIBLE = {
    "g2.jpg": [
        *[(176, 370), (255, 363), (276, 430), (307, 355), (333, 385), (368, 415), (381, 368)],
        *[(407, 326), (443, 375), (471, 342), (530, 395), (548, 330), (588, 340), (613, 382)],
        *[(672, 340), (714, 365), (753, 318), (859, 367)],
    ],
    "g4.jpg": [(173, 650), (322, 563), (465, 668), (596, 628), (719, 582), (844, 650)],
}

EYES, MOUTH, JAW = [18, 22, 23, 27], [87, 93], slice(125, 134)


def test_studio_faces_are_within_the_baselines(shared_data: Path, source: MeshSource) -> None:
    errors = []
    for folder, every in (("frll", 6), ("canada", 4), ("composites", 1)):
        for table in sorted((shared_data / folder).glob("*[0-9a-z].csv"))[::every]:
            if table.stem == "people":
                continue
            labels = np.loadtxt(table, delimiter=",", skiprows=1)
            (face,) = source.find(picture_of(table.with_suffix(".jpg")))
            unit = np.linalg.norm(labels[EYES[3]] - labels[EYES[0]]) / 100.0
            eyes = np.linalg.norm(face.eyes - labels[EYES], axis=1).mean()
            mouth = np.linalg.norm(face.mouth - labels[MOUTH], axis=1).mean()
            jaw = distance_to_line(labels[JAW], face.outline).mean()
            errors.append(np.array([eyes, mouth, jaw]) / unit)
            assert face.score > 0.8
    assert len(errors) > 30
    # Baselines of an earlier study: 1.29, 1.23 and 1.32 % of the outer inter-ocular distance.
    # The outline's edge was learnt from these faces among others: that it isn't worse, not a claim.
    assert (np.mean(errors, axis=0) < (1.29, 1.23, 1.0)).all()


def test_faces_larger_than_the_frame_are_found(portraits: list[Scene], source: MeshSource) -> None:
    for picture, face in portraits:
        left, top, width, height = (int(value) for value in face.box)
        left, top = max(0, left + width // 50), max(0, top)
        (found,) = source.find(
            picture[top : top + height * 49 // 50, left : left + width * 24 // 25]
        )
        shift = Affine(np.eye(2), np.array([left, top], float))
        assert apart_percent(found.mapped(shift), face) < 8.0


@pytest.mark.parametrize("name", sorted(VISIBLE))
def test_every_visible_face_of_a_group_is_found_once(
    shared_data: Path, source: MeshSource, name: str
) -> None:
    picture = picture_of(shared_data / "groups" / name)
    faces = source.find(picture)
    sizes = [face.interocular_px for face in faces]
    seen = np.array(VISIBLE[name]) * (picture.shape[1], picture.shape[0]) / 1000.0
    centers = np.array([face.middle for face in faces])
    apart = np.linalg.norm(seen[:, None] - centers, axis=-1)
    assert apart.argmin(axis=1).tolist() == list(range(len(faces)))  # from left to right
    assert (apart.min(axis=1) < sizes).all()


def test_a_face_half_behind_another_is_the_least_sure(
    shared_data: Path, source: MeshSource
) -> None:
    faces = source.find(picture_of(shared_data / "groups" / "g2.jpg"))
    scores = sorted(face.score for face in faces)
    assert LEAST_IN_COMPANY < scores[0] < LEAST_SCORE < scores[1]


def test_a_statue_in_profile_is_no_face(shared_data: Path, source: MeshSource) -> None:
    # A choice, not a truth: of a profile the mesh invents the other half.
    assert source.find(picture_of(shared_data / "headshots" / "s128.jpg", 700)) == []


def test_points_under_hair_or_a_hand_are_less_sure(shared_data: Path, source: MeshSource) -> None:
    labels = json.loads(LABELS.read_text(encoding="utf-8"))["faces"]
    hidden, clear = [], []
    for entry in labels:
        covered = entry["first"].get("hidden", {}).get("outline", [])
        if not covered:
            continue
        picture = picture_of(shared_data / entry["file"])
        if "crop" in entry:
            left, top, width, height = entry["crop"]
            picture = np.ascontiguousarray(picture[top : top + height, left : left + width])
        (face,) = source.find(picture)
        assert face.confidence is not None
        line = np.array(entry["first"]["outline"])
        nearest = np.linalg.norm(face.outline[:, None] - line, axis=-1).argmin(axis=1)
        under = np.isin(nearest, covered)
        hidden.extend(face.confidence[:21][under])
        clear.extend(face.confidence[:21][~under])
    assert len(hidden) > 8
    assert np.mean(hidden) < np.mean(clear) - 0.1
