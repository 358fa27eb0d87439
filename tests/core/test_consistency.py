"""The same photo turned, mirrored, halved or darkened has the same face: within 1.5 %, mean."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from kogao_core.face import Face
from kogao_core.geometry import Affine
from kogao_core.landmarks import MeshSource

SAMPLES = Path(__file__).parents[2] / "resources" / "samples"
LIMIT_PERCENT = 1.5
Picture = np.ndarray
Scene = tuple[Picture, Face]


@pytest.fixture(scope="module")
def source(weights: Path) -> MeshSource:
    assert weights.is_dir()
    return MeshSource()


@pytest.fixture(scope="module", params=["samples", "portraits"])
def scenes(request: pytest.FixtureRequest, source: MeshSource) -> list[Scene]:
    """Pictures with one face each: our samples, and every ninth shared portrait if there."""
    if request.param == "samples":
        paths = sorted(SAMPLES.glob("*.jpg"))
    else:
        folder: Path = request.getfixturevalue("shared_data") / "portraits"
        paths = sorted(folder.glob("*.jpg"))[4::9]
    return list(_scenes(paths, source))


def _scenes(paths: list[Path], source: MeshSource) -> Iterator[Scene]:
    for path in paths:
        picture = cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB)
        scale = min(1.0, 640.0 / max(picture.shape))
        small = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        (face,) = source.find(small)
        yield small, face


def apart_percent(one: Face, other: Face) -> float:
    apart = np.linalg.norm(one.points - other.points, axis=1).mean()
    return float(apart / other.interocular_px * 100.0)


@pytest.mark.parametrize("degrees", [17.0, 45.0, 90.0, 135.0, 180.0, 250.0, 330.0])
def test_turning(scenes: list[Scene], source: MeshSource, degrees: float) -> None:
    moved = []
    for picture, face in scenes:
        rows, columns = picture.shape[:2]
        side = int(np.hypot(rows, columns)) + 1
        turn = Affine.similarity(1.0, degrees, (0.0, 0.0))
        middle = turn(((columns - 1) / 2.0, (rows - 1) / 2.0))
        turn = Affine(turn.matrix, (side - 1) / 2.0 - middle)
        turned = cv2.warpAffine(picture, turn.opencv, (side, side), flags=cv2.INTER_CUBIC)
        (found,) = source.find(turned)
        moved.append(apart_percent(found, face.mapped(turn)))
    assert np.mean(moved) < LIMIT_PERCENT


def test_mirroring(scenes: list[Scene], source: MeshSource) -> None:
    moved, surer = [], []
    for picture, face in scenes:
        (found,) = source.find(np.ascontiguousarray(picture[:, ::-1]))
        mirror = Affine(np.diag([-1.0, 1.0]), np.array([picture.shape[1] - 1.0, 0.0]))
        parts = (mirror(part)[::-1] for part in (face.outline, face.eyes, face.mouth))
        moved.append(apart_percent(found, Face(*parts)))
        assert face.confidence is not None
        assert found.confidence is not None
        surer.append(np.abs(found.confidence[:21] - face.confidence[:21][::-1]).mean())
    assert np.mean(moved) < LIMIT_PERCENT
    assert np.mean(surer) < 0.05


def test_halving(scenes: list[Scene], source: MeshSource) -> None:
    moved = []
    for picture, face in scenes:
        half = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        rows, columns = half.shape[0] / picture.shape[0], half.shape[1] / picture.shape[1]
        (found,) = source.find(half)
        moved.append(apart_percent(found, face.mapped(Affine.resize(columns, rows))))
    assert np.mean(moved) < LIMIT_PERCENT


@pytest.mark.parametrize("light", [0.5, 0.3])
def test_darkening(scenes: list[Scene], source: MeshSource, light: float) -> None:
    moved = []
    for picture, face in scenes:
        (found,) = source.find((picture * light).astype(np.uint8))
        moved.append(apart_percent(found, face))
    assert np.mean(moved) < LIMIT_PERCENT


@pytest.mark.parametrize("degrees", [0, 90, 180])
def test_a_face_of_two_percent_is_found_however_it_lies(source: MeshSource, degrees: int) -> None:
    picture = cv2.cvtColor(cv2.imread(str(SAMPLES / "women.jpg")), cv2.COLOR_BGR2RGB)
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
