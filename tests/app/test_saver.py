"""A save marks the state that it wrote, and what comes after it asks again."""

import dataclasses

import numpy as np
import pytest
from kogao_app.features import files
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QMessageBox
from timeouts import held_back

from kogao_core.photo import read

pytestmark = pytest.mark.usefixtures("unkept", "one_window")
CONTROL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def disk(monkeypatch):
    """A slow disk: copies are written once it is set."""
    gate, slow = held_back(files.save_copy)
    monkeypatch.setattr(files, "save_copy", slow)
    yield gate
    gate.set()


def closing_with_a_copy(driver, path):
    driver.window.close()
    driver.answer("Save a copy")
    driver.choose_path(path)
    assert driver.editor.saver.busy


def test_undo_and_another_edit_while_a_copy_is_written_count_as_unsaved(opened, disk, tmp_path):
    opened.set("percent", 8.0)
    opened.editor.files.save(tmp_path / "copy.png")
    opened.editor.history.undo()
    opened.set("percent", 11.0)
    disk.set()
    opened.settle()
    assert "Saved copy.png" in opened.say()
    assert opened.window.isWindowModified()
    opened.window.close()
    assert opened.dialog(QMessageBox).isVisible()


def test_a_copy_on_its_way_does_not_close_while_another_is_named(opened, disk, tmp_path):
    opened.set("percent", 8.0)
    opened.editor.files.save(tmp_path / "first.png")
    opened.set("percent", 11.0)
    opened.window.close()
    opened.answer("Save a copy")
    asked = opened.dialog(QFileDialog)
    disk.set()
    opened.settle()
    assert (tmp_path / "first.png").exists()
    assert opened.window.isVisible()
    assert asked.isVisible()
    opened.choose_path(tmp_path / "second.png")
    opened.qtbot.waitUntil(lambda: not opened.window.isVisible())
    assert (tmp_path / "second.png").exists()


@pytest.mark.parametrize("closes", [True, False])
def test_an_edit_while_the_copy_before_closing_or_opening_is_written_is_asked_about(
    opened, disk, photo, other, tmp_path, closes
):
    opened.set("percent", 8.0)
    if closes:
        opened.window.close()
    else:
        opened.editor.files.open(other)
    opened.answer("Save a copy")
    opened.choose_path(tmp_path / "copy.png")
    opened.set("percent", 11.0)
    disk.set()
    opened.answer("Cancel")
    opened.settle()
    assert opened.window.isVisible()
    assert opened.editor.document.path == photo
    assert opened.state.recipe.percent == 11.0


def test_who_stays_at_the_open_photo_while_its_copy_is_written_stays(
    opened, disk, photo, other, tmp_path
):
    opened.set("percent", 8.0)
    opened.editor.strip.open(other)
    opened.answer("Save a copy")
    opened.choose_path(tmp_path / "copy.png")
    opened.editor.strip.open(photo)
    disk.set()
    opened.settle()
    assert (tmp_path / "copy.png").exists()
    assert opened.editor.document.path == photo


def test_what_a_save_on_its_way_will_write_over_is_unsaved(opened, disk, tmp_path):
    disk.set()
    opened.set("percent", 8.0)
    opened.save(tmp_path / "copy.png")
    disk.clear()
    opened.editor.files.save(tmp_path / "same.png")
    assert not opened.window.isWindowModified(), "it comes to the same"
    opened.set("percent", 9.0)
    opened.editor.files.save(tmp_path / "copy.png")
    opened.editor.history.undo()
    assert opened.window.isWindowModified()
    disk.set()
    opened.settle()
    assert opened.window.isWindowModified()
    opened.editor.history.redo()
    assert not opened.window.isWindowModified()


def test_copies_are_written_one_after_the_other(opened, disk, pixels, tmp_path):
    for name, percent in (("first.png", 8.0), ("second.png", 9.0), ("first.png", 0.0)):
        opened.set("percent", percent)
        opened.editor.files.save(tmp_path / name)
    disk.set()
    opened.settle()
    assert (read(tmp_path / "second.png").pixels != pixels).any()
    # 0 %: the last one to be asked for is the last one that was written.
    assert (read(tmp_path / "first.png").pixels == pixels).all()


def test_copies_asked_for_before_closing_are_written(opened, tmp_path):
    opened.set("percent", 8.0)
    for name in ("first.png", "second.png"):
        opened.editor.files.save(tmp_path / name)
    opened.window.close()
    opened.answer("Discard")
    assert not opened.window.isVisible()
    assert (read(tmp_path / "first.png").pixels == read(tmp_path / "second.png").pixels).all()


