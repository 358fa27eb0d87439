"""Groups of people: who is made smaller, who starts switched off and why, and finding one's way."""

import dataclasses

import numpy as np
import pytest
from kogao_app.canvas.handles import position
from kogao_app.canvas.overlays import glyphs
from kogao_app.view_state import Handle
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QContextMenuEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from scenes import oval_face
from test_overlays import SKY, at, looks_like, pixels_of

pytestmark = pytest.mark.usefixtures("one_window")

KEYS = Qt.Key
WHITE = (255, 255, 255)
OUTLINE = glyphs.OUTLINE.getRgb()[:3]
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def unsure(start, source, photo):
    """A photo with two faces, of which the source is sure of the first one only."""
    sure = [oval_face(center=(x, 170), size=0.45) for x in (120, 350)]
    scores = (0.9, 0.43)
    source.faces = [
        dataclasses.replace(face, score=score, source="mesh")
        for face, score in zip(sure, scores, strict=True)
    ]
    return start(photo)


def test_an_unsure_face_of_a_group_starts_switched_off_and_its_row_says_why(unsure):
    assert unsure.state.off == {1}
    assert unsure.editor.document.saved
    row = unsure.panel("faces").item(1)
    assert row.checkState() == Qt.CheckState.Unchecked
    assert row.text() == "Face 2"
    assert "starts switched off: it is 43 % sure that this is a face" in row.toolTip()
    assert spoken(unsure, 1) == "Face 2, found with 43 % certainty, unsure"
    assert "off" not in unsure.panel("faces").item(0).toolTip()


def test_an_unsure_face_that_is_switched_on_comes_back_off_when_faces_are_found_again(unsure):
    unsure.panel("faces").item(1).setCheckState(Qt.CheckState.Checked)
    assert unsure.state.off == frozenset()
    unsure.key(KEYS.Key_F, CONTROL)
    unsure.settle()
    assert unsure.state.off == {1}


def spoken(driver, face):
    return driver.panel("faces").item(face).data(Qt.ItemDataRole.AccessibleTextRole)


@pytest.fixture
def alone(start, source, photo):
    """A photo of one face, of which the source isn't sure."""
    source.faces = [dataclasses.replace(oval_face(), score=0.43, source="mesh")]
    return start(photo)


def test_the_only_face_of_a_photo_starts_off_too_and_the_bar_says_why(alone):
    assert alone.state.off == {0}
    assert spoken(alone, 0) == "Face 1, found with 43 % certainty, unsure"
    assert alone.say().startswith("Face 1 is left alone: it is 43 % sure")
    alone.take_step("all the same")
    assert alone.state.off == frozenset()
    assert alone.say() == ""
    alone.key(KEYS.Key_Z, CONTROL)
    assert alone.state.off == {0}


def test_points_that_may_be_wrong_are_ringed_until_they_are_placed_by_hand(start, source, photo):
    confidence = np.where(np.arange(27) < 12, 0.2, 0.9)
    face = dataclasses.replace(oval_face(), score=0.9, source="mesh", confidence=confidence)
    source.faces = [face]
    driver = start(photo)
    row = driver.panel("faces").item(0)
    assert driver.state.off == frozenset()
    assert spoken(driver, 0) == "Face 1, found with 90 % certainty, check"
    assert "outline 1 2 3 4 5 6 7 8 9" in row.toolTip()
    assert is_ringed(driver, 4)
    assert not is_ringed(driver, 14)
    driver.drag(driver.on_screen(Handle("outline", 0, 8)), QPoint(0, 3))
    driver.settle()
    assert spoken(driver, 0) == "Face 1, found with 90 % certainty"


def is_ringed(driver, index):
    """Return whether there are pixels of the rings' colour round a landmark."""
    y, x = at(driver, *driver.state.faces[0].outline[index])
    around = pixels_of(driver)[y - 12 : y + 13, x - 12 : x + 13]
    return bool(looks_like(around, glyphs.CHECK.getRgb()[:3]).any())


@pytest.fixture
def three(start, source, photo):
    """A photo with three small faces, all of them on."""
    source.faces = [oval_face(center=(x, 170), size=0.2) for x in (80, 240, 400)]
    return start(photo)


