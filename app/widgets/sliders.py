"""Sliders: a drag or a held key previews, a release commits."""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

from PySide6.QtCore import QPointF, QRect, QRectF, QSignalBlocker, Qt, QTimer, Signal
from PySide6.QtGui import (
    QAccessible,
    QAccessibleEvent,
    QAccessibleValueInterface,
    QFocusEvent,
    QInputDevice,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QWheelEvent,
)
from PySide6.QtWidgets import (
    QAccessibleWidget,
    QApplication,
    QLabel,
    QSlider,
    QStyle,
    QStyleOptionSlider,
    QWidget,
)

from ..accessibility import DECREASE, INCREASE, NOTHING, actions_of, speak
from ..i18n import bare, tr
from ..theme import LEAD
from .controls import (
    Eye,
    column_of,
    columns_of,
    enlarge,
    fits,
    muted_label,
    row_of,
    turn_in_focus_only,
)
from .typed import SliderScale, ValueField

# Pause that ends a gesture of wheel notches, and the time for a double click, ms.
_REST_MS = 400
# Speed factor of a drag with Ctrl or Shift.
_FINE = 0.1
_IS_LINUX = sys.platform == "linux"
_STEPS = {INCREASE: 1, DECREASE: -1}
_FINELY = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier


class GestureSlider(QSlider):
    """A slider with signals for the end of a gesture, a reset and text input."""

    # (): the gesture has ended: a release, a key or a step.
    rested = Signal()
    # (): a double click asks for the first value.
    reset = Signal()
    # (): Enter asks for the text field.
    entered = Signal()

    def __init__(self, scale: SliderScale) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        speak(GestureSlider, SpokenSlider)
        turn_in_focus_only(self)
        self.scale = scale
        self.setRange(scale.low, scale.high)
        self.setPageStep(scale.page)
        self._exact = scale.value(self.value())
        self._aborted = False
        pause = max(_REST_MS, QApplication.doubleClickInterval())
        self._rest = QTimer(self, singleShot=True, interval=pause)
        self._rest.timeout.connect(self.rested)
        self._dragged = False
        self.stepped = False  # whether a key has moved the handle since the focus came
        self._x = self._place = 0.0
        self._touched: QPointF | None = None  # where a finger went down, until it moves
        self._is_signed = self.minimum() < 0 < self.maximum()

    def abort(self) -> None:
        """Ignore the mouse until the button is released."""
        self._aborted = self.isSliderDown()

    def show_amount(self, value: float) -> None:
        """Move the handle to the nearest step without emitting signals."""
        self._exact = value
        with QSignalBlocker(self):
            self.setValue(self.scale.step(value))

    def amount(self) -> float:
        """Return the visible value; a typed value may be between two steps."""
        step = self.value()
        nearest = min(max(self.scale.step(self._exact), self.minimum()), self.maximum())
        return self._exact if nearest == step else self.scale.value(step)

    def amount_text(self) -> str:
        return self.scale.text(self.amount())

    def take_figure(self, figure: float) -> None:
        """Set the value from an assistive tool as one gesture, clamped to the range."""
        self.take_steps(self.bounded(self.scale.typed(figure)) - self.value())

    def bounded(self, value: float) -> int:
        """Return the step nearest to a value."""
        ends = self.scale.value(self.minimum()), self.scale.value(self.maximum())
        return self.scale.step(min(max(value, ends[0]), ends[1]))

    def take_steps(self, by: int) -> None:
        self.setValue(self.value() + by)
        self.rested.emit()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Start a gesture; a press beside the handle moves the handle there.

        A finger may mean to scroll: the direction decides.
        """
        self._rest.stop()
        self._aborted = self._dragged = False
        if event.device().type() == QInputDevice.DeviceType.TouchScreen:
            self._touched = event.position()
            return
        if event.button() == Qt.MouseButton.LeftButton:
            self._jump(event.position().x())
        super().mousePressEvent(event)
        self._x, self._place = event.position().x(), float(self.value())

    def _parts(self) -> tuple[QRect, QRect, bool]:
        """Return groove and handle, px, and whether values increase to the left."""
        option = QStyleOptionSlider()
        self.initStyleOption(option)
        groove, handle = (
            self.style().subControlRect(QStyle.ComplexControl.CC_Slider, option, part, self)
            for part in (QStyle.SubControl.SC_SliderGroove, QStyle.SubControl.SC_SliderHandle)
        )
        return groove, handle, bool(option.upsideDown)

    def _jump(self, x: float) -> None:
        groove, handle, mirrored = self._parts()
        if handle.left() <= x <= handle.right():
            return
        place = round(x - groove.left() - handle.width() / 2)
        room = groove.width() - handle.width()
        self.setValue(
            QStyle.sliderValueFromPosition(self.minimum(), self.maximum(), place, room, mirrored)
        )

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Follow the mouse, slower with Ctrl or Shift, unless the gesture was aborted."""
        if self._touched is not None:
            way = event.position() - self._touched
            if way.manhattanLength() < QApplication.startDragDistance():
                return
            self._x, self._place, self._touched = self._touched.x(), float(self.value()), None
            self.setSliderDown(abs(way.x()) > abs(way.y()))
        self._dragged = self.isSliderDown()
        if self._aborted or not self._dragged:
            return
        groove, handle, mirrored = self._parts()
        steps = (self.maximum() - self.minimum()) / max(1, groove.width() - handle.width())
        by = (event.position().x() - self._x) * (-steps if mirrored else steps)
        self._x = event.position().x()
        self._place += by * _FINE if event.modifiers() & _FINELY else by
        self.setValue(round(self._place))

    @property
    def is_neutral(self) -> bool:
        """True at the value that changes nothing."""
        return self._is_signed and self.value() == 0

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: ARG002
        """Draw track, fill and handle; a disabled slider has a hollow handle and no fill."""
        groove, handle, mirrored = self._parts()
        painter, palette, on = QPainter(self), self.palette(), self.isEnabled()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(palette.dark() if on else palette.mid())
        radius, middle = handle.width() / 2, groove.center().y() + 0.5
        at, start = handle.left() + radius, groove.left() + (groove.width() if mirrored else 0)
        bar = QRectF(groove)
        painter.drawRoundedRect(bar, bar.height() / 2, bar.height() / 2)
        if self._is_signed:
            # The middle has a tick, and the fill starts there to show the direction.
            share = -self.minimum() / (self.maximum() - self.minimum())
            room = groove.width() - handle.width()
            start = round(groove.left() + radius + room * (1.0 - share if mirrored else share))
            painter.drawRect(QRectF(start - 0.5, middle - 5.0, 1.0, 10.0))
        if on:
            fill = QRectF(min(start, at), bar.top(), abs(at - start), bar.height())
            painter.fillRect(fill, palette.accent())
        calm = palette.placeholderText() if self.is_neutral else palette.windowText()
        edge = palette.window() if on else palette.mid()
        painter.setPen(QPen((palette.accent() if self.hasFocus() else edge).color(), 1.5))
        on_handle = palette.accent() if self.isSliderDown() else calm
        painter.setBrush(on_handle if on else palette.window())
        painter.drawEllipse(QPointF(at, middle), radius - 0.5, radius - 0.5)
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawEllipse(QPointF(at, middle), radius + 2.0, radius + 2.0)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End the gesture; after a click, wait for a double click first."""
        with QSignalBlocker(self):
            super().mouseReleaseEvent(event)
            self.setSliderDown(False)
        self._touched = None
        if not self._aborted and self._dragged:
            self.rested.emit()
        elif not self._aborted:
            self._rest.start()
        self._aborted = False

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()
        self._rest.stop()
        self.reset.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move by keys; Enter emits `entered`."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.entered.emit()
        else:
            before = self.value()
            super().keyPressEvent(event)
            if self.value() != before:
                self.stepped = True
                event_kind = QAccessible.Event.DescriptionChanged
                QAccessible.updateAccessibility(QAccessibleEvent(self, event_kind))

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """End a gesture by keys; auto-repeat belongs to the same gesture."""
        super().keyReleaseEvent(event)
        if not event.isAutoRepeat():
            self.rested.emit()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """End a gesture: the key release may reach another widget."""
        super().focusOutEvent(event)
        self._rest.stop()
        self.stepped = False
        self.rested.emit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Move by notches; notches in quick succession are one gesture."""
        super().wheelEvent(event)
        self._rest.start()


