"""Before and after: wipe, side by side, difference, loupe, each by its key and its button."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QToolBar, QToolButton
from test_overlays import hide_marks, pixels_of

pytestmark = pytest.mark.usefixtures("one_window")

KEYS = Qt.Key
NONE = Qt.KeyboardModifier.NoModifier


@pytest.fixture
def bare(opened):
    """A photo with nothing drawn over it, at a strong warp."""
    hide_marks(opened)
    slider = opened.panel("recipe").percent.slider
    opened.press_key(slider, KEYS.Key_End)
    opened.settle()
    return opened


def original_of(driver):
    QTest.keyPress(driver.window, KEYS.Key_Backslash)
    pixels = pixels_of(driver)
    QTest.keyRelease(driver.window, KEYS.Key_Backslash)
    return pixels


def test_any_release_and_a_dialog_end_the_original(bare):
    """With AltGr, the key is another one once it comes up."""
    view, window = bare.editor.view, bare.window
    QTest.keyPress(window, KEYS.Key_Backslash)
    assert view.original
    QTest.keyRelease(window, KEYS.Key_ssharp)
    assert not view.original
    for key, is_held in (
        (KEYS.Key_Backslash, lambda: view.original),
        (KEYS.Key_Space, lambda: bare.canvas._space),
    ):
        QTest.keyPress(window, key)
        assert is_held()
        window.actions_by_name["preferences"].trigger()
        assert not is_held()
        bare.dialog(QDialog).close()


def knob(driver) -> QPoint:
    area = driver.canvas.viewport().rect()
    return QPoint(round(driver.editor.view.wipe * area.width()), area.center().y())


def test_a_wipe_shows_before_on_the_left_and_after_on_the_right(bare):
    after, before = pixels_of(bare), original_of(bare)
    assert (after != before).any()
    bare.key(KEYS.Key_W)
    both, x = pixels_of(bare), knob(bare).x()
    # Below the names, above the knob, and beside the line.
    rows = slice(40, knob(bare).y() - 20)
    np.testing.assert_array_equal(both[rows, : x - 3], before[rows, : x - 3])
    np.testing.assert_array_equal(both[rows, x + 3 :], after[rows, x + 3 :])
    bare.key(KEYS.Key_W)
    np.testing.assert_array_equal(pixels_of(bare), after)


def test_the_divider_is_dragged_and_moved_by_keys(bare):
    bare.key(KEYS.Key_W)
    bare.drag(knob(bare), QPoint(-120, 10))
    width = bare.canvas.viewport().width()
    assert bare.editor.view.wipe == pytest.approx(0.5 - 120 / width, abs=1 / width)
    share = bare.editor.view.wipe
    bare.key(KEYS.Key_Period)
    bare.key(KEYS.Key_Period)
    bare.key(KEYS.Key_Comma)
    assert bare.editor.view.wipe == pytest.approx(share + 1 / 40)
    bare.drag(knob(bare) + QPoint(0, 90), QPoint(-4000, 0))
    assert bare.editor.view.wipe == 0.0
    assert bare.editor.document.undo.count() == 1, "comparing changes nothing"


def test_side_by_side_moves_and_zooms_together(bare):
    beside, canvas = bare.window.original, bare.canvas
    assert not beside.isVisible()
    bare.key(KEYS.Key_Y)
    bare.qtbot.waitUntil(lambda: beside.isVisible() and beside.width() > 100)
    assert abs(beside.width() - canvas.width()) <= 1

    def together():
        assert beside.zoom == pytest.approx(canvas.zoom)
        middles = [
            v.to_photo(QPointF(v.viewport().rect().toRectF().center())) for v in (beside, canvas)
        ]
        np.testing.assert_allclose(*middles, atol=1e-6)

    together()
    canvas.zoom_to(1.7, QPointF(60, 80))
    together()
    bare.drag(QPoint(40, 40), QPoint(33, -21))
    together()
    zoom = canvas.zoom
    bare.turn_wheel(beside.viewport(), 1, QPoint(90, 120))
    assert canvas.zoom == pytest.approx(1.25 * zoom)
    together()
    place = canvas.to_photo(QPointF(50, 50))
    QTest.mousePress(beside.viewport(), Qt.MouseButton.LeftButton, NONE, QPoint(100, 100))
    QTest.mouseMove(beside.viewport(), QPoint(130, 90))
    QTest.mouseRelease(beside.viewport(), Qt.MouseButton.LeftButton, NONE, QPoint(130, 90))
    np.testing.assert_allclose(canvas.to_photo(QPointF(80, 40)), place, atol=1e-6)
    together()
    bare.window.resize(1000, 700)
    QApplication.processEvents()
    together()


def test_the_view_beside_shows_the_photo_as_it_was(bare):
    bare.key(KEYS.Key_Y)
    beside = bare.window.original
    bare.qtbot.waitUntil(lambda: beside.isVisible() and beside.width() > 100)
    # Where one is a pixel wider, its middle lies half a pixel beside the other's.
    odd = abs(beside.width() - bare.canvas.width())
    bare.window.resize(bare.window.width() + odd, bare.window.height())
    bare.qtbot.waitUntil(lambda: beside.width() == bare.canvas.width())
    bare.key(KEYS.Key_0)
    original = original_of(bare)
    image = beside.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    seen = rows[:, : 3 * image.width()].reshape(image.height(), -1, 3).astype(int)
    width = min(seen.shape[1], original.shape[1])
    rows = slice(60, None)
    assert np.abs(seen[rows, :width] - original[rows, :width]).max() <= 1


def test_the_difference_is_black_outside_and_amplified_inside(bare, pixels):
    bare.key(KEYS.Key_1)
    left, top = bare.align().toTuple()
    bare.key(KEYS.Key_X)
    seen = pixels_of(bare)[top + 60 : top + 360, left : left + 480]
    expected = cv2.convertScaleAbs(cv2.absdiff(bare.shown, pixels), alpha=8)
    np.testing.assert_array_equal(seen, expected[60:360])
    assert expected.any()


def test_the_difference_follows_a_gesture(bare):
    bare.key(KEYS.Key_X)
    resting = pixels_of(bare)
    slider = bare.panel("recipe").percent.slider
    QTest.keyPress(slider, KEYS.Key_Home)
    bare.qtbot.waitUntil(lambda: bare.editor.view.frame.rendering.recipe.percent == 0.0)
    moving = pixels_of(bare)
    QTest.keyRelease(slider, KEYS.Key_Home)
    assert moving[60:].max() <= resting[60:].max()
    photo = moving[60 : moving.shape[0] - 20, 20:-20]
    assert set(np.unique(photo)) <= {0, 43}, "nothing moves: only black, and the canvas's grey"


def test_the_loupe_magnifies_before_and_after_under_the_cursor(bare):
    face = bare.state.faces[0].outline[16]
    at = bare.canvas.to_screen(face).toPoint()
    plain = pixels_of(bare)
    bare.key(KEYS.Key_Z)
    bare.move(at)
    shown = pixels_of(bare)
    changed = np.argwhere((shown != plain).any(axis=-1))
    assert np.abs(changed - (at.y(), at.x())).max() <= 100
    # The same place, zoomed in for comparison.
    bare.key(KEYS.Key_Z)
    bare.canvas.zoom_to(4 * bare.canvas.zoom, QPointF(at))
    after, before = pixels_of(bare), original_of(bare)
    y, x = at.y(), at.x()
    rows = slice(y - 40, y + 40)
    for columns, large in ((slice(x - 40, x - 4), before), (slice(x + 4, x + 40), after)):
        assert np.abs(shown[rows, columns] - large[rows, columns]).mean() < 6
    bare.move(at + QPoint(5, 5))


def test_buttons_keys_and_the_held_original_agree(bare):
    after, before = pixels_of(bare), original_of(bare)
    buttons = {
        a.iconText(): bare.window.findChild(QToolBar).widgetForAction(a)
        for a in bare.window.actions_by_name.values()
    }
    for words, name in (("Wipe", "wipe"), ("Side by side", "side"), ("Difference", "difference")):
        QTest.mouseClick(buttons[words], Qt.MouseButton.LeftButton)
        assert bare.editor.view.compare == name
    bare.key(KEYS.Key_X)
    assert bare.editor.view.compare == "off"
    assert not bare.window.original.isVisible()
    bare.qtbot.waitUntil(lambda: bare.canvas.width() > 500)
    np.testing.assert_array_equal(pixels_of(bare), after)
    bare.key(KEYS.Key_W)
    np.testing.assert_array_equal(original_of(bare), before)
    bare.key(KEYS.Key_W)
    bar = bare.window.findChild(QToolBar)
    (hold,) = [b for b in bar.findChildren(QToolButton) if b.text() == "Hold: before"]
    QTest.mousePress(hold, Qt.MouseButton.LeftButton)
    np.testing.assert_array_equal(pixels_of(bare), before)
    QTest.mouseRelease(hold, Qt.MouseButton.LeftButton)
    np.testing.assert_array_equal(pixels_of(bare), after)