def test_undo_and_redo_say_which_of_several_faces_changed(three):
    recipe, document = three.editor.recipe, three.editor.document
    said = three.window.status

    def back_and_forth():
        three.key(KEYS.Key_Z, CONTROL)
        undone = said.hint_text
        three.key(KEYS.Key_Z, CONTROL, SHIFT)
        assert undone.removeprefix("Undone: ") == said.hint_text.removeprefix("Done again: ")
        return undone

    recipe.set_field("percent", 5.0)
    document.commit()
    assert back_and_forth() == "Undone: Amount 4.0 → 5.0 % of D", "everybody's"
    recipe.choose(1)
    recipe.set_field("percent", 6.0)
    document.commit()
    assert back_and_forth() == "Undone: Amount 5.0 → 6.0 % of D (face 2)"
    three.panel("faces").item(2).setCheckState(Qt.CheckState.Unchecked)
    assert back_and_forth() == "Undone: Switch a face (face 3)"
    document.step(document.state.without_face(0), "Delete")
    assert back_and_forth() == "Undone: Delete (face 1)"


@pytest.fixture
def thirty(start, source, photo):
    """A photo with 30 small faces; those in the last row are hidden."""
    places = [(40 + 44 * column, 50 + 110 * row) for row in range(3) for column in range(10)]
    source.faces = [
        dataclasses.replace(
            oval_face(center=at, size=0.1),
            source="mesh",
            confidence=np.full(27, 0.4 if index >= 20 else 0.9),
        )
        for index, at in enumerate(places)
    ]
    driver = start(photo)
    driver.window.actions_by_name["overlay-legend"].setChecked(False)
    return driver


def test_no_row_of_thirty_faces_is_cut_and_the_list_scrolls_to_the_selected_one(thirty):
    rows = thirty.panel("faces").list
    assert rows.verticalScrollBar().isVisible()
    assert spoken(thirty, 29) == "Face 30, found with 100 % certainty, hidden"
    assert rows.sizeHintForColumn(0) <= rows.viewport().width()
    for face in (29, 0):
        select(thirty, face)
        assert rows.viewport().rect().contains(rows.visualItemRect(rows.item(face + 1)))


# -- who is on: keys and menus ---------------------------------------------------------------------


def select(driver, face):
    driver.click(driver.canvas.to_screen(driver.state.faces[face].eye_center).toPoint())
    assert driver.editor.view.face == face


def right_click(widget, at):
    """Send what the system sends, press and release included."""
    for event in (QTest.mousePress, QTest.mouseRelease):
        event(widget, Qt.MouseButton.RightButton, pos=at)
    place = widget.mapToGlobal(at)
    QApplication.sendEvent(widget, QContextMenuEvent(QContextMenuEvent.Reason.Mouse, at, place))


@pytest.mark.parametrize("where", ["photo", "list"])
def test_keys_say_which_faces_are_on_each_in_one_step(three, where):
    select(three, 1)
    told = []
    widget = three.panel("faces").list if where == "list" else three.canvas
    widget.setFocus()
    for key, held in (
        (KEYS.Key_I, SHIFT),
        (KEYS.Key_I, CONTROL),
        (KEYS.Key_I, Qt.KeyboardModifier.NoModifier),
        (KEYS.Key_A, CONTROL | SHIFT),
        (KEYS.Key_A, CONTROL | SHIFT),
        (KEYS.Key_A, CONTROL),
    ):
        QTest.keyClick(widget, key, held)
        told.append(set(three.state.off))
    assert told == [{0, 2}, {1}, set(), {0, 1, 2}, {0, 1, 2}, set()]
    assert three.editor.document.undo.count() == 5
    three.key(KEYS.Key_Z, CONTROL)
    assert three.state.off == {0, 1, 2}
    rows = three.panel("faces")
    assert {rows.item(face).checkState() for face in range(3)} == {Qt.CheckState.Unchecked}


def test_what_is_done_to_one_face_waits_until_one_is_selected(three):
    actions = three.window.actions_by_name
    enabled = [actions[name].isEnabled() for name in ("only-face", "switch-face", "no-face")]
    assert enabled == [False, False, True]
    select(three, 1)
    assert actions["only-face"].isEnabled()
    assert actions["switch-face"].isEnabled()
    three.key(KEYS.Key_Escape)
    assert not actions["only-face"].isEnabled()


def test_a_right_click_on_a_face_selects_it_and_offers_what_can_be_done(three):
    before, menu = three.state, three.editor.groups.menu
    view = three.canvas.viewport()
    right_click(view, three.canvas.to_screen(np.array([240.0, 4.0])).toPoint())
    assert not menu.isVisible()
    right_click(view, three.canvas.to_screen(before.faces[2].eye_center).toPoint())
    assert menu.isVisible()
    assert three.editor.view.face == 2
    assert three.state is before
    QTest.keyClick(menu, KEYS.Key_O)
    assert not menu.isVisible()
    assert three.state.off == {0, 1}


