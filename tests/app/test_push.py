"""Push and restore with mouse, keys and pen on the window."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QInputDevice, QMouseEvent, QPointingDevice, QTabletEvent
from PySide6.QtWidgets import QApplication
from test_files import CONTROL
from test_protect import paint
from test_view import picture

from kogao_core.photo import read

pytestmark = pytest.mark.usefixtures("one_window")

KEYS = Qt.Key
SHIFT = Qt.KeyboardModifier.ShiftModifier
INWARDS = QPoint(-24, 6)


def strokes(driver):
    return driver.state.brushwork.strokes


def jaw(driver) -> QPoint:
    return driver.canvas.to_screen(driver.state.faces[0].outline[4]).toPoint()


def draw(driver, key=KEYS.Key_W, by=INWARDS):
    driver.key(key, SHIFT)
    driver.drag(jaw(driver), by)
    driver.settle()


@pytest.mark.parametrize(
    ("key", "kind", "word"), [(KEYS.Key_W, "push", "Push"), (KEYS.Key_R, "restore", "Restore")]
)
def test_a_stroke_is_what_the_core_makes_of_it_and_one_undo_step(opened, pixels, key, kind, word):
    free = opened.shown.copy()
    draw(opened, key)
    (stroke,) = strokes(opened)
    brush = opened.editor.view.brush
    assert (stroke.kind, stroke.radius_px, stroke.strength, stroke.falloff, stroke.pressure) == (
        kind, brush.radius_px, brush.strength, brush.falloff, None,
    )  # fmt: skip
    start = opened.canvas.to_photo(jaw(opened).toPointF())
    np.testing.assert_allclose(stroke.points_px[0], start, atol=1e-3)
    end = opened.canvas.to_photo((jaw(opened) + INWARDS).toPointF())
    np.testing.assert_allclose(stroke.points_px[-1], end, atol=1e-3)
    assert (opened.shown != free).any()
    np.testing.assert_array_equal(opened.shown, opened.rendered(pixels))
    assert opened.editor.document.undo.undoText() == word
    opened.key(KEYS.Key_Z, CONTROL)
    opened.settle()
    assert not strokes(opened)
    np.testing.assert_array_equal(opened.shown, free)


def test_a_push_is_seen_while_it_is_drawn(opened):
    opened.pause_never()
    opened.key(KEYS.Key_W, SHIFT)
    before = picture(opened)
    at = jaw(opened)
    opened.press(at)
    opened.move(at + INWARDS / 2)
    opened.move(at + INWARDS)
    opened.qtbot.waitUntil(lambda: opened.editor.view.frame.rendering.brush_shares == (1.0,))
    assert (picture(opened) != before).any()
    assert opened.editor.document.in_gesture
    opened.key(KEYS.Key_Escape)
    opened.release(at + INWARDS)
    assert not strokes(opened)
    assert not opened.editor.document.undo.count()


def test_size_strength_and_falloff_are_set_in_the_panel(opened):
    panel = opened.panel("push")
    opened.key(KEYS.Key_W, SHIFT)
    assert panel.isVisible()
    radius = opened.editor.view.brush.radius_px
    opened.key(KEYS.Key_BracketRight)
    assert opened.editor.view.brush.radius_px > radius
    assert panel.size_px.slider.amount() == pytest.approx(
        opened.editor.view.brush.radius_px, rel=0.1
    )
    opened.press_key(panel.strength.slider, KEYS.Key_End)
    opened.press_key(panel.falloff.slider, KEYS.Key_Home)
    draw(opened)
    (stroke,) = strokes(opened)
    assert (stroke.strength, stroke.falloff) == (1.0, 0.4)
    panel.strength.reset.emit()
    assert opened.editor.view.brush.strength == 0.5


def test_protecting_and_moving_brushes_have_a_size_each(opened):
    opened.key(KEYS.Key_B)
    opened.key(KEYS.Key_BracketRight)
    protecting = opened.editor.view.brush.radius_px
    opened.key(KEYS.Key_W, SHIFT)
    moving = opened.editor.view.brush.radius_px
    assert moving > 2 * protecting
    opened.key(KEYS.Key_R, SHIFT)
    assert opened.editor.view.brush.radius_px == moving
    opened.key(KEYS.Key_B)
    assert opened.editor.view.brush.radius_px == protecting


def test_what_would_fold_is_held_back_and_said(opened):
    opened.key(KEYS.Key_W, SHIFT)
    opened.editor.protect.set_brush(strength=1.0)
    for _ in range(4):
        opened.drag(jaw(opened), QPoint(60, 0))
    opened.settle()
    rendering = opened.editor.view.frame.rendering
    assert min(rendering.brush_shares) < 1.0
    assert not rendering.one_to_one.folds
    assert "Limited to avoid folding: stroke " in opened.panel("push").held.text()
    opened.key(KEYS.Key_X, SHIFT)
    opened.settle()
    assert not opened.panel("push").held.text()


TABLET = MOUSE = QEvent.Type
POINTER = QPointingDevice.PointerType
NONE, LEFT, RIGHT = (getattr(Qt.MouseButton, n + "Button") for n in ("No", "Left", "Right"))
STYLUS = QInputDevice.DeviceType.Stylus


class Pen:
    """One end of a pen, and the mouse that Qt makes of it; events as seen on X11."""

    def __init__(self, driver, kind=POINTER.Pen, buttons=3):
        self.view, caps = driver.canvas.viewport(), QInputDevice.Capability.Pressure
        self.device = QPointingDevice("pen", 1, STYLUS, kind, caps, 1, buttons)

    def tablet(self, kind, at, pressure, button, held):
        where = QPointF(at), self.view.mapToGlobal(QPointF(at))
        none = Qt.KeyboardModifier.NoModifier
        event = QTabletEvent(
            kind, self.device, *where, pressure, 0, 0, 0, 0, 0, none, button, held
        )  # fmt: skip
        QApplication.sendEvent(self.view, event)
        assert not event.isAccepted(), "Qt makes a mouse of it"

    def mouse(self, kind, at, button, held):
        where = QPointF(at), self.view.mapToGlobal(QPointF(at))
        none = Qt.KeyboardModifier.NoModifier
        event = QMouseEvent(kind, where[0], where[1], button, held, none, self.device)
        QApplication.sendEvent(self.view, event)

    def hover(self, at):
        self.mouse(MOUSE.MouseMove, at, NONE, NONE)

    def down(self, at, pressure, button=LEFT, held=LEFT):
        self.tablet(TABLET.TabletPress, at, pressure, button, held)
        self.mouse(MOUSE.MouseButtonPress, at, button, held)

    def move(self, at, pressure):
        self.tablet(TABLET.TabletMove, at, pressure, NONE, LEFT)
        self.mouse(MOUSE.MouseMove, at, NONE, LEFT)

    def up(self, at, pressure=0.0, button=LEFT, held=NONE):
        """Lift the pen farther along: Qt sends one more move after the tablet's release."""
        self.tablet(TABLET.TabletRelease, at, pressure, button, held)
        self.mouse(MOUSE.MouseMove, at, NONE, held | button)
        self.mouse(MOUSE.MouseButtonRelease, at, button, held)

    def stroke(self, start, by, pressure):
        self.hover(start)
        self.down(start, pressure)
        for part in (by / 3, by / 2):
            self.move(start + part, pressure)
        self.up(start + by)


