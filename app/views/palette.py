"""The command palette: every action by its name, found by a few letters."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QKeyEvent
from PySide6.QtWidgets import QDialog, QLineEdit, QListWidget, QListWidgetItem, QWidget

from ..i18n import tr
from ..panels.controls import column_of

_SIZE_PX: Final = (440, 360)
_ROWS: Final = (Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown)


class Palette(QDialog):
    """Type to narrow the list, Return to run what is selected, Escape to leave.

    Parameters
    ----------
    actions : iterable of QAction
        What can be run; those that can't be now are left out.
    parent : QWidget
        The window.
    """

    def __init__(self, actions: Iterable[QAction], parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Commands"))
        self.words, self.list = QLineEdit(), QListWidget()
        self.words.setPlaceholderText(tr("What do you want to do?"))
        self.words.setAccessibleName(tr("Search commands"))
        self.words.installEventFilter(self)
        self.list.setAccessibleName(tr("Commands"))
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._actions = [action for action in actions if action.isEnabled() and action.text()]
        for action in self._actions:
            QListWidgetItem(_title(action), self.list)
        column = column_of(self, margin=8)
        column.addWidget(self.words)
        column.addWidget(self.list)
        self.resize(*_SIZE_PX)
        self.words.textChanged.connect(self._narrow)
        self.words.returnPressed.connect(self._run)
        self.list.itemClicked.connect(self._run)
        self._narrow("")

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Let keys that walk through a list reach it while the line has the focus."""
        if event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent):
            if event.key() not in _ROWS:
                return False
            self.list.keyPressEvent(event)
            return True
        return super().eventFilter(watched, event)

    def _narrow(self, text: str) -> None:
        words = text.casefold().split()
        first = -1
        for row in range(self.list.count()):
            item = self.list.item(row)
            hidden = not all(word in item.text().casefold() for word in words)
            item.setHidden(hidden)
            if not hidden and first < 0:
                first = row
        self.list.setCurrentRow(first)

    def _run(self) -> None:
        row = self.list.currentRow()
        if row >= 0 and not self.list.item(row).isHidden():
            # The action may open a dialog of its own: this one goes first.
            self.accept()
            self._actions[row].trigger()


def _title(action: QAction) -> str:
    name = action.text().replace("&", "").rstrip("…")
    key = action.shortcut().toString()
    return f"{name}   {key}" if key else name
