"""Painting what must not move: brush, line, eraser, with mouse and keys on the window."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QEvent, QPoint, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QToolButton
from test_files import CONTROL
from test_view import picture

pytestmark = pytest.mark.usefixtures("one_window")

KEYS = Qt.Key
SHIFT = Qt.KeyboardModifier.ShiftModifier


def strokes(driver):
    return driver.state.protection.strokes


def beside_the_cheek(driver) -> QPoint:
    """A place on the moving skin, right of the face's middle outline."""
    return driver.canvas.to_screen(driver.state.faces[0].outline[16] + (6.0, 0.0)).toPoint()


DOWN = QPoint(0, 40)


def paint(driver, key=KEYS.Key_B, by=DOWN):
    driver.key(key)
    driver.drag(beside_the_cheek(driver), by)
    driver.settle()


def test_a_brush_stroke_protects_and_is_one_undo_step(opened, pixels):
    free = opened.shown.copy()
    before = opened.state
    paint(opened)
    (stroke,) = strokes(opened)
    assert stroke.radius_px == opened.editor.view.brush.radius_px
    start = opened.canvas.to_photo(beside_the_cheek(opened).toPointF())
    np.testing.assert_allclose(stroke.points_px[0], start, atol=1e-3)
    assert (opened.shown != free).any()
    np.testing.assert_array_equal(opened.shown, opened.rendered(pixels))
    moved = np.hypot(*opened.editor.view.frame.rendering.field.at(stroke.points_px).T)
    assert moved.max() == 0.0
    (drawn,), (listed,) = opened.editor.view.frame.rendering.pairs, opened.state.pairs
    np.testing.assert_allclose(listed.target_px, drawn.target_px, atol=1e-6)
    assert "points move less" in opened.panel("protect").reduced.text()
    assert opened.editor.document.undo.count() == 1
    assert opened.editor.document.undo.undoText() == "Protect"
    opened.key(KEYS.Key_Z, CONTROL)
    opened.settle()
    assert opened.state is before
    np.testing.assert_array_equal(opened.shown, free)


def test_points_are_not_dragged_while_a_brush_is_in_hand(opened):
    face = opened.state.faces[0]
    opened.key(KEYS.Key_B)
    opened.drag(opened.canvas.to_screen(face.outline[10]).toPoint(), QPoint(15, 10))
    assert opened.state.faces[0] is face
    assert len(strokes(opened)) == 1
    opened.key(KEYS.Key_A)
    opened.drag(opened.canvas.to_screen(face.outline[10]).toPoint(), QPoint(15, 10))
    assert opened.state.faces[0] is not face
    assert len(strokes(opened)) == 1


def test_a_line_is_straight_and_with_shift_upright(opened):
    opened.key(KEYS.Key_N)
    at = beside_the_cheek(opened)
    opened.press(at)
    for by in (QPoint(3, 20), QPoint(9, 60)):
        opened.move(at + by)
    opened.release(at + QPoint(9, 60))
    (slanted,) = strokes(opened)
    assert slanted.points_px.shape == (2, 2)
    assert slanted.points_px[0, 0] != slanted.points_px[1, 0]
    at, viewport = at + QPoint(50, 0), opened.canvas.viewport()
    QTest.mousePress(viewport, Qt.MouseButton.LeftButton, SHIFT, at)
    to, left = (at + QPoint(9, 60)).toPointF(), Qt.MouseButton.LeftButton
    around = viewport.mapToGlobal(to)
    moved = QMouseEvent(QEvent.Type.MouseMove, to, around, left, left, SHIFT)
    QApplication.sendEvent(viewport, moved)
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, SHIFT, at)
    upright = strokes(opened)[1]
    assert upright.points_px[0, 0] == upright.points_px[1, 0]


