"""A bundle and a Flatpak have what the program needs; `.ci/bundle` makes the first and tries it."""

import ast
import json
import re
import shutil
import struct
import sys
from itertools import chain
from pathlib import Path

import PIL
import pytest
from kogao_resources.packaging import bundle, libraries
from kogao_resources.packaging.flatpak import wheels
from modules import ROOT, tree
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import kogao_core
from kogao_core.cli import declarations, desktop, licences
from kogao_core.cli.words import Group

FOLDER = ROOT / "resources" / "packaging"
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
