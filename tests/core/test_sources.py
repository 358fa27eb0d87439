"""The choice of landmark sources, and models that users bring."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from damaging import models

from kogao_core.base import assets
from kogao_core.base.geometry import Affine
from kogao_core.cli.commands import program
from kogao_core.faces.landmarks import CHOICES, MeshSource, ModelRefused, facemark, source, sources
from kogao_core.faces.landmarks.aam.source import AamSource
from kogao_core.faces.landmarks.facemark import FacemarkSource, face_of


def mean_68():
    """A face in iBUG's mark-up: a jaw of 17 points, and corners where they belong."""
    points = np.zeros((68, 2))
    angle = np.linspace(np.pi, 0.0, 17)
    points[:17] = np.stack([100 + 60 * np.cos(angle), 90 + 70 * np.sin(angle)], axis=1)
    points[[36, 39, 42, 45]] = [(65, 80), (88, 80), (112, 80), (135, 80)]
    points[[48, 54]] = [(82, 130), (118, 130)]
    return points


def test_names_give_their_sources():
    assert isinstance(source("mesh"), MeshSource)
    assert isinstance(source("aam"), AamSource)
    measured = [choice.measured for choice in CHOICES if choice.measured is not None]
    assert all(0.0 < one.studio_jaw < one.wild_jaw < 10.0 for one in measured)


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice.name)
def test_help_and_the_document_name_every_source(choice):
    said = CliRunner().invoke(program, ["detect", "--help"]).output
    assert choice.name in said[said.index("--landmarks SOURCE") :].split("[")[0]
    measured = (Path(__file__).parents[2] / "docs" / "landmarks.md").read_text(encoding="utf-8")
    assert choice.measured is None or f"\n| {choice.name} | " in measured


def test_without_networks_the_aam_is_the_default(monkeypatch):
    monkeypatch.setattr(sources, "networks_are_here", lambda: False)
    assert isinstance(source(), AamSource)
    monkeypatch.setattr(sources, "networks_are_here", lambda: True)
    assert isinstance(source(), MeshSource)


MODEL = b"%YAML:1.0\n---\nn_landmarks: 68\nstages_n: 5\n"


@pytest.mark.parametrize(
    "nested",
    [
        b"a: " + b"[" * 100_000,
        b"a: " + b"{a:" * 100_000,
        b"a: " + b"[{a:" * 50_000,
        b"a:\n   " + b"- " * 100_000 + b"1\n",
        b"a: " * 100_000 + b"1\n",
        b"a:" * 100_000 + b"1\n",
        b"".join(b" " * depth + b"a:\n" for depth in range(100)),
        b"a: 1\r" + b" " * 70 + b"a: 2\n",
        b"a: ]\n",
    ],
)
def test_a_nested_model_never_reaches_opencv(tmp_path, monkeypatch, nested):
    """Its parser runs out of stack, which ends the program."""
    monkeypatch.setattr(facemark, "_is_whole", lambda _: pytest.fail("it did"))
    (tmp_path / "model.yml").write_bytes(MODEL + nested)
    with pytest.raises(ModelRefused, match="damaged"):
        source(str(tmp_path / "model.yml"))