def test_a_line_is_moved_turned_and_narrowed_later_each_as_one_step(opened):
    paint(opened, KEYS.Key_N)
    (first,) = strokes(opened)
    start, canvas = beside_the_cheek(opened), opened.canvas
    for at, by, ends in ((start + DOWN / 2, QPoint(15, 5), [0, 1]),
                         (start + QPoint(15, 5), QPoint(30, -10), [0])):  # fmt: skip
        (before,) = strokes(opened)
        opened.drag(at, by)
        (after,) = strokes(opened)
        moved = after.points_px - before.points_px
        np.testing.assert_allclose(moved[ends], [np.array(by.toTuple()) / canvas.zoom] * len(ends))
        assert np.delete(moved, ends, axis=0).sum() == 0.0
        assert opened.editor.document.undo.undoText() == "Move a line"
    slider = opened.panel("protect").size_px.slider
    for change in (
        lambda: opened.key(KEYS.Key_BracketLeft),
        lambda: opened.press_key(slider, KEYS.Key_Left),
    ):
        (before,), count = strokes(opened), opened.editor.document.undo.count()
        change()
        opened.settle()
        (after,) = strokes(opened)
        assert after.radius_px < before.radius_px
        assert after.radius_px == opened.editor.view.brush.radius_px
        assert opened.editor.document.undo.undoText() == "Line width"
        assert opened.editor.document.undo.count() == count + 1
    opened.key(KEYS.Key_B)
    opened.key(KEYS.Key_BracketRight)
    assert strokes(opened) == (after,), "the brush's size is its own"
    assert after.radius_px < first.radius_px


def test_a_click_of_the_line_tool_leaves_nothing(opened):
    opened.key(KEYS.Key_N)
    opened.click(beside_the_cheek(opened))
    assert not strokes(opened)
    assert opened.editor.document.undo.count() == 0


def test_the_eraser_cuts_a_stroke_in_two_and_undo_mends_it(opened):
    paint(opened, KEYS.Key_N, QPoint(0, 90))
    whole = strokes(opened)
    opened.key(KEYS.Key_E)
    middle = beside_the_cheek(opened) + QPoint(0, 45)
    opened.click(middle)
    first, second = strokes(opened)
    at = opened.canvas.to_photo(middle.toPointF())
    for part in (first, second):
        apart = np.linalg.norm(part.points_px - at, axis=1).min()
        assert apart > opened.editor.view.brush.radius_px - 0.5
    assert opened.editor.document.undo.undoText() == "Erase protection"
    opened.key(KEYS.Key_Z, CONTROL)
    assert strokes(opened) == whole


def test_escape_gives_a_stroke_up(opened):
    opened.key(KEYS.Key_B)
    at = beside_the_cheek(opened)
    opened.press(at)
    opened.move(at + QPoint(0, 30))
    assert strokes(opened)
    opened.key(KEYS.Key_Escape)
    opened.move(at + QPoint(0, 60))
    opened.release(at + QPoint(0, 60))
    assert not strokes(opened)
    assert opened.editor.document.undo.count() == 0


def test_brackets_and_the_slider_size_the_brush(opened):
    first = opened.editor.view.brush.radius_px
    for _ in range(4):
        opened.key(KEYS.Key_BracketRight)
    assert opened.editor.view.brush.radius_px == pytest.approx(2 * first)
    opened.key(KEYS.Key_BracketLeft)
    assert opened.editor.view.brush.radius_px == pytest.approx(2 * first / 2**0.25)
    slider = opened.panel("protect").size_px.slider
    opened.press_key(slider, KEYS.Key_End)
    assert opened.editor.view.brush.radius_px == 512.0
    QTest.mouseDClick(slider, Qt.MouseButton.LeftButton)
    assert opened.editor.view.brush.radius_px == pytest.approx(first)
    assert opened.editor.document.undo.count() == 0


def test_strokes_and_the_brushs_ring_are_drawn(opened):
    bare = picture(opened)
    paint(opened)
    opened.move(QPoint(20, 20))
    drawn = picture(opened)
    opened.move(QPoint(60, 60))
    assert (picture(opened) != drawn).any()
    opened.key(KEYS.Key_A)
    with_hatch = picture(opened)
    assert (with_hatch != bare).any()
    opened.key(KEYS.Key_P)
    assert (picture(opened) != with_hatch).any()


