"""A value as a field to type in: flat until it is pointed at, and right or put back."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QLineEdit

from ..i18n import tr
from ..theme import GRID_PX

_NUMBER: Final = re.compile(r"[-+\N{MINUS SIGN}]?(?:\d+(?:[.,]\d*)?|[.,]\d+)")
_WORD: Final = re.compile(r"[^\W\d_]+|%")
# Finer than hundredths nothing is shown.
_DECIMALS: Final = 2


@dataclass(frozen=True, slots=True)
class SliderScale:
    """How the whole steps of a slider stand for values."""

    # Range and Page-key step of the slider.
    low: int
    high: int
    page: int
    # Value of a step, and the step nearest to a value.
    value: Callable[[int], float]
    step: Callable[[float], int]
    text: Callable[[float], str]  # how a value reads
    # The value that a number typed in place of the one in `text` stands for.
    typed: Callable[[float], float] = lambda number: round(number, _DECIMALS)
    least: float | None = None  # the least that may be typed, where the slider ends above it

    @property
    def ends(self) -> tuple[str, str]:
        """How the least and the largest value read."""
        return self.text(self._least), self.text(self.value(self.high))

    def read(self, text: str) -> float | None:
        """Return the value that a user has typed, with or without its unit; None for no value."""
        number = number_in(text, self._words(*self.ends))
        value = None if number is None else self.typed(number)
        inside = value is not None and self._least <= value <= self.value(self.high)
        return value if inside else None

    def figure(self, value: float) -> float:
        """Return the number in the text of a value: what is read aloud is what is seen."""
        text = self.text(value)
        number = number_in(text, self._words(text))
        return value if number is None else number

    @property
    def _least(self) -> float:
        return self.value(self.low) if self.least is None else self.least

    def _words(self, *texts: str) -> set[str]:
        return {word.casefold() for text in texts for word in _WORD.findall(text)}


def number_in(text: str, words: Collection[str] = ()) -> float | None:
    """Return the one number in a text that else holds nothing but `words`; None otherwise.

    Comma and full stop are both the sign of the decimals.
    """
    found = _NUMBER.findall(text)
    rest = _NUMBER.sub(" ", text).casefold()
    strange = any(word not in words for word in _WORD.findall(rest))
    if len(found) != 1 or strange or not set(_WORD.sub("", rest)) <= set(" ,\N{NO-BREAK SPACE}"):
        return None
    return float(found[0].replace(",", ".").replace("\N{MINUS SIGN}", "-"))


class ValueField(QLineEdit):
    """Shows a value of a scale and takes another one.

    Enter and leaving the field take what is typed, Escape gives it up; after either the value
    stands there again as it is.
    """

    typed = Signal(float)
    refused = Signal(str)
    left = Signal()

    def __init__(self, name: str, scale: SliderScale) -> None:
        super().__init__()
        self._shown = ""
        self.rename(name, scale)
        self.setProperty("value", "true")
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        # A photo that is dropped here is for the window, and its address no value.
        self.setAcceptDrops(False)
        self.setToolTip(tr("Type a value; Enter takes it, Escape gives it up"))
        self.editingFinished.connect(self._take)

    def rename(self, name: str, scale: SliderScale) -> None:
        """Take another name and other texts for the values."""
        self._name, self._scale = name, scale
        self.setAccessibleName(tr("{name}, in figures", name=name))
        self.updateGeometry()

    def show_text(self, text: str) -> None:
        """Show a value; what is being typed stays until it is taken or given up."""
        self._shown = text
        if not (self.hasFocus() and self.isModified()):
            self._restore()

    def sizeHint(self) -> QSize:
        """Return room for the longest value, so that nothing moves with the figures."""
        longest = max(map(self.fontMetrics().horizontalAdvance, (*self._scale.ends, self._shown)))
        return QSize(longest + 5 * GRID_PX, super().sizeHint().height())

    def minimumSizeHint(self) -> QSize:
        """Return the same: a cut figure is a wrong one."""
        return self.sizeHint()

    def event(self, event: QEvent) -> bool:
        """Keep Escape from the window while something is typed here."""
        asked = event.type() == QEvent.Type.ShortcutOverride
        if asked and isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_Escape:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Take what is typed with Enter, give it up with Escape."""
        if event.key() == Qt.Key.Key_Escape:
            self._restore()
            self.left.emit()
            return
        super().keyPressEvent(event)
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.left.emit()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Select all with the first click: what is typed comes in place of it."""
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
