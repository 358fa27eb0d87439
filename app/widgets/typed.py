"""A flat text field for a value, which restores the old value after invalid input."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QKeyEvent, QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QApplication, QLineEdit, QSizePolicy, QStyle, QStyleOptionFrame

from ..i18n import tr
from ..theme import GRID_PX

_NUMBER: Final = re.compile(r"[-+\N{MINUS SIGN}]?(?:\d+(?:[.,]\d*)?|[.,]\d+)")
_WORD: Final = re.compile(r"[^\W\d_]+|%")
# Values are shown with at most two decimals.
_DECIMALS: Final = 2


@dataclass(frozen=True, slots=True)
class SliderScale:
    """Mapping between the integer steps of a slider and values."""

    # Range and Page-key step of the slider.
    low: int
    high: int
    page: int
    # Value of a step; step nearest to a value.
    value: Callable[[int], float]
    step: Callable[[float], int]
    text: Callable[[float], str]  # format a value
    # Convert a typed number to a value.
    typed: Callable[[float], float] = lambda number: round(number, _DECIMALS)
    least: float | None = None  # smallest typed value, if the slider starts higher

    @property
    def ends(self) -> tuple[str, str]:
        """Texts of the least and the largest value."""
        return self.text(self._least), self.text(self.value(self.high))

    def read(self, text: str) -> float | None:
        """Parse typed text, with or without the unit; None if invalid or out of range."""
        number = number_in(text, self._words(*self.ends))
        value = None if number is None else self.typed(number)
        inside = value is not None and self._least <= value <= self.value(self.high)
        return value if inside else None

    def figure(self, value: float) -> float:
        """Return the number in the text of a value, for screen readers."""
        text = self.text(value)
        number = number_in(text, self._words(text))
        return value if number is None else number

    @property
    def _least(self) -> float:
        return self.value(self.low) if self.least is None else self.least

    def _words(self, *texts: str) -> set[str]:
        return {word.casefold() for text in texts for word in _WORD.findall(text)}


def number_in(text: str, words: Collection[str] = ()) -> float | None:
    """Return the only number in a text with no words except `words`, else None.

    Comma and full stop both mark decimals.
    """
    found = _NUMBER.findall(text)
    rest = _NUMBER.sub(" ", text).casefold()
    strange = any(word not in words for word in _WORD.findall(rest))
    if len(found) != 1 or strange or not set(_WORD.sub("", rest)) <= set(" ,\N{NO-BREAK SPACE}"):
        return None
    return float(found[0].replace(",", ".").replace("\N{MINUS SIGN}", "-"))


class ValueField(QLineEdit):
    """Shows a value of a scale and accepts another.

    Enter and leaving the field accept the text, Escape cancels. The field then shows the current
    value.
    """

    # (value: float): a valid value is entered.
    typed = Signal(float)
    # (why: str): the text is no value of the field.
    refused = Signal(str)
    # (): Enter or Escape ends the input.
    left = Signal()

    def __init__(self, name: str, scale: SliderScale) -> None:
        super().__init__()
        self._shown, self._calm = "", False
        self.rename(name, scale)
        self.setProperty("value", "true")
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        # A wide line edit would be as long as the title leaves room for.
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        # A dropped photo is for the window; the URL is no value.
        self.setAcceptDrops(False)
        self.setToolTip(tr("Type a value; Enter applies, Escape cancels"))
        self.editingFinished.connect(self._take)

    def rename(self, name: str, scale: SliderScale) -> None:
        self._name, self._scale = name, scale
        self.setAccessibleName(tr("{name}, in figures", name=name))
        self.updateGeometry()

    def show_text(self, text: str, *, calm: bool = False) -> None:
        """Show a value; a calm one changes nothing. Unfinished input stays until accepted."""
        if calm != self._calm:
            self._calm = calm
            self.update()
        self._shown = text
        if not (self.hasFocus() and self.isModified()):
            self._restore()

    def sizeHint(self) -> QSize:
        """Return the size for the longest value, so that the layout doesn't move."""
        longest = max(map(self.fontMetrics().horizontalAdvance, (*self._scale.ends, self._shown)))
        return QSize(longest + 2 * GRID_PX, super().sizeHint().height())

    def minimumSizeHint(self) -> QSize:
        """Return the same size: a truncated number would mislead."""
        return self.sizeHint()

    def mouseDoubleClickEvent(self, _: QMouseEvent) -> None:
        """Select the whole value; Qt would select a part such as the unit."""
        self.selectAll()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the unit quieter than the number, unless the text is being edited."""
        if self.hasFocus():
            super().paintEvent(event)
            return
        option, painter, palette = QStyleOptionFrame(), QPainter(self), self.palette()
        self.initStyleOption(option)
        self.style().drawPrimitive(QStyle.PrimitiveElement.PE_PanelLineEdit, option, painter, self)
        found = _NUMBER.search(self.text())
        start, end = found.span() if found else (0, 0)
        quiet, unit = palette.placeholderText().color(), QApplication.font()
        loud = quiet if self._calm or not self.isEnabled() else palette.text().color()
        right, metrics = self.width() - GRID_PX, self.fontMetrics()
        baseline = (self.height() + metrics.ascent() - metrics.descent()) // 2
        number = self.text()[start:end].replace("-", "\N{MINUS SIGN}")
        parts = ((self.text()[end:], quiet, unit), (number, loud, self.font()))
        for text, colour, font in (*parts, (self.text()[:start], quiet, unit)):
            right -= QFontMetrics(font).horizontalAdvance(text)
            painter.setFont(font)
            painter.setPen(colour)
            painter.drawText(right, baseline, text)

    def event(self, event: QEvent) -> bool:
        """Handle Escape here instead of in the window's shortcuts."""
        asked = event.type() == QEvent.Type.ShortcutOverride
        if asked and isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_Escape:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Accept the text with Enter, cancel with Escape."""
        if event.key() == Qt.Key.Key_Escape:
            self._restore()
            self.left.emit()
            return
        super().keyPressEvent(event)
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.left.emit()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Select the whole text with the first click, so that typing replaces the value."""
        first = not self.hasFocus() or not self.isModified()
        super().mousePressEvent(event)
        if first:
            self.selectAll()

    def _take(self) -> None:
        if not self.isModified():
            return
        text = self.text()
        self._restore()
        value = self._scale.read(text)
        if value is not None:
            self.typed.emit(value)
        else:
            low, high = self._scale.ends
            words = tr("{name} goes from {low} to {high}.", name=self._name, low=low, high=high)
            self.refused.emit(words)

    def _restore(self) -> None:
        self.setText(self._shown)
        self.setCursorPosition(0)