@pytest.mark.parametrize(
    ("panel", "names"), [("protect", ("brush", "line", "eraser")), ("push", ("push", "restore"))]
)
def test_buttons_menus_and_keys_agree(opened, panel, names):
    opened.key(KEYS.Key_B)
    buttons = [b for b in opened.panel(panel).findChildren(QToolButton) if b.defaultAction()]
    tools = {name: opened.window.actions_by_name[f"tool-{name}"] for name in names}
    assert [b.accessibleName() for b in buttons] == [one.text() for one in tools.values()]
    for name, button in zip(tools, buttons, strict=True):
        button.click()
        assert opened.editor.view.brush.tool == name
        assert [b.isChecked() for b in buttons] == [b is button for b in buttons]
    for action, button in zip(tools.values(), buttons, strict=True):
        keys = action.shortcut()[0]
        opened.key(keys.key(), keys.keyboardModifiers())
        assert button.isChecked()


def test_remove_all_is_one_step(opened):
    paint(opened)
    paint(opened, by=QPoint(-30, 0))
    assert "2" in opened.panel("protect").count.text()
    QTest.mouseClick(opened.panel("protect").clear, Qt.MouseButton.LeftButton)
    assert not strokes(opened)
    assert not opened.panel("protect").clear.isEnabled()
    opened.key(KEYS.Key_Z, CONTROL)
    assert len(strokes(opened)) == 2


def test_a_mask_protects_its_white_pixels_and_is_one_undo_step(opened, pixels, tmp_path):
    free, grey = opened.shown.copy(), np.zeros(pixels.shape[:2], np.uint8)
    x, y = opened.state.faces[0].outline[16].astype(int)
    grey[y - 20 : y + 20, x - 20 : x + 20] = 255
    file = tmp_path / "mask.png"
    Image.fromarray(grey).save(file)
    opened.window.actions_by_name["protect-mask"].trigger()
    opened.choose_path(file)
    opened.settle()
    (mask,) = strokes(opened)
    assert (opened.shown != free).any()
    np.testing.assert_array_equal(opened.shown, opened.rendered(pixels))
    np.testing.assert_array_equal(opened.shown[grey > 0], pixels[grey > 0])
    assert opened.panel("protect").count.text() == "Strokes: 1"
    # A stroke of the eraser takes away the part under it.
    opened.to_front()
    opened.key(KEYS.Key_E)
    opened.click(opened.canvas.to_screen(np.array([x, y], float)).toPoint())
    opened.settle()
    assert 0 < strokes(opened)[0].steps.sum() < mask.steps.sum()
    opened.key(KEYS.Key_Z, CONTROL)
    opened.key(KEYS.Key_Z, CONTROL)
    opened.settle()
    assert strokes(opened) == ()
    np.testing.assert_array_equal(opened.shown, free)


def test_a_mask_that_cant_be_used_is_told_and_nothing_changes(opened, tmp_path):
    before, file = opened.state, tmp_path / "mask.png"
    for grey, words in (
        (np.zeros((8, 9), np.uint8), "has 9 x 8 px"),
        (np.zeros((opened.editor.document.image.height, opened.editor.document.image.width),
                  np.uint8), "no white pixel"),
    ):  # fmt: skip
        Image.fromarray(grey).save(file)
        opened.window.actions_by_name["protect-mask"].trigger()
        opened.choose_path(file)
        opened.settle()
        assert words in opened.say()
        assert opened.state is before


def test_a_line_starts_narrow_beside_the_head(opened):
    opened.key(KEYS.Key_N)
    width = opened.state.faces[0].box[2]
    assert 2 * opened.editor.view.brush.radius_px == pytest.approx(0.05 * width)
    opened.key(KEYS.Key_BracketRight)
    wider = opened.editor.view.brush.radius_px
    opened.key(KEYS.Key_B)
    assert opened.editor.view.brush.radius_px != wider
    opened.key(KEYS.Key_N)
    assert opened.editor.view.brush.radius_px == wider
