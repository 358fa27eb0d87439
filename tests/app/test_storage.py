"""The editor's settings, whoever has written them."""

import re
import sys
from pathlib import Path

import pytest
from kogao_app.features import preferences, recent
from kogao_app.features.disclosure import Told
from kogao_app.storage import Storage
from PySide6.QtCore import QByteArray, QSettings
from systems import TOO_LONG

from kogao_core.base import installed
from kogao_core.photo import originals
from kogao_core.recipe import presets

# The system tells nothing of it, as of a folder closed to us or a drive that is away.
UNREACHABLE = Path("x" * 300)


class Trap:
    """Makes a file when somebody reads it back with pickle."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "kogao.ini"


@pytest.fixture
def trapped(tmp_path, file):
    """Settings that Qt has written, with a Python object; and the file that shows it was read."""
    sprung = tmp_path / "sprung"
    written = QSettings(str(file), QSettings.Format.IniFormat)
    written.setValue("window/docks", Trap(sprung))
    written.sync()
    assert b"@Variant(" in file.read_bytes()
    return sprung


@pytest.mark.parametrize(
    ("plain", "disguised"),
    [
        ("@Variant", "@Variant"),
        ("@Variant", r"\x40Variant"),
        ("@Variant", r"\100Variant"),
        ("@Variant", '@Var""iant'),
        ("@Variant", "@Var\\\niant"),
        ("@Variant", r"@Var\diant"),
        ("@Variant(", "a, @Variant("),
    ],
)
def test_python_objects_in_settings_are_never_read(tmp_path, file, trapped, plain, disguised):
    file.write_text(file.read_text("latin-1").replace(plain, disguised), "latin-1")
    settings = Storage.in_folder(tmp_path).settings()
    for key in settings.allKeys():
        settings.value(key)
    assert settings.value("window/docks") is None
    assert not trapped.exists()
    assert (tmp_path / "kogao.ini.damaged").exists()


def test_settings_that_are_cut_off_give_way_to_the_first_ones(tmp_path, file, trapped):
    text = file.read_text("latin-1")
    end = text.index("\\0", text.index("PyObject")) + 2
    file.write_text(text[:end] + ")\n", "latin-1")
    assert Storage.in_folder(tmp_path).settings().value("window/docks") is None
    assert not trapped.exists()


def test_our_own_settings_are_kept(tmp_path):
    storage = Storage.in_folder(tmp_path)
    kept = storage.settings()
    recent.add(kept, tmp_path / "@a,b;c=.png")
    Told(record=True, labelled=True, label="@ByteArray(x").remember(kept)
    kept.setValue("window/docks", QByteArray(bytes(range(256))))
    kept.sync()
    del kept
    again = storage.settings()
    assert recent.paths(again) == [tmp_path / "@a,b;c=.png"]
    assert Told.remembered(again).disclosure.label == "@ByteArray(x"
    assert again.value("window/docks") == QByteArray(bytes(range(256)))
    assert not (tmp_path / "kogao.ini.damaged").exists()


def test_what_is_out_of_reach_is_not_there(tmp_path):
    settings = Storage.in_folder(tmp_path).settings()
    recent.add(settings, UNREACHABLE / "a.png")
    preferences.prefer(settings, preferences.OPEN_FOLDER, str(UNREACHABLE))
    assert recent.there(settings) == []
    assert preferences.folder(settings, preferences.OPEN_FOLDER) is None


@pytest.mark.parametrize("storage", [Storage.in_folder(UNREACHABLE)])
def test_an_editor_works_without_its_folders(start, photo):
    driver = start(photo)
    driver.change_something()
    driver.qtbot.waitUntil(lambda: "kept for a crash" in driver.say())
    said = rf"Unsaved changes can't be kept for a crash \({TOO_LONG}\)\."
    assert re.fullmatch(said, driver.say())
    driver.editor.close()
    assert not driver.window.isVisible()


@pytest.mark.parametrize("system", ["linux", "win32"])
def test_window_and_command_line_ask_one_place(monkeypatch, tmp_path, system):
    for name in ("XDG_DATA_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path / name))
    monkeypatch.setattr(sys, "platform", system)
    storage = Storage.of_user()
    assert storage.data == installed.data_folder()
    assert storage.data.is_relative_to(tmp_path)
    assert (storage.config == storage.data) == (system == "win32")


def test_originals_and_presets_lie_where_the_command_line_looks():
    assert Storage.of_user().originals == originals.Originals.of_user().folder
    assert Storage.of_user().presets == presets.user_folder()
