"""The committed appearance model: what it finds, and which files it refuses."""

from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest
from few_cases import few_of
from kogao_resources.training import evaluate
from kogao_resources.training.aam.writing import write
from opencv import needs_opencv_4
from real_photos import picture_of
from scenes import apart_percent, mirrored, resized, turned

from kogao_core.base import assets
from kogao_core.faces.landmarks import MeshSource, ModelRefused
from kogao_core.faces.landmarks.aam.model import read
from kogao_core.faces.landmarks.aam.source import MODEL, AamSource, HaarFaces
from kogao_core.faces.landmarks.blazeface import Detection
from kogao_core.faces.landmarks.pixels import Pyramid

SAMPLES = ("average", "women", "men")


def sample(name: str) -> np.ndarray:
    return picture_of(assets.path(f"samples/{name}.jpg"))


@pytest.fixture(scope="module")
def source() -> AamSource:
    return AamSource()


def test_the_model_is_small_and_writes_back_the_same(tmp_path: Path) -> None:
    stored = assets.path(MODEL)
    assert stored.stat().st_size < 4_000_000
    copies = [tmp_path / "first.npz", tmp_path / "second.npz"]
    for copy in copies:
        write(read(stored), copy)
    assert copies[0].read_bytes() == copies[1].read_bytes()
    # Headers of the archive differ between versions of Python, arrays don't.
    with np.load(stored) as before, np.load(copies[0]) as after:
        assert before.files == after.files
        for name in before.files:
            assert before[name].dtype == after[name].dtype
            np.testing.assert_array_equal(before[name], after[name])


@pytest.mark.usefixtures("weights")
@pytest.mark.parametrize("name", SAMPLES)
def test_it_agrees_with_the_mesh_on_the_samples(source: AamSource, name: str) -> None:
    (fitted,) = source.find(sample(name))
    (mesh,) = MeshSource().find(sample(name))
    errors = evaluate.errors(fitted, evaluate.Labels(mesh.eyes, mesh.mouth, mesh.outline))
    assert np.mean(errors) < 3.0
    assert fitted.score > 0.5
    assert fitted.source == "aam"


@pytest.mark.parametrize("degrees", few_of((170.0, 0.0, 90.0), 1))
@needs_opencv_4("it has no Haar cascades")
def test_without_networks_it_starts_from_haar_boxes(
    lack: Callable[[str], None], degrees: float
) -> None:
    lack(".tflite")
    picture = sample("average")
    (upright,) = AamSource().find(picture)
    assert upright.interocular_px > 0.15 * picture.shape[1]
    other, turn = turned(picture, degrees, cv2.BORDER_REPLICATE)
    (face,) = AamSource().find(other)
    assert apart_percent(face, upright.mapped(turn)) < 1.5


@needs_opencv_4("it has no Haar cascades")
def test_the_cascade_finds_small_and_turned_faces() -> None:
    def boxes(side_px: int) -> Iterator[list[Detection]]:
        wall = np.full((512, 512, 3), picture[0, 0], np.uint8)
        wall[200 : 200 + side_px, 200 : 200 + side_px] = cv2.resize(picture, (side_px, side_px))
        return HaarFaces().boxes(Pyramid(wall))

    picture = sample("average")
    assert [bool(next(boxes(side_px))) for side_px in (30, 56)] == [False, True]
    picture, _ = turned(picture, -30.0, cv2.BORDER_REPLICATE)
    assert [len(one) for one in islice(boxes(300), 3)] == [0, 0, 1]


@pytest.mark.usefixtures("weights")
@pytest.mark.parametrize("change", ["mirror", "half", "dark", "145", "90"])
def test_turning_mirroring_shrinking_and_darkening_hardly_move_it(
    source: AamSource, change: str
) -> None:
    picture = sample("women" if change.isdecimal() else "men")
    (face,) = source.find(picture)
    if change == "mirror":
        picture, face = mirrored(picture, face)
    elif change == "half":
        picture, half = resized(picture, 0.5)
        face = face.mapped(half)
    elif change == "dark":
        picture = picture // 2
    else:
        picture, turn = turned(picture, float(change), cv2.BORDER_REPLICATE)
        face = face.mapped(turn)
    (other,) = source.find(picture)
    assert apart_percent(other, face) < 1.5


@pytest.mark.usefixtures("weights")
def test_a_covered_mouth_is_doubted(source: AamSource) -> None:
    picture = sample("average")
    (clear,) = source.find(picture)
    x, y = clear.mouth_center.astype(int)
    half = int(0.35 * clear.interocular_px)
    noise = np.random.default_rng(0).integers(0, 256, (half // 4, half // 2, 3), np.uint8)
    covered = picture.copy()
    covered[y - half // 2 : y + half // 2, x - half : x + half] = cv2.resize(
        noise, (2 * half, 2 * (half // 2)), interpolation=cv2.INTER_NEAREST
    )
    (face,) = source.find(covered)
    assert face.score < clear.score
    assert face.confidence is not None
    assert clear.confidence is not None
    mouth, eyes = face.confidence[-2:].mean(), face.confidence[21:25].mean()
    assert mouth < 0.5 < eyes
    assert clear.confidence[-2:].mean() > 0.8


def test_patterns_have_no_face(source: AamSource) -> None:
    noise = np.random.default_rng(2).integers(0, 256, (60, 80, 3), np.uint8)
    for pattern in (noise, cv2.GaussianBlur(noise, (0, 0), 9), np.full((9, 9), 255, np.uint8)):
        assert source.find(pattern) == []


@pytest.mark.parametrize("kept", [0.0, 0.001, 0.5, 0.999, 1.0])
def test_a_truncated_or_damaged_file_is_refused(tmp_path: Path, kept: float) -> None:
    data = bytearray(assets.path(MODEL).read_bytes())
    if kept == 1.0:
        data[len(data) // 2] ^= 0xFF
    file = tmp_path / "damaged.npz"
    file.write_bytes(data[: int(kept * len(data))])
    with pytest.raises(ModelRefused, match=r"damaged\.npz") as refused:
        AamSource(file).find(np.zeros((40, 40, 3), np.uint8))
    assert "\n" not in str(refused.value)