def test_a_right_click_on_a_row_and_the_menu_key_offer_the_same(three):
    rows, menu = three.panel("faces").list, three.editor.groups.menu
    right_click(rows.viewport(), rows.visualItemRect(rows.item(2)).center())
    assert menu.isVisible()
    assert three.editor.view.face == 1
    QTest.keyClick(menu, KEYS.Key_S)
    assert three.state.off == {1}
    away = three.canvas.to_screen(three.state.faces[0].eye_center).toPoint()
    place = three.canvas.mapToGlobal(away)
    event = QContextMenuEvent(QContextMenuEvent.Reason.Keyboard, away, place)
    QApplication.sendEvent(three.canvas, event)
    assert menu.isVisible()
    assert three.editor.view.face == 1, "the selected one, wherever the mouse is"
    menu.close()


# -- a close look ----------------------------------------------------------------------------------


def seen(driver, face):
    """Return how wide a face is on screen, as a share of the canvas, and whether all of it is."""
    area = driver.canvas.viewport().rect()
    at = [driver.canvas.to_screen(point).toPoint() for point in driver.state.faces[face].points]
    width = max(one.x() for one in at) - min(one.x() for one in at)
    return width / area.width(), all(area.contains(one) for one in at)


def test_a_double_click_in_the_list_looks_at_a_face_and_at_all(three):
    rows, view = three.panel("faces").list, three.canvas
    small, _ = seen(three, 2)
    for row, face in ((3, 2), (0, 0)):
        at = rows.visualItemRect(rows.item(row)).center() + QPoint(20, 0)
        QTest.mouseClick(rows.viewport(), Qt.MouseButton.LeftButton, pos=at)
        QTest.mouseDClick(rows.viewport(), Qt.MouseButton.LeftButton, pos=at)
        share, whole = seen(three, face)
        assert whole
        assert (share > 2 * small) == (row > 0)
    assert all(seen(three, face)[1] for face in range(3))
    assert view.zoom < 20


def test_a_key_looks_at_the_selected_face_and_another_at_the_whole_photo(three):
    whole = three.canvas.zoom
    select(three, 1)
    three.key(KEYS.Key_F)
    assert three.canvas.zoom > 2 * whole
    assert seen(three, 1)[1]
    three.key(KEYS.Key_0)
    assert three.canvas.zoom == pytest.approx(whole)


# -- small faces -----------------------------------------------------------------------------------


def share(driver, places, colour):
    """The share of places of the photo with a colour within a pixel of the screen."""
    there = looks_like(pixels_of(driver), colour, 40)
    rows_columns = [at(driver, x, y) for x, y in places]
    return np.mean([there[y - 1 : y + 2, x - 1 : x + 2].any() for y, x in rows_columns])


def along(face):
    """Places half way between two landmarks of the outline, the lower half of it."""
    return ((face.outline[:-1] + face.outline[1:]) / 2.0)[6:14]


def test_a_small_face_shows_a_quiet_outline_instead_of_its_marks(thirty):
    face = thirty.state.faces[12]
    assert share(thirty, along(face), OUTLINE) == 1.0
    assert share(thirty, face.eyes, SKY) == 0.0
    with_targets = pixels_of(thirty)
    hide_targets_and_centres(thirty)
    np.testing.assert_array_equal(pixels_of(thirty), with_targets)
    select(thirty, 12)
    thirty.key(KEYS.Key_F)
    assert share(thirty, face.eyes, SKY) == 1.0
    without = pixels_of(thirty)
    hide_targets_and_centres(thirty)
    assert (pixels_of(thirty) != without).any()


def hide_targets_and_centres(driver):
    """Hide them, or show them again."""
    driver.key(KEYS.Key_T)
    driver.key(KEYS.Key_C)


def test_the_selected_faces_outline_is_bright_and_no_other(three):
    first, second = (along(face) for face in three.state.faces[:2])
    assert share(three, second, WHITE) == 0.0
    select(three, 1)
    assert share(three, second, WHITE) == 1.0
    assert share(three, first, WHITE) == 0.0


def test_points_of_a_face_too_small_to_show_them_are_not_dragged(thirty):
    chin = Handle("outline", 12, 10)
    select(thirty, 12)
    assert thirty.window.status.hint_text == "Zoom to the face (F) to correct its points"
    before = thirty.state
    thirty.drag(thirty.on_screen(chin), QPoint(0, 24))
    assert thirty.state is before
    thirty.key(KEYS.Key_F)
    assert thirty.window.status.hint_text == "Drag a point to correct it"
    thirty.drag(thirty.on_screen(chin), QPoint(0, 24))
    assert position(thirty.state, chin)[1] > before.faces[12].outline[10][1]
