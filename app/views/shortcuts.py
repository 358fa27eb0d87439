"""Other keys for the actions."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QSettings, Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QHeaderView,
    QKeySequenceEdit,
    QLabel,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from ..i18n import tr
from ..menus import specs
from ..panels.controls import column_of, muted_label
from ..theme import GRID_PX

_GROUP = "shortcuts"


def restore(settings: QSettings, actions: Mapping[str, QAction]) -> None:
    """Give the actions the keys that the user chose."""
    settings.beginGroup(_GROUP)
    for name in settings.childKeys():
        if name in actions:
            actions[name].setShortcut(QKeySequence(str(settings.value(name))))
    settings.endGroup()


class ShortcutsDialog(QDialog):
    """A list of actions, and a field that takes a new key for the selected one.

    Parameters
    ----------
    actions : mapping of str to QAction
        By name.
    settings : QSettings
        Where keys other than the first ones are kept.
    parent : QWidget
        The window.
    """

    def __init__(
        self, actions: Mapping[str, QAction], settings: QSettings, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Keys"))
        self._actions, self._settings = actions, settings
        self._first = {spec.name: QKeySequence(spec.key) for spec in specs() if spec.text}
        self._names = list(self._first)
        self.table = self._table()
        self.key = QKeySequenceEdit()
        self.key.setMaximumSequenceLength(1)
        self.key.setAccessibleName(tr("New key"))
        self.key.setClearButtonEnabled(True)
        self.key.editingFinished.connect(self._take)
        self.reset = QPushButton(tr("&First key again"))
        self.reset.clicked.connect(lambda: self._give(self._first[self._name]))
        self.note = muted_label()
        self.table.currentCellChanged.connect(self._show_current)
        self._lay_out()
        self.table.setCurrentCell(0, 0)
        self.resize(480, 520)

    def _lay_out(self) -> None:
        label = QLabel(tr("&New key"))
        label.setBuddy(self.key)
        row = QHBoxLayout()
        row.setSpacing(2 * GRID_PX)
        row.addWidget(label)
        row.addWidget(self.key, 1)
        row.addWidget(self.reset)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column = column_of(self, margin=3 * GRID_PX, spacing=2 * GRID_PX)
        column.addWidget(self.table, 1)
        column.addLayout(row)
        column.addWidget(self.note)
        column.addWidget(buttons)

    def _table(self) -> QTableWidget:
        table = QTableWidget(len(self._names), 2)
        table.setAccessibleName(tr("Actions and their keys"))
        table.setHorizontalHeaderLabels([tr("Action"), tr("Key")])
        table.horizontalHeader().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        table.verticalHeader().hide()
        table.setEditTriggers(QTableWidget.EditTrigger.NoEditTriggers)
        table.setSelectionBehavior(QTableWidget.SelectionBehavior.SelectRows)
        for row, name in enumerate(self._names):
            action = self._actions[name]
            table.setItem(row, 0, QTableWidgetItem(action.text().replace("&", "")))
            table.setItem(row, 1, QTableWidgetItem(action.shortcut().toString()))
        return table

    @property
    def _name(self) -> str:
        return self._names[self.table.currentRow()]

    def _show_current(self) -> None:
        self.key.setKeySequence(self._actions[self._name].shortcut())
        self.note.clear()

    def _take(self) -> None:
        self._give(self.key.keySequence())

    def _give(self, key: QKeySequence) -> None:
        name = self._name
        if key == self._actions[name].shortcut():
            return
        owner = next(
            (other for other in self._names if other != name and self._has(other, key)), None
        )
        if owner is not None:
            what = self._actions[owner].text().replace("&", "")
            self.note.setText(tr("{key} belongs to “{what}”", key=key.toString(), what=what))
            self.key.setKeySequence(self._actions[name].shortcut())
            return
        self._actions[name].setShortcut(key)
        if key == self._first[name]:
            self._settings.remove(f"{_GROUP}/{name}")
        else:
            self._settings.setValue(f"{_GROUP}/{name}", key.toString())
        self.table.setItem(self.table.currentRow(), 1, QTableWidgetItem(key.toString()))
        self._show_current()

    def _has(self, name: str, key: QKeySequence) -> bool:
        return not key.isEmpty() and self._actions[name].shortcut() == key
