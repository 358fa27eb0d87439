"""Combo boxes, folding groups, buttons, labels and layouts."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, QPointF, QSize, Qt, Signal
from PySide6.QtGui import QAction, QFont, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QComboBox,
    QHBoxLayout,
    QLabel,
    QLayout,
    QSizePolicy,
    QSpinBox,
    QStyle,
    QStyleOptionComboBox,
    QStylePainter,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ..i18n import bare, tr
from ..theme import GRID_PX

# Columns of a row in heights of a line; a longer name or value gets two lines.
_NAME_LINES = 6.0
_VALUE_LINES = 4.2
_EYE_PX = 4 * GRID_PX, 5 * GRID_PX  # width and height


class _PassesWheels(QObject):
    """Ignores wheel events for a control without focus, so that the parent scrolls."""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        turned = event.type() == QEvent.Type.Wheel
        passes = turned and isinstance(watched, QWidget) and not watched.hasFocus()
        if passes:
            event.ignore()
        return passes


def turn_in_focus_only(control: QWidget) -> None:
    """Accept wheel events only with the focus; a wheel event doesn't set the focus."""
    control.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
    control.installEventFilter(_PassesWheels(control))


class ChoiceBox(QComboBox):
    """A combo box that elides long text with …."""

    def __init__(self) -> None:
        super().__init__()
        turn_in_focus_only(self)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: ARG002
        """Draw a flat box with elided text and a chevron."""
        option = QStyleOptionComboBox()
        self.initStyleOption(option)
        box = QStyle.ComplexControl.CC_ComboBox
        field = QStyle.SubControl.SC_ComboBoxEditField
        room_px = self.style().subControlRect(box, option, field, self).width()
        end = Qt.TextElideMode.ElideRight
        option.currentText = self.fontMetrics().elidedText(self.currentText(), end, room_px)
        painter = QStylePainter(self)
        painter.drawComplexControl(box, option)
        painter.drawControl(QStyle.ControlElement.CE_ComboBoxLabel, option)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self.palette().placeholderText().color(), 1.5))
        x, y = self.width() - 12.0, self.height() / 2 + 2.0
        painter.drawPolyline([QPointF(x - 3.5, y - 3.5), QPointF(x, y), QPointF(x + 3.5, y - 3.5)])


class WholeNumber(QSpinBox):
    """A spin box for integers.

    Screen readers read its unit and its special text. `QDoubleSpinBox` tells a bare number, so
    all other numbers get a `ValueSlider`.
    """

    def __init__(self, least: int, most: int, value: int) -> None:
        super().__init__(minimum=least, maximum=most, value=value)
        turn_in_focus_only(self)


class Fold(QWidget):
    """A group that folds under a title button."""

    def __init__(self, title: str, content: QWidget, name: str = "") -> None:
        super().__init__()
        self.setObjectName(name)
        self._content, self._title = content, title
        self.button = QToolButton()
        self.button.setText(title)
        self.button.setAccessibleName(bare(title))
        self.button.setToolTip(tr("Show or hide: {what}", what=bare(title)))
        self.button.setProperty("fold", "true")
        self.button.setCheckable(True)
        self.button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.button.toggled.connect(self._show)
        column = column_of(self)
        column.addWidget(self.button, alignment=Qt.AlignmentFlag.AlignLeft)
        column.addWidget(content)
        self._show(False)

    def mark(self, changed: bool) -> None:
        """Mark the title with a dot if something in the group is changed."""
        self.button.setText(f"{self._title} \N{BULLET}" if changed else self._title)

    def flatten(self, flat: bool) -> None:
        """Show the content without a title, or fold it under the title again."""
        self.button.setHidden(flat)
        self._content.setVisible(flat or self.button.isChecked())

    def _show(self, opened: bool) -> None:
        arrow = Qt.ArrowType.DownArrow if opened else Qt.ArrowType.RightArrow
        self.button.setArrowType(arrow)
        self._content.setVisible(opened)


class Eye(QToolButton):
    """Switches a setting off and on; keeps its value in the meantime."""

    # (value: object): the value to set.
    switched = Signal(object)

    def __init__(self, what: str, off: object) -> None:
        super().__init__()
        self._what, self._off = what, off
        self._kept: dict[object, object] = {}
        self._value: object = off
        self._owner: object = None
        self._shown: object = None
        self._is_off = True
        self.setProperty("snug", "true")
        self.setFixedSize(*_EYE_PX)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.clicked.connect(self._switch)
        self.show_value(off, None, is_off=True)

    def show_value(self, value: object, owner: object, *, is_off: bool) -> None:
        """Show the value of a setting. Each owner, such as a face, has its own kept value."""
        shown = value, owner, owner in self._kept
        if shown == self._shown:
            return
        self._shown, self._is_off = shown, is_off
        self._value, self._owner = value, owner
        if not is_off:
            self._kept.pop(owner, None)
        self.setEnabled(not is_off or owner in self._kept)
        self.setText("" if not self.isEnabled() else "○" if is_off else "◉")
        on, off = (
            tr("Switch on: {what}", what=self._what),
            tr("Switch off: {what}", what=self._what),
        )
        self.setAccessibleName(on if is_off else off)
        self.setToolTip(self.accessibleName())

    def forget(self) -> None:
        """Drop the kept values: another photo is open."""
        self._kept.clear()
        self.show_value(self._value, self._owner, is_off=self._is_off)

    def _switch(self) -> None:
        if self._owner in self._kept:
            self.switched.emit(self._kept.pop(self._owner))
        else:
            self._kept[self._owner] = self._value
            self.switched.emit(self._off)


