"""In Retouch the marks of faces step back; words are plain."""

import dataclasses

import numpy as np
import pytest
from kogao_app.canvas.overlays.listed import LISTED
from kogao_app.view_state import MARKS, Handle
from kogao_app.workspaces import RETOUCH
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QLabel
from scenes import oval_face
from systems import needs_linux_fonts
from test_view import picture

pytestmark = pytest.mark.usefixtures("one_window")

KEYS, ALT = Qt.Key, Qt.KeyboardModifier.AltModifier
CHIN = Handle("outline", 0, 10)


@pytest.fixture
def retouch(start, photo):
    return start(photo, workspace="retouch")


def marks(driver):
    return driver.editor.view.visible & MARKS


def middle(driver, face=0):
    return driver.canvas.to_screen(driver.state.faces[face].mouth_center).toPoint()


def test_what_steps_back_is_what_can_be_taken_hold_of():
    assert {one.name for one in LISTED if one.handles} | {"shape"} == MARKS


@needs_linux_fonts
def test_marks_show_under_the_cursor_and_on_a_point_in_hand(retouch):
    assert not marks(retouch)
    bare = picture(retouch)
    retouch.move(middle(retouch))
    assert marks(retouch) == {"landmarks", "shape"}, "one kind of point"
    assert (picture(retouch) != bare).any()
    retouch.press(retouch.on_screen(CHIN))
    retouch.move(QPoint(4, 4))
    assert marks(retouch), "the point is still in hand"
    retouch.key(KEYS.Key_Escape)
    retouch.release(QPoint(4, 4))
    retouch.move(QPoint(5, 5))
    assert not marks(retouch)
    retouch.settle()  # a preview of the drag may be on screen until then
    np.testing.assert_array_equal(picture(retouch), bare)


@needs_linux_fonts
def test_a_press_without_a_move_takes_the_point_that_it_meets(retouch):
    assert not marks(retouch)
    retouch.drag(retouch.on_screen(CHIN), QPoint(6, 9))
    assert retouch.editor.document.undo.undoText().startswith("outline 11, chin")


def test_brushes_and_the_divider_show_no_points_and_protecting_shows_the_mask(retouch):
    stroke = retouch.state.protection.with_stroke([(40.0, 20.0), (40.0, 300.0)], 6.0)
    retouch.editor.document.step(dataclasses.replace(retouch.state, protection=stroke), "Protect")
    retouch.settle()
    for name in ("tool-push", "tool-restore", "tool-brush", "tool-eraser", "compare-wipe"):
        retouch.window.actions_by_name[name].trigger()
        retouch.move(middle(retouch))
        retouch.move(middle(retouch) + QPoint(30, 0))
        assert not marks(retouch), name
        if name != "compare-wipe":
            retouch.window.actions_by_name["tool-points"].trigger()
    retouch.window.actions_by_name["compare-wipe"].trigger()
    retouch.window.actions_by_name["hide-overlays"].trigger()
    bare = picture(retouch)
    retouch.window.actions_by_name["tool-brush"].trigger()
    retouch.move(QPoint(5, 5))
    assert (picture(retouch) != bare).any(axis=1).sum() > 100, "the mask is drawn"
    retouch.window.actions_by_name["tool-points"].trigger()
    retouch.window.actions_by_name["hide-overlays"].trigger()


def test_marks_go_while_a_setting_moves(retouch):
    retouch.move(middle(retouch))
    slider = retouch.panel("recipe").percent.slider
    retouch.press_key(slider, KEYS.Key_Right)
    assert not marks(retouch)
    retouch.qtbot.waitUntil(lambda: bool(marks(retouch)))


def test_a_point_is_found_by_keys_alone(retouch):
    retouch.key(KEYS.Key_Period, Qt.KeyboardModifier.ControlModifier)
    assert marks(retouch)
    retouch.move(QPoint(5, 5))
    assert not marks(retouch)


def test_only_the_face_that_is_pointed_at_shows_its_marks(start, source, photo):
    source.faces = [oval_face(center=(x, 170), size=0.45) for x in (120, 350)]
    driver = start(photo, workspace="retouch")
    driver.canvas.zoom_to(2.5)
    driver.move(middle(driver, 1))
    assert driver.editor.view.pointed == {1}
    driver.editor.recipe.choose(0)
    driver.move(middle(driver, 1) + QPoint(1, 1))
    assert driver.editor.view.pointed == {0, 1}, "and the selected one's"


def test_elsewhere_and_by_hand_marks_stay(retouch):
    retouch.editor.manual.switch("manual")
    assert marks(retouch)
    retouch.editor.manual.switch("automatic")
    assert not marks(retouch)
    for key in (KEYS.Key_2, KEYS.Key_3):
        retouch.key(key, ALT)
        assert marks(retouch)


def test_the_first_start_shows_what_was_found_until_another_photo(start, photo):
    driver = start(workspace="retouch")
    driver.editor.files.welcome()
    driver.settle()
    assert driver.editor.view.visible == set(RETOUCH.overlays)
    driver.key(KEYS.Key_O)
    assert not driver.editor.view.visible
    driver.key(KEYS.Key_O)
    driver.open(photo)
    assert not marks(driver)


def test_before_and_after_show_the_same_marks(opened):
    opened.press_key(opened.panel("recipe").percent.slider, KEYS.Key_Home)
    opened.settle()
    after = picture(opened)
    opened.window.original_wanted.emit(True)
    np.testing.assert_array_equal(picture(opened), after, "nothing moves: one picture with marks")


def words_of(widget):
    return " ".join(label.text() for label in widget.findChildren(QLabel) if label.isVisible())


def test_retouch_speaks_plainly_and_inspect_exactly(retouch):
    panel = retouch.panel("recipe")
    plain = words_of(panel)
    assert "Am&ount" in plain
    assert "fewer than half of viewers" in plain
    assert panel.percent.field.text() == "4.0 %"
    for science in ("of D", "J ≥", "residual", "R 1", "px"):
        assert science not in plain
    assert "% of D, the face's radius" in panel.percent.slider.toolTip()
    retouch.key(KEYS.Key_3, ALT)
    exact = words_of(panel)
    for science in ("warp distance", "J ≥", "residual"):
        assert science in exact
    assert panel.percent.field.text() == "4.0 % of D"


def test_what_goes_wrong_is_said_plainly_too(retouch):
    panel = retouch.panel("recipe")
    retouch.press_key(panel.percent.slider, KEYS.Key_End)
    retouch.settle()
    assert "clearly different" in panel.gauge.seen.text()
    retouch.show("scope", "face")
    assert panel.gauge.text.text() == "⚠ At least 70 % of answers: unnatural"
    panel.more.button.setChecked(True)
    retouch.press_key(panel.lattice.slider, KEYS.Key_Home)
    retouch.settle()
    assert panel.one_to_one.text().startswith("⚠")
    assert "J" not in panel.one_to_one.text()
