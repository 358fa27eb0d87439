"""The same photo turned, mirrored, halved or darkened has the same face: within 1.5 %, mean."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from few_cases import few_of
from real_photos import Scene, found_in, picture_of
from scenes import apart_percent, mirrored, resized, turned

from kogao_core.faces.landmarks import MeshSource

SAMPLES = Path(__file__).parents[2] / "resources" / "samples"
LIMIT_PERCENT = 1.5


@pytest.fixture(
    scope="module", params=["samples", pytest.param("portraits", marks=pytest.mark.data)]
)
def scenes(request: pytest.FixtureRequest, source: MeshSource) -> list[Scene]:
    """Pictures with one face each: our samples, and every ninth shared portrait if there."""
    if request.param == "portraits":
        return request.getfixturevalue("portraits")
    return found_in(sorted(SAMPLES.glob("*.jpg")), source)


@pytest.mark.parametrize(
    ("change", "by"),
    [
        *few_of([(turned, by) for by in (17.0, 250.0, 135.0, 45.0, 90.0, 180.0, 330.0)], 2),
        *[(resized, by) for by in (0.5, 2.0)],
    ],
)
def test_turning_and_resizing(scenes: list[Scene], source: MeshSource, change, by: float) -> None:
    moved = []
    for picture, face in scenes:
        other, mapping = change(picture, by)
        (found,) = source.find(other)
        moved.append(apart_percent(found, face.mapped(mapping)))
    assert np.mean(moved) < LIMIT_PERCENT
    # A chin in shade has two edges to choose from once it is turned.
    assert max(moved) < (3.0 if change is turned else 2.0)


def test_mirroring(scenes: list[Scene], source: MeshSource) -> None:
    moved, surer = [], []
    for picture, face in scenes:
        other, expected = mirrored(picture, face)
        (found,) = source.find(other)
        moved.append(apart_percent(found, expected))
        assert face.confidence is not None
        assert found.confidence is not None
        surer.append(np.abs(found.confidence[:21] - face.confidence[:21][::-1]).mean())
    assert max(moved) < 1.0
    assert np.mean(surer) < 0.05


@pytest.mark.parametrize("light", few_of((0.3, 0.5), 1))
def test_darkening(scenes: list[Scene], source: MeshSource, light: float) -> None:
    moved = []
    for picture, face in scenes:
        (found,) = source.find((picture * light).astype(np.uint8))
        moved.append(apart_percent(found, face))
    assert np.mean(moved) < LIMIT_PERCENT


@pytest.mark.parametrize("degrees", few_of((90, 0, 180), 1))
def test_a_face_of_two_percent_is_found_however_it_lies(source: MeshSource, degrees: int) -> None:
    picture = picture_of(SAMPLES / "women.jpg")
    (face,) = source.find(picture)
    left, top, width, height = (round(value) for value in face.box)
    head = picture[max(0, top - height // 2) : top + height, left : left + width]
    scale = 0.02 * 1600 / max(width, height)
    small = cv2.resize(head, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    small = np.rot90(small, degrees // 90)
    wall = np.random.default_rng(3).integers(120, 150, (1200, 1600, 3), np.uint8)
    wall = cv2.GaussianBlur(wall, (0, 0), 3.0)
    rows, columns = small.shape[:2]
    wall[700 : 700 + rows, 400 : 400 + columns] = small
    (found,) = source.find(wall)
    np.testing.assert_allclose(
        found.points.mean(axis=0),
        (400 + columns / 2, 700 + rows / 2),
        atol=0.4 * max(rows, columns),
    )