class Elided(QLabel):
    """A label without minimum width, elided with …; the tooltip shows the full text."""

    def __init__(self, tip: str = "") -> None:
        super().__init__()
        self._tip = tip
        self.setProperty("elides", "true")
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def minimumSizeHint(self) -> QSize:
        """Return width 0 and the line height."""
        return QSize(0, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: ARG002
        room = self.contentsRect()
        text = self.fontMetrics().elidedText(self.text(), Qt.TextElideMode.ElideRight, room.width())
        self.setToolTip(self.text() if text != self.text() else self._tip)
        QPainter(self).drawText(room, Qt.AlignmentFlag.AlignVCenter, text)


def action_button(action: QAction) -> QToolButton:
    """Return a narrow text button for an action, reachable with the Tab key."""
    button = _reached(action)
    button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
    button.setProperty("segment", "true")
    button.setProperty("snug", "true")
    return button


def _reached(action: QAction) -> QToolButton:
    """Return a button for an action, reachable with the Tab key."""
    button = QToolButton()
    button.setDefaultAction(action)
    button.setAccessibleName(bare(action.text()))
    button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
    return button


def segmented(name: str, actions: Sequence[QAction]) -> QWidget:
    """Return the actions of an exclusive group side by side, without gaps."""
    whole = QWidget()
    whole.setAccessibleName(name)
    buttons = [_reached(action) for action in actions]
    for button in buttons:
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
    column_of(whole, without_gaps(buttons))
    return whole


def without_gaps(buttons: Sequence[QToolButton]) -> QHBoxLayout:
    """Return a row of buttons that look like parts of one control."""
    for place, button in enumerate(buttons):
        ends = {0: "first", len(buttons) - 1: "last"}
        button.setProperty("part", ends.get(place, "middle"))
    return row_of(*buttons, spacing=0)


def heading(text: str) -> QLabel:
    """Return the title of a group."""
    label = QLabel(text)
    label.setProperty("heading", "true")
    return label


def named(text: str, buddy: QWidget) -> QLabel:
    """Return the title of a control, which also names it for screen readers."""
    label = QLabel(text)
    label.setBuddy(buddy)
    buddy.setAccessibleName(bare(text))
    return label


def name_buttons(within: QWidget) -> None:
    """Name buttons for screen readers without the letter for Alt that Qt leaves: ``頬(K)``."""
    for button in within.findChildren(QAbstractButton):
        if bare(button.text()) != button.text() and not button.accessibleName():
            button.setAccessibleName(bare(button.text()))


def muted_label(text: str = "", *, wraps: bool = False) -> QLabel:
    """Return a label for explanations, in a muted colour."""
    label = QLabel(text, wordWrap=wraps)
    label.setProperty("muted", "true")
    return label


class WarningLabel(QLabel):
    """A muted label that can warn; `warns` is the state for screen readers."""

    def __init__(self, *, wraps: bool = False) -> None:
        super().__init__(wordWrap=wraps)
        self.warns = False
        self.setProperty("muted", "true")

    def warn(self, wanted: bool) -> None:
        if wanted != self.warns:
            self.warns = wanted
            self.setProperty("warn", wanted)
            self.style().polish(self)


def column_of(
    widget: QWidget, *content: QWidget | QLayout | None, margin: int = 0, spacing: int = GRID_PX
) -> QVBoxLayout:
    """Return the layout of `widget`, a column on the 4 px grid; None adds a stretch."""
    column = QVBoxLayout(widget)
    column.setContentsMargins(margin, margin, margin, margin)
    column.setSpacing(spacing)
    for part in content:
        if part is None:
            column.addStretch()
        elif isinstance(part, QWidget):
            column.addWidget(part)
        else:
            column.addLayout(part)
    return column


def row_of(*widgets: QWidget | None, spacing: int = 2 * GRID_PX) -> QHBoxLayout:
    """Return widgets in a row; None adds a stretch."""
    row = QHBoxLayout()
    row.setSpacing(spacing)
    for widget in widgets:
        if widget is None:
            row.addStretch()
        else:
            row.addWidget(widget)
    return row


def columns_of(name: QLabel, control: QWidget | QLayout, value: QWidget) -> QHBoxLayout:
    """Return a row with the column widths of every row: name, control and value."""
    line = name.fontMetrics().height()
    name.setFixedWidth(round(_NAME_LINES * line))
    value.setFixedWidth(round(_VALUE_LINES * line))
    row = row_of(name)
    if isinstance(control, QWidget):
        row.addWidget(control, 1)
    else:
        row.addLayout(control, 1)
    row.addWidget(value)
    return row


def fits(name: QLabel, value: QWidget) -> bool:
    """Return whether the widest texts fit the columns of `columns_of`."""
    metrics = name.fontMetrics()
    name_px = metrics.horizontalAdvance(bare(name.text()))
    value_px, line = value.sizeHint().width() - GRID_PX, metrics.height()
    return name_px <= _NAME_LINES * line and value_px <= _VALUE_LINES * line


def enlarge(label: QWidget, factor: float) -> None:
    """Use a larger semibold font."""
    font = label.font()
    font.setPointSizeF(factor * QApplication.font().pointSizeF())
    font.setWeight(QFont.Weight.DemiBold)
    label.setFont(font)