def test_a_copy_of_an_earlier_photo_does_not_make_the_next_one_saved(opened, disk, other, tmp_path):
    opened.set("percent", 8.0)
    opened.editor.files.save(tmp_path / "copy.png")
    opened.editor.files.read(other)
    opened.qtbot.waitUntil(lambda: opened.editor.document.path == other)
    opened.qtbot.waitUntil(lambda: not (opened.editor.files.busy or opened.editor.faces.busy))
    opened.set("percent", 8.0)
    disk.set()
    opened.settle()
    assert opened.window.isWindowModified()


def test_a_name_is_asked_for_the_photo_that_is_open(opened, other):
    opened.key(Qt.Key.Key_S, CONTROL)
    assert opened.dialog(QFileDialog).isVisible()
    opened.editor.files.read(other)
    opened.settle()
    assert not any(asked.isVisible() for asked in opened.window.findChildren(QFileDialog))


def test_another_save_or_a_cancelled_one_ends_the_wish_to_close(opened, disk, tmp_path):
    opened.set("percent", 8.0)
    closing_with_a_copy(opened, tmp_path / "copy.png")
    opened.key(Qt.Key.Key_S, CONTROL)
    opened.dialog(QFileDialog).reject()
    disk.set()
    opened.settle()
    assert not opened.window.isWindowModified()
    assert opened.window.isVisible()


def test_a_refused_save_closes_nothing_nor_does_the_next_one(opened, photo, tmp_path):
    opened.set("percent", 8.0)
    before = photo.read_bytes()
    opened.window.close()
    opened.answer("Save a copy")
    opened.choose_path(photo)
    opened.settle()
    assert "never written over" in opened.say()
    assert photo.read_bytes() == before
    assert opened.window.isVisible()
    assert opened.window.isWindowModified()
    opened.save(tmp_path / "copy.png")
    assert opened.window.isVisible()
    assert not opened.window.isWindowModified()


def test_faces_found_while_a_copy_is_written_are_no_change(searched, disk, tmp_path):
    driver, search = searched
    driver.editor.files.save(tmp_path / "copy.png")
    search.set()
    driver.qtbot.waitUntil(lambda: len(driver.state.faces) == 1)
    disk.set()
    driver.settle()
    assert not driver.window.isWindowModified()


def test_a_damaged_photo_leaves_the_search_in_the_present_one_alone(searched, tmp_path):
    driver, search = searched
    broken = tmp_path / "broken.jpg"
    broken.write_bytes(b"\xff\xd8\xff\xe0 not a photo")
    driver.editor.files.read(broken)
    driver.qtbot.waitUntil(lambda: "broken.jpg" in driver.say())
    search.set()
    driver.settle()
    assert len(driver.state.faces) == 1


def test_a_copy_holds_one_mode_and_a_project_both(opened, tmp_path):
    opened.set("percent", 8.0)
    opened.editor.manual.switch("manual")
    opened.save(tmp_path / "copy.png")
    assert opened.window.isWindowModified(), "the copy is the photo as it was"
    opened.editor.manual.switch("automatic")
    opened.save(tmp_path / "copy.png")
    assert not opened.window.isWindowModified()
    opened.editor.manual.switch("manual")
    assert not opened.window.isWindowModified(), "it was only looked at"
    protected = opened.state.protection.with_stroke([(40.0, 20.0), (40.0, 300.0)], 6.0)
    opened.editor.document.step(dataclasses.replace(opened.state, protection=protected), "Protect")
    opened.save(tmp_path / "other.png")
    assert opened.window.isWindowModified(), "no picture of the faces has the line"
    opened.editor.projects.save_to(tmp_path / "one.kogao.json")
    opened.settle()
    assert not opened.window.isWindowModified()
    opened.editor.manual.switch("automatic")
    assert not opened.window.isWindowModified()


def test_a_picture_on_screen_is_saved_without_rendering_it_again(opened, monkeypatch, tmp_path):
    opened.edit(7.0)
    with monkeypatch.context() as patched:
        patched.setattr("kogao_core.retouch.render", None)
        opened.save(tmp_path / "drawn.png")
    monkeypatch.setattr(opened.editor.live, "lent", lambda: None)
    opened.save(tmp_path / "rendered.png")
    assert (tmp_path / "drawn.png").read_bytes() == (tmp_path / "rendered.png").read_bytes()


def test_what_is_drawn_while_a_copy_waits_is_not_in_it(opened, disk, pixels, tmp_path):
    opened.set("percent", 7.0)
    opened.qtbot.waitUntil(lambda: not opened.editor.live.busy)
    expected = opened.rendered(pixels)
    opened.editor.files.save(tmp_path / "copy.png")
    for percent in (8.0, 9.0, 10.0):  # more than there are buffers
        opened.set("percent", percent)
        opened.qtbot.waitUntil(lambda: not opened.editor.live.busy)
    disk.set()
    opened.settle()
    np.testing.assert_array_equal(read(tmp_path / "copy.png").pixels, expected)
