"""A bundle and a Flatpak have what the program needs; `.ci/bundle` makes the first and tries it."""

import json
import re
from pathlib import Path

from kogao_resources.packaging.flatpak import wheels
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from kogao_core.cli import desktop, licences

FOLDER = Path(__file__).resolve().parents[2] / "resources" / "packaging"


def test_a_bundle_can_name_every_licence():
    spec = (FOLDER / "kogao.spec").read_text()
    named = set(re.findall(r'"([^"]+)"', re.search(r"^NAMED = \((.*?)^\)", spec, re.M | re.S)[1]))
    assert set(licences.DEPENDENCIES) <= named


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