def test_a_pens_pressure_is_kept_to_the_end_of_the_stroke_and_a_mouse_presses_fully(opened):
    opened.key(KEYS.Key_W, SHIFT)
    pen, at = Pen(opened), jaw(opened)
    pen.stroke(at, INWARDS, 0.25)
    opened.settle()
    np.testing.assert_allclose(strokes(opened)[-1].pressure, 0.25, atol=1e-3)
    pen.hover(at)
    opened.drag(at, INWARDS)
    assert strokes(opened)[-1].pressure is None
    pen.stroke(at, INWARDS, 0.0)
    assert len(strokes(opened)) == 2, "a stroke without pressure does nothing"


def test_a_button_of_the_pen_ends_no_stroke(opened):
    opened.key(KEYS.Key_W, SHIFT)
    pen, at = Pen(opened), jaw(opened)
    pen.down(at, 0.5)
    pen.move(at + INWARDS / 2, 0.5)
    pen.down(at + INWARDS / 2, 0.5, RIGHT, LEFT | RIGHT)
    pen.up(at + INWARDS / 2, 0.5, RIGHT, LEFT)
    pen.move(at + INWARDS, 0.5)
    pen.up(at + INWARDS)
    opened.settle()
    end = opened.canvas.to_photo((at + INWARDS).toPointF())
    np.testing.assert_allclose(strokes(opened)[0].points_px[-1], end, atol=1e-3)


@pytest.mark.parametrize("tool", ["push", "points"])
def test_the_eraser_end_restores_and_the_tip_goes_on_as_before(opened, tool):
    opened.window.actions_by_name[f"tool-{tool}"].trigger()
    at = jaw(opened)
    Pen(opened, POINTER.Eraser).stroke(at, INWARDS, 0.5)
    opened.settle()
    assert opened.editor.view.brush.tool == "restore"
    assert opened.editor.document.undo.undoText() == "Restore"
    assert opened.window.actions_by_name["tool-restore"].isChecked()
    Pen(opened).hover(at)
    assert opened.editor.view.brush.tool == tool
    Pen(opened, POINTER.Eraser).hover(at)
    opened.key(KEYS.Key_B)
    Pen(opened).hover(at)
    assert opened.editor.view.brush.tool == "brush", "another tool chosen meanwhile stays"


def test_the_eraser_end_erases_protection(opened):
    paint(opened)
    before = opened.state.protection
    eraser, start = Pen(opened, POINTER.Eraser), opened.canvas.viewport().rect().topLeft()
    eraser.hover(start)
    assert opened.editor.view.brush.tool == "eraser"
    Pen(opened).hover(start)
    assert opened.editor.view.brush.tool == "brush"
    assert opened.state.protection == before


def test_a_saved_copy_has_the_strokes_and_keeps_what_is_protected(opened, tmp_path, pixels):
    draw(opened)
    paint(opened)
    opened.key(KEYS.Key_S, CONTROL)
    copy = tmp_path / "pushed.png"
    opened.choose_path(copy)
    opened.qtbot.waitUntil(copy.is_file)
    opened.settle()
    assert opened.state.protection.strokes
    np.testing.assert_array_equal(read(copy).pixels, opened.rendered(pixels))
