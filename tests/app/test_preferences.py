"""What a user prefers: kept, offered in one dialog, and no harm when it is nonsense."""

import os
from unittest.mock import Mock

import pytest
from kogao_app import i18n, theme
from kogao_app.__main__ import main
from kogao_app.features import preferences, presets
from kogao_app.features.preferences import PreferencesDialog
from kogao_app.start import _application
from PySide6.QtCore import QLocale, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel

from kogao_core.base import language
from kogao_core.recipe.presets import add, listed, remove
from kogao_core.recipe.recipe import Recipe

KEYS, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier


def ask(driver):
    driver.key(KEYS.Key_Comma, CONTROL)
    return driver.dialog(PreferencesDialog)


def choose(box, words):
    box.setFocus()
    place = next(n for n in range(box.count()) if words in box.itemText(n))
    while box.currentIndex() != place:
        QTest.keyClick(box, KEYS.Key_Down if box.currentIndex() < place else KEYS.Key_Up)


def test_every_preference_has_its_row_with_a_name_and_a_letter(empty):
    dialog = ask(empty)
    assert list(dialog.form.controls) == [what.name for what in preferences.PREFERENCES]
    buddies = {label.buddy() for label in dialog.findChildren(QLabel)}
    for control in dialog.form.controls.values():
        shown = getattr(control, "line", control)
        assert shown.accessibleName()
        assert shown in buddies


def test_colours_change_at_once_and_are_there_at_the_next_start(empty, start):
    choose(ask(empty).form.controls["theme"], "Light")
    assert empty.canvas.backgroundBrush().color().name() == theme.LIGHT.canvas
    later = start()
    assert later.canvas.backgroundBrush().color().name() == theme.LIGHT.canvas
    choose(ask(later).form.controls["theme"], "Dark")
    assert later.canvas.backgroundBrush().color().name() == theme.DARK.canvas


def test_photos_start_with_the_preferred_settings_and_nothing_is_unsaved(empty, photo):
    choose(ask(empty).form.controls["recipe"], "Subtle")
    empty.open(photo)
    assert empty.state.recipe == presets.built_in()["Subtle"]
    assert not empty.editor.document.dirty


def test_a_preferred_recipe_outlives_the_preset_it_came_from(empty, storage):
    settings = storage.settings()
    add(storage.presets, "Mine", Recipe(percent=7.5))
    choose(ask(empty).form.controls["recipe"], "Mine")
    remove(storage.presets, "Mine")
    assert preferences.recipe(settings).percent == 7.5
    box = PreferencesDialog(settings, listed(storage.presets), [], empty.window).form.controls[
        "recipe"
    ]
    assert box.currentText() == "Custom, 7.5 %"


def test_dialogs_begin_in_the_preferred_folders(opened, tmp_path, photo):
    dialog = ask(opened)
    for name in ("open-folder", "save-folder"):
        (tmp_path / name).mkdir()
        QTest.keyClicks(dialog.form.controls[name].line, str(tmp_path / name))
    assert opened.editor.files.folder == tmp_path / "open-folder"
    assert opened.editor.files.suggested() == tmp_path / "save-folder" / "portrait_kogao.png"
    (tmp_path / "open-folder").rmdir()
    assert opened.editor.files.folder == photo.parent, "it may be on a drive that is away"


@pytest.mark.parametrize(
    ("name", "text"),
    [("theme", "pink"), ("scale", "3e9"), ("recipe", "["), ("recipe", '{"percent": 99}')],
)
def test_nonsense_in_the_settings_counts_as_nothing(storage, name, text):
    what = next(one for one in preferences.PREFERENCES if one.name == name)
    preferences.prefer(storage.settings(), what, text)
    assert preferences.preferred(storage.settings(), what) == ""
    assert preferences.recipe(storage.settings()) == Recipe()


@pytest.mark.parametrize(("asked", "ratio"), [(None, 1.5), ("1.25", 1.25)])
def test_the_preferred_size_holds_from_the_start_unless_the_start_says_another(
    storage, monkeypatch, asked, ratio
):
    """Qt reads it from the environment, once: when the application is made."""
    preferences.prefer(storage.settings(), preferences.SCALE, "150")
    monkeypatch.setenv("QT_SCALE_FACTOR", asked or "")
    if asked is None:
        monkeypatch.delenv("QT_SCALE_FACTOR")
    read = []

    def made(_):
        read.append(float(os.environ["QT_SCALE_FACTOR"]))
        return Mock()

    monkeypatch.setattr("kogao_app.start.QApplication", made)
    _application(storage)
    assert read == [ratio]


@pytest.mark.usefixtures("spoken")
@pytest.mark.parametrize(
    ("kept", "asked", "heard"),
    [("", [], ""), ("ja", [], "ja"), ("ja", ["--language", "en"], "en"), ("tlh", [], "")],
)
def test_the_preferred_language_is_spoken_unless_the_start_says_another(
    storage, monkeypatch, kept, asked, heard
):
    preferences.prefer(storage.settings(), preferences.LANGUAGE, kept)
    storage.settings().sync()

    def end(_, code):
        raise SystemExit(f"in {code}")

    monkeypatch.setattr("kogao_app.start.speak", end)
    with pytest.raises(SystemExit, match=f"^in {heard}$"):
        main(asked)


@pytest.mark.usefixtures("spoken")
def test_qt_and_numbers_speak_the_language_too(qapp, monkeypatch):
    installed = []
    monkeypatch.setattr(qapp, "installTranslator", installed.append)
    before = QLocale()
    try:
        i18n.speak(qapp, "ja")
        assert QLocale().language() == QLocale.Language.Japanese
    finally:
        QLocale.setDefault(before)
    assert language.language() == "ja"
    assert [one.translate("QPlatformTheme", "Cancel") for one in installed] == ["キャンセル"]
    assert i18n.tr("&File") == "ファイル(&F)"


@pytest.mark.usefixtures("spoken")
def test_every_language_is_offered_by_its_own_name(empty):
    box = ask(empty).form.controls["language"]
    offered = {box.itemData(n): box.itemText(n) for n in range(box.count())}
    assert offered == {"": "Follow system", "en": "English", "ja": "日本語"}
