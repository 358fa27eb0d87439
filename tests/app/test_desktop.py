"""What a desktop is told of the program: its icon, what it opens, what a project file is."""

import configparser
import os
import tomllib
from pathlib import Path

import pytest
from programs import ran
from PySide6.QtCore import QMimeDatabase
from systems import needs_linux

from kogao_core.cli import desktop
from kogao_core.photo import formats

pytestmark = needs_linux("files and types of a Linux desktop")
ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "resources" / "desktop"
NAME = "org.kogao.Kogao"
PROJECT = "application/vnd.kogao.project+json"


def in_a_process(code, **env):
    """Run a line in a process of its own, with the desktop's folders as they are set there."""
    env = {**os.environ, "QT_QPA_PLATFORM": "offscreen", **env}
    return ran(code, env=env).stdout.split()


@pytest.fixture
def entry():
    parser = configparser.ConfigParser(interpolation=None)
    parser.optionxform = str
    parser.read(FOLDER / f"{NAME}.desktop", encoding="utf-8")
    return parser["Desktop Entry"]


def test_the_desktop_entry_offers_every_format_that_desktops_know(entry):
    offered = set(entry["MimeType"].rstrip(";").split(";"))
    known = QMimeDatabase()
    for suffix in formats.READABLE:
        named = known.mimeTypesForFileName(f"photo{suffix}")
        assert not named or any({one.name(), *one.aliases()} & offered for one in named), (
            f"{suffix}: {[one.name() for one in named]}"
        )
    assert PROJECT in offered


def test_the_wheel_lays_every_file_where_desktops_look():
    data = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    shared = data["tool"]["hatch"]["build"]["targets"]["wheel"]["shared-data"]
    assert {Path(source).name for source in shared} == {path.name for path in FOLDER.iterdir()}
    places = {f"share/{folder}/{name}" for name, folder in desktop.PLACES.items()}
    assert set(shared.values()) == places
    for source, target in shared.items():
        assert (ROOT / source).is_file()
        assert Path(source).name == Path(target).name


def test_a_project_has_a_type_of_its_own_and_other_json_has_not(tmp_path):
    packages = tmp_path / "mime" / "packages"
    packages.mkdir(parents=True)
    (packages / f"{NAME}.xml").write_bytes((FOLDER / f"{NAME}.xml").read_bytes())
    code = (
        "from PySide6.QtCore import QMimeDatabase as D;"
        "print(*(D().mimeTypeForFile(n, D.MatchMode.MatchExtension).name() for n in "
        "('me.jpg.kogao.json', 'me.json')))"
    )
    told = in_a_process(code, XDG_DATA_HOME=str(tmp_path))
    assert told == [PROJECT, "application/json"]


@pytest.mark.usefixtures("storage")
def test_windows_have_the_icon_and_the_name_of_the_desktop_entry():
    code = (
        "from kogao_app.start import _application; from kogao_app.storage import Storage;"
        "app = _application(Storage.of_user()); icon = app.windowIcon().pixmap(48).toImage();"
        "print(app.desktopFileName(), icon.pixelColor(24, 2).name(), icon.pixelColor(0, 0).alpha())"
    )
    assert in_a_process(code) == [NAME, "#2b2b2b", "0"]