class _Title(QLabel):
    """The name of a slider; emits `doubled` on a double click."""

    # (): a double click on the title.
    doubled = Signal()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()
        self.doubled.emit()


class ValueSlider(QWidget):
    """A named slider with a text field and a tooltip."""

    # (value: float): a new value, also during a gesture.
    edited = Signal(float)
    # (): the gesture has ended; make one undo step.
    rested = Signal()
    # (): the first value is wanted.
    reset = Signal()
    # (why: str): the typed text is no value of the slider.
    refused = Signal(str)

    def __init__(
        self,
        title: str,
        scale: SliderScale,
        tip: str,
        note_lines: int = 0,
        *,
        lead: bool = False,
    ) -> None:
        super().__init__()
        self._first: float | None = None
        self.slider = GestureSlider(scale)
        self.title = _Title()
        self.title.setBuddy(self.slider)
        self.field = ValueField("", scale)
        self.slider.setProperty("lead", lead)
        if lead:
            enlarge(self.title, LEAD)
            enlarge(self.field, LEAD * LEAD)
        self.rename(title, tip, scale)
        self.note = muted_label()
        self.note.setVisible(note_lines > 0)
        self.note.setMinimumHeight(note_lines * self.note.fontMetrics().height())
        if lead or not fits(self.title, self.field):
            self._row = row_of(self.title, None, self.field)
            column_of(self, self._row, self.slider, self.note, spacing=0)
        else:
            self._row = columns_of(self.title, self.slider, self.field)
            column_of(self, self._row, self.note, spacing=0)
        self.slider.valueChanged.connect(self._tell)
        self.slider.rested.connect(self.rested)
        for doubled in (self.slider.reset, self.title.doubled):
            doubled.connect(self.reset)
        self.slider.entered.connect(self._type)
        self.field.typed.connect(self._take)
        self.field.refused.connect(self.refused)
        self.field.left.connect(self.slider.setFocus)

    def add_eye(self) -> Eye:
        """Add a button that switches the value to 0 and back."""
        eye = Eye(bare(self.title.text()), 0.0)
        self._row.removeWidget(self.title)
        self._row.insertLayout(0, row_of(self.title, eye, spacing=0))
        return eye

    def show_value(self, value: float) -> None:
        """Show a value without emitting signals."""
        self.slider.show_amount(value)
        self.field.show_text(self.slider.scale.text(value), calm=self.slider.is_neutral)

    def rename(self, title: str, tip: str, scale: SliderScale) -> None:
        """Set the name with mnemonic, the tooltip and the scale."""
        self._tip, self.slider.scale = tip, scale
        self.field.rename(bare(title), scale)
        self.title.setText(title)
        self.slider.setAccessibleName(bare(title))
        self._show_tip()

    def show_first(self, value: float) -> None:
        """Set the default value, named in the tooltip."""
        if value != self._first:
            self._first = value
            self._show_tip()

    def _show_tip(self) -> None:
        tip = self._tip
        if self._first is not None:
            first = self.slider.scale.text(self._first)
            tip += "\n" + tr("A double click brings {value} back.", value=first)
        for widget in (self.title, self.slider):
            widget.setToolTip(tip)
        self.slider.setAccessibleDescription(tip)

    def _tell(self, step: int) -> None:
        self.edited.emit(self.slider.scale.value(step))

    def _type(self) -> None:
        self.field.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.field.selectAll()

    def _take(self, value: float) -> None:
        self.edited.emit(value)
        self.rested.emit()


