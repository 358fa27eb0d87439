"""The order for a batch: which photos, where to, with which settings."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QHBoxLayout,
    QLabel,
    QLayout,
    QLineEdit,
    QListWidget,
    QPushButton,
    QWidget,
)

from kogao_core.recipe import Recipe

from ...i18n import tr
from ...theme import GRID_PX
from ...widgets.controls import ChoiceBox, WholeNumber, column_of, heading, muted_label
from ...widgets.dialogs import ask_path, photo_filter
from .run import Order

_MOST_JOBS: Final = 64
# Each photo in hand takes about eight times its pixels: more at once is the user's own choice.
_JOBS: Final = max(1, min(4, (os.cpu_count() or 2) - 1))
_LIST_PX: Final = 96


class OrderForm(QWidget):
    """Takes the order; photos and folders can be dropped on it.

    Signals
    -------
    changed
        The order may have become complete, or incomplete.
    """

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setAcceptDrops(True)
        self._recipes: list[Recipe] = []
        self.inputs = framed_list()
        self.folder = QLineEdit()
        self.folder.setToolTip(tr("Made if need be; no photo of yours is ever written over"))
        self.folder.textChanged.connect(self.changed)
        self.settings = ChoiceBox()
        self.settings.setToolTip(tr("What is done to every photo"))
        self.projects = QCheckBox(tr("Where a &project lies beside a photo, do what it says"))
        self.projects.setToolTip(tr("Its points, settings and protection, as they were saved"))
        self.again = QCheckBox(tr("Do every photo &again, also those that are done"))
        self.again.setToolTip(tr("Otherwise only what is missing or has changed"))
        self.jobs = WholeNumber(1, _MOST_JOBS, _JOBS)
        self.jobs.setToolTip(tr("Each takes about eight times the pixels of a photo in memory"))
        self.disclosure = muted_label()
        self._lay_out()

    def _lay_out(self) -> None:
        column = column_of(self, spacing=2 * GRID_PX)
        column.addWidget(named(tr("P&hotos and folders, also dropped here"), self.inputs))
        column.addWidget(self.inputs)
        column.addLayout(
            row_of(
                button(tr("Add ph&otos…"), self._ask_photos),
                button(tr("Add a &folder…"), self._ask_folder),
                button(tr("Re&move"), self.remove_selected),
            )
        )
        column.addWidget(named(tr("Results &go to"), self.folder))
        column.addLayout(row_of(self.folder, button(tr("&Choose…"), self._ask_target)))
        column.addWidget(named(tr("S&ettings"), self.settings))
        for widget in (self.settings, self.projects, self.again):
            column.addWidget(widget)
        column.addLayout(row_of(named(tr("Photos at a &time"), self.jobs), self.jobs, None))
        column.addWidget(self.disclosure)

    def offer(self, recipes: Mapping[str, Recipe], disclosure: str) -> None:
        """Show what there is to choose: recipes by name, and what results tell of themselves."""
        chosen = self.settings.currentText()
        self._recipes = list(recipes.values())
        self.settings.clear()
        self.settings.addItems(list(recipes))
        self.settings.setCurrentIndex(max(0, self.settings.findText(chosen)))
        self.disclosure.setText(disclosure)
        self.disclosure.setVisible(bool(disclosure))

    def add(self, paths: Sequence[Path]) -> None:
        """Add photos and folders; the first one suggests where results go."""
        listed = self.paths
        for path in paths:
            if path not in listed:
                self.inputs.addItem(str(path))
        if paths and not self.folder.text():
            home = paths[0] if paths[0].is_dir() else paths[0].parent
            self.folder.setText(str(home / "kogao"))
        self.changed.emit()

    @property
    def paths(self) -> list[Path]:
        """What is to be worked on."""
        return [Path(self.inputs.item(row).text()) for row in range(self.inputs.count())]

    def remove_selected(self) -> None:
        """Take the selected lines out."""
        for item in self.inputs.selectedItems():
            self.inputs.takeItem(self.inputs.row(item))
        self.changed.emit()

    @property
    def is_complete(self) -> bool:
        """Whether there is something to do and a place for it."""
        return bool(self.inputs.count() and self.folder.text().strip())

    def order(self) -> Order:
        """Return what is wanted."""
        return Order(
            tuple(self.paths),
            Path(self.folder.text()),
            self._recipes[self.settings.currentIndex()],
            self.jobs.value(),
            self.projects.isChecked(),
            self.again.isChecked(),
        )

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept files."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Add files and folders."""
        event.acceptProposedAction()
        self.add([Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()])

    def _ask_photos(self) -> None:
        title = tr("Add photos")
        ask_path(self, title, lambda path: self.add([path]), "files", filters=[photo_filter()])

    def _ask_folder(self) -> None:
        ask_path(self, tr("Add a folder"), lambda path: self.add([path]), "folder")

    def _ask_target(self) -> None:
        ask_path(self, tr("Results go to"), lambda path: self.folder.setText(str(path)), "folder")


def named(text: str, buddy: QWidget) -> QLabel:
    """Return the title of a control, which also names it for screen readers."""
    label = heading(text)
    label.setBuddy(buddy)
    buddy.setAccessibleName(text.replace("&", ""))
    return label


def framed_list() -> QListWidget:
    """Return a list in a frame, whose long lines are wrapped."""
    rows = QListWidget()
    rows.setProperty("framed", "true")
    rows.setMinimumHeight(_LIST_PX)
    rows.setWordWrap(True)
    rows.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    rows.setSelectionMode(QListWidget.SelectionMode.ExtendedSelection)
    return rows


def button(text: str, slot: Callable[[], object]) -> QPushButton:
    """Return a button that the Return key elsewhere doesn't press."""
    made = QPushButton(text)
    made.setAutoDefault(False)
    made.clicked.connect(slot)
    return made


def row_of(*widgets: QWidget | None) -> QLayout:
    """Return widgets in a row; None is what room is left."""
    row = QHBoxLayout()
    row.setSpacing(2 * GRID_PX)
    for widget in widgets:
        if widget is None:
            row.addStretch()
        else:
            row.addWidget(widget)
    return row
