"""Fingers on the screen and on the touchpad."""

from __future__ import annotations

import pytest
from kogao_app.i18n import tr
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import (
    QGuiApplication,
    QInputDevice,
    QMouseEvent,
    QNativeGestureEvent,
    QPointingDevice,
)
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

pytestmark = pytest.mark.usefixtures("one_window")

KEYS, KINDS = Qt.Key, Qt.NativeGestureType
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
SCREEN = QTest.createTouchDevice()


class Fingers:
    """Fingers on a widget: each moves in an event of its own, as on X11."""

    def __init__(self, widget):
        self.widget, self.there = widget, {}
        self.events = QTest.touchEvent(widget, SCREEN, False)

    def put(self, finger, at):
        for other in self.there.keys() - {finger}:
            self.events.stationary(other)
        kind = self.events.move if finger in self.there else self.events.press
        kind(finger, at, self.widget)
        self.there[finger] = at
        self.events.commit()

    def lift(self, finger):
        at = self.there.pop(finger)
        for other in self.there:
            self.events.stationary(other)
        self.events.release(finger, at, self.widget)
        self.events.commit()


def jaw(driver) -> QPoint:
    return driver.canvas.to_screen(driver.state.faces[0].outline[4]).toPoint()


@pytest.mark.parametrize("tool", ["push", "points"])
def test_two_fingers_zoom_and_pan_and_edit_nothing(opened, tool):
    opened.window.actions_by_name[f"tool-{tool}"].trigger()
    canvas, at = opened.canvas, jaw(opened)
    before, state, zoom = canvas.to_photo(at.toPointF()), opened.state, canvas.zoom
    fingers = Fingers(canvas.viewport())
    fingers.put(0, at)
    fingers.put(0, at + QPoint(-14, 6))
    fingers.put(0, at)
    fingers.put(1, at + QPoint(60, 0))
    for x in (80, 100, 120):
        fingers.put(1, at + QPoint(x, 0))
    assert canvas.zoom == pytest.approx(2.0 * zoom, rel=0.02)
    assert canvas.to_photo(at.toPointF()) == pytest.approx(before, abs=1.5), "stays below it"
    fingers.put(0, at + QPoint(30, 40))
    fingers.put(1, at + QPoint(150, 40))
    moved = canvas.to_photo((at + QPoint(30, 40)).toPointF())
    assert moved == pytest.approx(before, abs=1.5), "pans with both"
    fingers.lift(1)
    fingers.put(0, at)
    fingers.lift(0)
    opened.settle()
    assert opened.state is state
    assert not opened.editor.document.undo.count()


def test_a_pinch_on_the_touchpad_zooms_at_the_pointer(opened):
    canvas, at, pad = opened.canvas, jaw(opened).toPointF(), QPointingDevice.primaryPointingDevice()
    before, zoom = canvas.to_photo(at), canvas.zoom
    for kind, value in (
        (KINDS.BeginNativeGesture, 0.0), (KINDS.ZoomNativeGesture, 0.25),
        (KINDS.ZoomNativeGesture, 0.25), (KINDS.EndNativeGesture, 0.0),
    ):  # fmt: skip
        where = at, at, canvas.viewport().mapToGlobal(at)
        event = QNativeGestureEvent(kind, pad, 2, *where, value, QPointF())
        QApplication.sendEvent(canvas.viewport(), event)
    assert canvas.zoom == pytest.approx(1.5 * zoom), "the parts add up"
    assert canvas.to_photo(at) == pytest.approx(before, abs=0.1)


@pytest.mark.parametrize(("to", "moves"), [(QPoint(2, -60), False), (QPoint(30, 3), True)])
def test_a_finger_moves_a_slider_along_and_never_by_a_swipe_across(opened, to, moves):
    slider = opened.panel("recipe").percent.slider
    first, start = slider.value(), QPoint(5, slider.height() // 2)
    kind, caps = QInputDevice.DeviceType.TouchScreen, QInputDevice.Capability.Position
    finger = QPointingDevice("screen", 2, kind, QPointingDevice.PointerType.Finger, caps, 5, 0)
    for what, at, held in (
        ("ButtonPress", start, "Left"), ("Move", start + to / 2, "Left"),
        ("Move", start + to, "Left"), ("ButtonRelease", start + to, "No"),
    ):  # fmt: skip
        button = Qt.MouseButton.LeftButton if "Button" in what else Qt.MouseButton.NoButton
        held = getattr(Qt.MouseButton, f"{held}Button")
        where = QPointF(at), slider.mapToGlobal(QPointF(at))
        kind = getattr(QMouseEvent.Type, f"Mouse{what}")
        none = Qt.KeyboardModifier.NoModifier
        event = QMouseEvent(kind, where[0], where[1], button, held, none, finger)
        QApplication.sendEvent(slider, event)
    opened.settle()
    assert (slider.value() > first) is moves
    assert opened.editor.document.undo.count() == moves
    assert not slider.isSliderDown()


def test_the_result_is_copied_and_a_copied_photo_is_opened(opened, other):
    clipboard = QGuiApplication.clipboard()
    opened.edit(9.0)
    opened.key(KEYS.Key_C, CONTROL)
    opened.settle()
    copied = clipboard.image()
    assert copied.size().toTuple() == opened.editor.document.photo.pixels.shape[1::-1]
    x, y = 40, 60
    assert copied.pixelColor(x, y).getRgb()[:3] == tuple(opened.shown[y, x].tolist()[:3])
    files = QMimeData()
    files.setUrls([QUrl.fromLocalFile(str(other))])
    clipboard.setMimeData(files)
    opened.key(KEYS.Key_V, CONTROL)
    opened.qtbot.waitUntil(lambda: opened.editor.document.path == other)
    opened.settle()
    clipboard.setText("no file")
    opened.key(KEYS.Key_V, CONTROL)
    words = tr("The clipboard holds no photo file; copy a file, or drop it here.")
    assert opened.say() == words