class SpokenSlider(QAccessibleWidget):
    """Accessible slider with the visible value instead of the step.

    Its description begins with the value and its unit, and is nothing else after a step by key:
    Orca reads a bare number, and a changed description at once.
    """

    def __init__(self, slider: GestureSlider) -> None:
        super().__init__(slider, QAccessible.Role.Slider)
        self._slider = slider
        self._value = _Value(slider)
        steps = {name: partial(slider.take_steps, by) for name, by in _STEPS.items()}
        self._actions = actions_of(slider, steps)

    def text(self, kind: QAccessible.Text) -> str:
        """Return the value with unit, also as a description, or another text of the base class."""
        value, text = self._slider.amount_text(), super().text(kind)
        if kind == QAccessible.Text.Description and not self._slider.stepped:
            return f"{value}\n{text}"
        return value if kind in (QAccessible.Text.Value, QAccessible.Text.Description) else text

    def interface_cast(self, kind: QAccessible.InterfaceType) -> Any:
        casts = {
            QAccessible.InterfaceType.ValueInterface: self._value,
            QAccessible.InterfaceType.ActionInterface: self._actions,
        }
        return casts.get(kind, NOTHING)


class _Value(QAccessibleValueInterface):
    """The visible number."""

    def __init__(self, slider: GestureSlider) -> None:
        super().__init__()
        self._slider = slider

    def currentValue(self) -> float:
        return self._slider.scale.figure(self._slider.amount())

    def setCurrentValue(self, value: object) -> None:
        self._slider.take_figure(float(str(value)))

    def minimumValue(self) -> float:
        if _IS_LINUX:
            return self.maximumValue()  # of a range, Orca 48 tells a percentage: 6 % as 40 percent
        return self._slider.scale.figure(self._slider.scale.value(self._slider.minimum()))

    def maximumValue(self) -> float:
        return self._slider.scale.figure(self._slider.scale.value(self._slider.maximum()))

    def minimumStepSize(self) -> float:
        # Steps may differ in size: the smallest is at the low end.
        scale, low = self._slider.scale, self._slider.minimum()
        return abs(scale.value(low + 1) - scale.value(low))
