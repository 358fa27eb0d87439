"""Opening, saving, closing, and what is said when something is wrong."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from kogao_app.view_state import Handle
from kogao_app.widgets.messages import BarAction, Message
from PySide6.QtCore import QPoint, QStandardPaths, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox, QToolButton
from scenes import textured_photo
from test_window import drop

from kogao_core.cli import doctor
from kogao_core.photo import read

pytestmark = pytest.mark.usefixtures("one_window")

CONTROL = Qt.KeyboardModifier.ControlModifier


def test_a_dropped_photo_is_opened(empty, photo):
    drop(empty, photo)
    assert empty.editor.document.path == photo
    assert len(empty.state.faces) == 1
    assert empty.window.windowTitle() == "portrait.png[*] – Kogao"  # noqa: RUF001


def test_a_saved_copy_is_the_pipelines_result_bit_for_bit(empty, tmp_path):
    pixels = textured_photo(dtype=np.uint16)
    path, copy = tmp_path / "deep.png", tmp_path / "copy.png"
    assert cv2.imwrite(str(path), pixels[..., ::-1])
    empty.open(path)
    empty.change_something()
    assert empty.editor.document.dirty
    assert not empty.window.isWindowModified(), "no star: the edits are about to be saved"
    empty.key(Qt.Key.Key_S, CONTROL)
    assert empty.dialog(QFileDialog).selectedFiles() == [(tmp_path / "deep_kogao.png").as_posix()]
    empty.choose_path(copy)
    empty.qtbot.waitUntil(copy.exists)
    empty.settle()
    expected = empty.rendered(pixels)
    assert expected.dtype == np.uint16
    np.testing.assert_array_equal(read(copy).pixels, expected)
    np.testing.assert_array_equal(read(path).pixels, pixels)


def test_the_original_is_never_written_over(opened, photo):
    before = photo.read_bytes()
    opened.change_something()
    opened.save(photo)
    assert "never written over" in opened.say()
    assert photo.read_bytes() == before
    opened.take_step("Choose another name")
    assert opened.dialog(QFileDialog).acceptMode() == QFileDialog.AcceptMode.AcceptSave


def test_a_copy_that_cannot_be_written_is_said(opened, tmp_path):
    opened.save(tmp_path / "nowhere" / "copy.png")
    assert "nowhere" in opened.say()


def test_an_unreadable_file_is_said_and_the_last_photo_stays(opened, photo, tmp_path):
    broken = tmp_path / "broken.jpg"
    broken.write_bytes(b"\xff\xd8\xff\xe0 not a photo")
    opened.open(broken)
    assert "broken.jpg" in opened.say()
    assert opened.editor.document.path == photo
    opened.take_step("Open a photo")
    assert opened.dialog(QFileDialog).fileMode() == QFileDialog.FileMode.ExistingFile


def test_without_a_face_the_bar_offers_one_to_place(start, source, photo, pixels):
    source.faces = []
    driver = start(photo)
    assert "No face" in driver.say()
    np.testing.assert_array_equal(driver.shown, pixels)
    driver.take_step("Place a face")
    driver.settle()
    assert [face.source for face in driver.state.faces] == ["manual"]
    assert driver.editor.view.placing == 0
    assert driver.window.status.hint_text.startswith("Drag the frame")
    assert (driver.shown != pixels).any()
    driver.key(Qt.Key.Key_Z, CONTROL)
    driver.settle()
    assert driver.state.faces == ()
    assert driver.editor.view.placing is None
    np.testing.assert_array_equal(driver.shown, pixels)


def test_a_source_that_fails_still_lets_a_face_be_placed(start, source, photo):
    def fail(*_):
        raise RuntimeError("the networks are missing")

    source.find = fail
    driver = start(photo)
    assert driver.say() == "The networks are missing."
    driver.take_step("Place a face")
    assert len(driver.state.faces) == 1


def test_find_again_undoes_corrections_as_a_step(opened):
    opened.change_something()
    opened.editor.faces.place(opened.state.faces[0])
    assert len(opened.state.faces) == 2
    opened.key(Qt.Key.Key_F, CONTROL)
    opened.settle()
    assert len(opened.state.faces) == 1
    opened.key(Qt.Key.Key_Z, CONTROL)
    assert len(opened.state.faces) == 2


def test_the_about_box_names_paper_and_licences(empty):
    empty.key(Qt.Key.Key_F1, CONTROL, Qt.KeyboardModifier.ShiftModifier)
    box = empty.dialog(QMessageBox)
    assert "B-spline" in box.informativeText()
    assert "Apache-2.0" in box.informativeText()
    for named in ("MediaPipe", "PySide6", "Face Research Lab London Set"):
        assert named in box.detailedText()
    box.close()


def test_a_first_start_shows_the_sample_and_what_to_try(empty, photo):
    empty.editor.files.welcome()
    empty.settle()
    assert empty.editor.document.path.name == "average.jpg"
    assert empty.say().startswith("1 of 3: ")
    empty.change_something()
    assert empty.say().startswith("2 of 3: "), "the next card comes after the step"
    empty.change_something()
    assert empty.say().startswith("2 of 3: ")
    empty.drag(empty.on_screen(Handle("target", 0, 10)), QPoint(6, 9))
    assert empty.say().startswith("3 of 3: ")
    assert "Open a photo" in empty.window.bar.buttons[0].text()
    empty.key(Qt.Key.Key_Z, CONTROL)
    empty.key(Qt.Key.Key_F1, CONTROL)
    empty.settle()
    # The tour is left at any step, also of one begun anew, and comes back from the menu.
    for steps in (0, 2):
        for _ in range(steps):
            empty.take_step("Next")
        empty.key(Qt.Key.Key_Escape)
        assert empty.say() == ""
        empty.change_something()
        assert empty.say() == ""
        empty.key(Qt.Key.Key_Z, CONTROL)
        empty.key(Qt.Key.Key_F1, CONTROL)
        empty.settle()
        assert empty.say().startswith("1 of 3: ")
    empty.open(photo)
    assert empty.say() == "", "the tour stays with the sample"


def test_the_report_is_what_the_command_line_says_and_the_window_system(opened):
    opened.key(Qt.Key.Key_F1, Qt.KeyboardModifier.ShiftModifier)
    text = QApplication.clipboard().text()
    assert text.startswith(doctor.text(doctor.examine()))
    assert "offscreen" in text
    assert opened.say() == "The report is on the clipboard."


def test_a_missing_sample_is_said(empty, lack):
    lack("average.jpg")
    empty.editor.files.welcome()
    assert "average.jpg is missing; reinstall" in empty.say()
    assert empty.editor.document.photo is None


@pytest.mark.parametrize("there", [True, False])
def test_the_first_dialog_begins_in_pictures(empty, tmp_path, monkeypatch, there):
    pictures = tmp_path / "Pictures"
    if there:
        pictures.mkdir()
    monkeypatch.setattr(QStandardPaths, "writableLocation", lambda _: str(pictures))
    assert empty.editor.files.folder == (pictures if there else Path.home())


def test_dialogs_begin_in_the_folder_of_the_photo_with_room_for_their_icons(opened, photo):
    opened.key(Qt.Key.Key_O, CONTROL)
    dialog = opened.dialog(QFileDialog)
    assert dialog.directory().absolutePath() == photo.parent.as_posix()
    for button in dialog.findChildren(QToolButton):
        if button.isVisible() and not button.icon().isNull():
            assert button.width() >= button.minimumSizeHint().width()


def test_after_a_step_of_the_bar_the_photo_has_the_keys(opened):
    opened.editor.files.message.emit(Message("Something", (BarAction("Do it", lambda: None),)))
    opened.panel("recipe").percent.slider.setFocus()
    opened.window.bar.buttons[-1].setFocus()
    QTest.mouseClick(opened.window.bar.buttons[0], Qt.MouseButton.LeftButton)
    opened.settle()
    assert opened.window.focusWidget() is opened.canvas


def test_a_photo_named_from_here_is_remembered_from_anywhere(empty, photo, monkeypatch):
    monkeypatch.chdir(photo.parent)
    empty.open(Path(photo.name))
    assert empty.editor.document.path == photo


@pytest.mark.usefixtures("unkept")
def test_changes_made_while_the_next_photo_is_read_are_asked_about(opened, other):
    first = opened.editor.document.path
    opened.editor.files.open(other)
    opened.change_something()
    opened.settle()
    asked = opened.dialog(QMessageBox)
    assert opened.editor.document.path == first
    QTest.mouseClick(asked.button(QMessageBox.StandardButton.Discard), Qt.MouseButton.LeftButton)
    opened.settle()
    assert opened.editor.document.path == other
