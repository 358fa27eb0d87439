"""File > Import and Export landmarks: into the mode at work, and out again."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from scenes import oval_face

from kogao_core.base.geometry import Affine
from kogao_core.faces.face import Face
from kogao_core.projects import interchange

pytestmark = pytest.mark.usefixtures("one_window")

CONTROL_SHIFT = (Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier)


def shifted():
    return oval_face().mapped(Affine(np.eye(2), np.array([7.0, -4.0])))


@pytest.fixture
def points(tmp_path):
    path = tmp_path / "points.csv"
    interchange.write([shifted()], path)
    return path


def choose(driver, key, path):
    driver.key(key, *CONTROL_SHIFT)
    driver.choose_path(path)
    driver.window.activateWindow()
    driver.qtbot.waitUntil(driver.window.isActiveWindow)
    driver.settle()


def test_imported_points_take_the_place_of_those_found_in_one_undo_step(opened, points, source):
    choose(opened, Qt.Key.Key_I, points)
    np.testing.assert_allclose(opened.state.faces[0].points, shifted().points, atol=0.001)
    assert opened.editor.document.undo.undoText() == "Import landmarks"
    assert "points.csv" in opened.window.status.hint_text
    opened.key(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    np.testing.assert_array_equal(opened.state.faces[0].points, source.faces[0].points)


def test_points_come_into_the_mode_at_work(opened, points, source):
    opened.key(Qt.Key.Key_F3)
    assert not opened.state.faces
    choose(opened, Qt.Key.Key_I, points)
    assert len(opened.state.faces) == 1
    opened.key(Qt.Key.Key_F2)
    np.testing.assert_array_equal(opened.state.faces[0].points, source.faces[0].points)


def test_exported_points_are_those_on_screen_and_losses_are_said(opened, tmp_path):
    choose(opened, Qt.Key.Key_E, tmp_path / "out.json")
    (face,) = interchange.read(tmp_path / "out.json")
    np.testing.assert_array_equal(face.points, opened.state.faces[0].points)
    outline = np.repeat(face.outline, 2, axis=0)[:-1]
    interchange.write([Face(outline, face.eyes, face.mouth)], tmp_path / "many.json")
    choose(opened, Qt.Key.Key_I, tmp_path / "many.json")
    choose(opened, Qt.Key.Key_E, tmp_path / "out.pts")
    assert "resampled to 21" in opened.window.status.hint_text


def test_strange_points_and_points_of_another_photo_change_nothing(opened, tmp_path):
    before = opened.state
    (tmp_path / "text.pts").write_text("hello")
    interchange.write([oval_face(4800, 3600)], tmp_path / "far.csv")
    for name, words in (
        ("text.pts", "must be 'version: 1'"),
        ("far.csv", "another photo"),
    ):
        choose(opened, Qt.Key.Key_I, tmp_path / name)
        assert words in opened.say()
        assert opened.state is before


def test_where_nothing_can_be_written_is_said(opened, tmp_path):
    choose(opened, Qt.Key.Key_E, tmp_path / "no" / "out.pts")
    assert "can't be written" in opened.say()


def test_without_a_photo_there_is_nothing_to_do(empty):
    named = empty.window.actions_by_name
    assert not named["import-landmarks"].isEnabled()
    assert not named["export-landmarks"].isEnabled()
