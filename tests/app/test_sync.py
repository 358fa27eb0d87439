"""Sync settings to selected photos: undo in each, groups of settings, a preview; the strip."""

import dataclasses
import threading

import pytest
from kogao_app.features import files, sync
from kogao_app.features.strip.film import _WARNING as WARNING
from kogao_app.features.sync import groups
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from scenes import oval_face
from test_own_results import click_on
from test_own_results import strip as strip
from timeouts import LONGEST_S, held_back

from kogao_core.projects import edits
from kogao_core.projects.edits import sidecar_of
from kogao_core.recipe.recipe import SETTINGS

pytestmark = pytest.mark.usefixtures("one_window")


def test_sync_is_one_undo_step_in_each_photo_and_counts_those_with_edits(strip):
    for row, percent in ((2, 3.0), (0, 8.0)):
        click_on(strip, row)
        strip.edit(percent)
    click_on(strip, 2, Qt.KeyboardModifier.ControlModifier)
    click_on(strip, 3, Qt.KeyboardModifier.ControlModifier)
    said = []
    strip.editor.sync.did.connect(said.append)
    strip.editor.sync.start()
    strip.settle()
    assert said == ["Settings applied to 2 photos (1 had edits); undo works in each"]
    for row, before in ((2, [3.0, 4.0]), (3, [4.0])):
        click_on(strip, row)
        assert strip.state.recipe.percent == 8.0
        for percent in before:
            strip.editor.history.undo()
            assert strip.state.recipe.percent == percent
        assert not strip.editor.document.undo.canUndo()
        assert len(strip.state.faces) == 1


def test_only_the_groups_of_settings_that_are_checked_are_copied(strip):
    state = strip.editor.document.state.with_choices(None, percent=8.0, jaw_width=-4.0)
    strip.editor.document.step(state, "Settings")
    click_on(strip, 2, Qt.KeyboardModifier.ControlModifier)
    strip.editor.sync._groups["amount"].setChecked(False)
    strip.editor.sync.start()
    strip.settle()
    click_on(strip, 2)
    assert (strip.state.recipe.percent, strip.state.recipe.jaw_width) == (4.0, -4.0)
    strip.editor.sync._groups["amount"].setChecked(True)


def test_every_field_of_a_recipe_is_in_one_group_of_settings():
    names = [name for _, group in groups().values() for name in group]
    assert sorted(names) == sorted(SETTINGS)


def test_selected_thumbnails_follow_the_settings_before_they_are_applied(strip, source):
    film, icons = strip.editor.strip.film, {}

    def changed():
        now = {film.path(row).stem: film.item(row).icon().cacheKey() for row in range(film.count())}
        before = dict(icons)
        icons.update(now)
        return {name for name in now if now[name] != before.get(name)}

    def warned():
        items = map(film.item, range(film.count()))
        return {item.text() for item in items if item.data(WARNING)}

    source.faces = [dataclasses.replace(oval_face(), score=0.5, source="mesh")]
    click_on(strip, 2, Qt.KeyboardModifier.ControlModifier)
    strip.settle()
    changed()
    strip.edit(8.0)
    assert changed() - {"a"} == {"b"}, "only selected photos are drawn again"
    assert warned() == {"b.png"}, "a doubtful face is marked by a ring"
    folder = strip.editor.document.path.parent
    assert not sidecar_of(folder / "b.png").exists(), "nothing is applied yet"
    click_on(strip, 2)
    strip.settle()
    assert "b" in changed(), "the thumbnail shows the saved edits again"
    assert not warned()
    assert strip.editor.document.path.stem == "b"
    assert not strip.editor.strip.panel.sync.isVisible(), "the open photo isn't one of them"


def test_the_next_photo_is_counted_from_the_open_one(strip):
    film = strip.editor.strip.film
    at = film.visualItemRect(film.item(3)).center()
    QTest.mouseClick(film.viewport(), Qt.MouseButton.RightButton, pos=at)
    film.step(1)
    strip.settle()
    assert strip.editor.document.path.name == "b.png"


@pytest.mark.parametrize("late_step", ["synced", "record", "open_photo"])
def test_a_photo_that_is_opened_during_its_sync_gets_the_settings(strip, monkeypatch, late_step):
    """The photo is shown before the sync writes, while it writes, or read before, shown after."""
    document = strip.editor.document
    strip.edit(8.0)
    click_on(strip, 2, Qt.KeyboardModifier.ControlModifier)
    other, read = document.path.with_name("b.png"), threading.Event()
    if late_step == "open_photo":
        gate, late = held_back(lambda opened: opened)
        real = files.open_photo

        def opened(*given):
            made = real(*given)
            read.set()
            return late(made)

        monkeypatch.setattr(files, "open_photo", opened)
        strip.editor.files.open(other)
        assert read.wait(LONGEST_S)
        strip.editor.sync.start()
        strip.qtbot.waitUntil(lambda: not strip.editor.sync.busy)
    else:
        # Between the project and the record with the undo steps, or before both.
        module, name = (sync, "synced") if late_step == "synced" else (edits.lzma, "compress")
        gate, late = held_back(getattr(module, name))
        monkeypatch.setattr(module, name, late)
        strip.editor.sync.start()
        if late_step == "record":
            strip.qtbot.waitUntil(sidecar_of(other).exists)
        strip.editor.files.open(other)
        for _ in range(30):
            if document.path != other:
                strip.qtbot.wait(10)
    gate.set()
    strip.settle()
    assert document.path == other
    assert strip.state.recipe.percent == 8.0
    strip.edit(9.0)
    assert not strip.say()
    click_on(strip, 0)
    click_on(strip, 2)
    for percent in (9.0, 8.0, 4.0):
        assert strip.state.recipe.percent == percent
        strip.editor.history.undo()
