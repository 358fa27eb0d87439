"""Messages over the canvas: what happened, with the next step as a button; never modal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QWidget

from ..i18n import tr
from ..theme import GRID_PX


@dataclass(frozen=True, slots=True)
class Step:
    """A button of a message: its text and what it does."""

    text: str
    act: Callable[[], object]


@dataclass(frozen=True, slots=True)
class Message:
    """What the bar says, the steps it offers, and whether something went wrong."""

    text: str
    steps: tuple[Step, ...] = ()
    wrong: bool = True


class MessageBar(QFrame):
    """One message at a time.

    Signals
    -------
    left
        The button that had the focus goes away.
    """

    left = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(tr("Message"))
        self.text = QLabel()
        self.text.setWordWrap(True)
        self.text.setTextFormat(Qt.TextFormat.PlainText)
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(3 * GRID_PX, 2 * GRID_PX, 2 * GRID_PX, 2 * GRID_PX)
        self._row.setSpacing(2 * GRID_PX)
        self._row.addWidget(self.text, 1)
        self.buttons: list[QPushButton] = []
        self.hide()

    def say(self, message: Message) -> None:
        """Show a message in place of the last one."""
        self.clear()
        self.text.setText(message.text)
        self.setProperty("bar", "wrong" if message.wrong else "hint")
        self.style().polish(self)
        self.setAccessibleDescription(message.text)
        for step in message.steps:
            self._add(step.text, step.act)
        self._add(tr("Dismiss"), lambda: None)
        self.show()
        self.raise_()

    def clear(self) -> None:
        """Say nothing."""
        if any(button.hasFocus() for button in self.buttons):
            self.left.emit()
        self.hide()
        for button in self.buttons:
            self._row.removeWidget(button)
            button.hide()
            button.deleteLater()
        self.buttons = []

    def _add(self, text: str, act: Callable[[], object]) -> None:
        button = QPushButton(text)
        button.clicked.connect(lambda: self._take(act))
        self._row.addWidget(button)
        self.buttons.append(button)

    def _take(self, act: Callable[[], object]) -> None:
        self.clear()
        act()