def test_a_flat_model_reaches_opencv(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(models.lbf() + 'model_filename: "C:/models/a: [1].yaml"\n')
    text = path.read_bytes()
    assert facemark._is_flat(text)
    assert facemark._is_flat(text.replace(b"\n", b"\r\n"))
    assert facemark._is_whole(path)
    FacemarkSource(path)


@pytest.mark.parametrize(
    ("sound", "damaged"),
    [
        ("tree_0_45_0", "tree_x"),
        ("thresholds_0_67_0", "thresholds_x"),
        ("thresholds_0_3_0: [ ", "thresholds_0_3_0: [ 7, "),
        ("weights_0", "weights_x"),
        ("regressor_meanshape", "x"),
        ("tree_depth: 2", "tree_depth: 3"),
        ("tree_depth: 2", "tree_depth: 1000"),
        ("tree_n: 1", "tree_n: 2"),
        ("tree_n: 1", "tree_n: .Nan"),
        ("stages_n: 1", "stages_n: 2"),
        ("stages_n: 1", "stages_n: 1e9"),
        ("n_landmarks: 68", "n_landmarks: 29"),
        ("dt: d", "dt: f"),
        ("rows: 4\n   cols: 4", "rows: 2\n   cols: 8"),
    ],
)
def test_a_model_with_a_part_missing_is_refused(tmp_path, sound, damaged):
    """OpenCV would read what lies in memory beside it."""
    text = models.lbf()
    assert sound in text
    path = tmp_path / "model.yml"
    path.write_text(text.replace(sound, damaged, 1))
    with pytest.raises(ModelRefused, match="damaged"):
        FacemarkSource(path)


def test_a_model_too_large_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(facemark, "_MOST_BYTES", 100)
    (tmp_path / "model.yaml").write_bytes(MODEL + b"# " * 100)
    with pytest.raises(ModelRefused, match="too large"):
        source(str(tmp_path / "model.yaml"))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "can't be read"),
        (b"", "no landmark model"),
        (b"\x89PNG\r\n", "no landmark model"),
        (b"\xff" * 64, "no landmark model"),
        (b"%YAML:1.0\n---\nhello: 1\n", "damaged"),
        (b"%YAML:1.0\n---\n: : [", "damaged"),
        ((13).to_bytes(8, "little") + b"cascade_depth", "damaged"),
        ((13).to_bytes(8, "little") + b"cascade_depth" + b"\xff" * 200, "damaged"),
    ],
)
def test_files_that_are_no_models_are_refused_in_a_sentence(tmp_path, content, words):
    path = tmp_path / "model.dat"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ModelRefused, match=words) as refusal:
        source(str(path))
    assert "\n" not in str(refusal.value)
    assert "model.dat" in str(refusal.value)


def test_a_users_points_end_where_they_belong(monkeypatch, tmp_path):
    """The crop's points come back to the image, turned and scaled with the face."""
    try:
        picture_path = assets.path("samples/average.jpg")
        assets.path("models/face_detection_back.tflite")
    except assets.AssetMissing as missing:
        pytest.skip(str(missing))
    from kogao_core import photo

    class Fake:
        def fit(self, grey, boxes):
            assert grey.dtype == np.uint8
            assert grey.ndim == 2
            left, top, width, height = boxes[0]
            unit = mean_68() / 200.0 * (width, height) + (left, top)
            return True, [unit[None].astype(np.float32)]

    monkeypatch.setattr(facemark, "_loaded", lambda _: Fake())
    picture = photo.read(picture_path).pixels
    (face,) = FacemarkSource(tmp_path / "any").find(picture)
    (mesh,) = MeshSource().find(picture)
    assert face.source == "facemark"
    assert face.outline.shape == (21, 2)
    apart = np.linalg.norm(face.eye_center - mesh.eye_center)
    assert apart < 0.5 * mesh.interocular_px
    (turned,) = FacemarkSource(tmp_path / "any").find(np.ascontiguousarray(np.rot90(picture)))
    back = Affine(np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([picture.shape[1] - 1.0, 0.0]))
    assert np.linalg.norm(back(turned.points) - face.points, axis=1).mean() < 20.0


def test_a_model_that_computes_no_numbers_finds_no_face(small_portrait, tmp_path):
    from kogao_core import photo

    path = tmp_path / "model.yml"
    text = models.lbf()
    path.write_text(text)
    picture = photo.read(small_portrait).pixels
    assert len(FacemarkSource(path).find(picture)) == 1
    start = text.index("data: [") + len("data: [ ")
    path.write_text(text[:start] + ".Nan, " + text[text.index(",", start) + 1 :])
    assert FacemarkSource(path).find(picture) == []


def test_68_points_become_27():
    face = face_of(mean_68(), 0.9)
    assert face.points.shape == (27, 2)
    np.testing.assert_allclose(face.outline[[0, -1]], [(40, 90), (160, 90)])
    assert face.score == 0.9
    np.testing.assert_allclose(face.eyes[3], (135, 80))
