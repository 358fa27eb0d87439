"""The batch dialog: the order above, and below it how far it is."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt, QUrl, Signal
from PySide6.QtGui import QDesktopServices, QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QLabel,
    QListWidget,
    QProgressBar,
    QPushButton,
    QWidget,
)

from kogao_core.batch import Outcome
from kogao_core.photo.export import Export
from kogao_core.recipe.recipe import Recipe

from ...i18n import tr, translated
from ...theme import GRID_PX
from ...widgets.controls import ChoiceBox, WholeNumber, column_of, muted_label, named, row_of
from ...widgets.dialogs import Dialog, PathEdit, ask_path, button, files_in, photo_filter
from .order import BatchProgress, Order

_MOST_JOBS: Final = 64
# Each photo in hand takes about eight times its pixels: more at once is the user's own choice.
_JOBS: Final = max(1, min(4, (os.cpu_count() or 2) - 1))
_LIST_PX: Final = 96
_SIZE_PX: Final = (560, 620)


class OrderForm(QWidget):
    """Takes the order; photos and folders can be dropped on it."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setAcceptDrops(True)
        self._recipes: list[Recipe] = []
        self._exports: list[Export] = []
        self.inputs = _framed_list()
        self.folder = PathEdit()
        self.folder.setToolTip(tr("Made if need be; no photo of yours is ever written over"))
        self.folder.textChanged.connect(self.changed)
        self.settings = ChoiceBox()
        self.settings.setToolTip(tr("What is done to every photo"))
        self.export = ChoiceBox()
        self.export.setToolTip(tr("Size, format and colours of results; File, Export has more"))
        self.projects = QCheckBox(tr("Where a &photo has edits of its own, do what they say"))
        self.projects.setToolTip(tr("Its points, settings and protection, as they were kept"))
        self.projects.setChecked(True)
        self.doubtful = QCheckBox(tr("Make &doubtful faces smaller, too"))
        self.doubtful.setToolTip(
            tr("Those that are unsure, cut off, hidden or on their head are left alone otherwise")
        )
        self.again = QCheckBox(tr("Do every photo &again, also those that are done"))
        self.again.setToolTip(tr("Otherwise only what is missing or has changed"))
        self.jobs = WholeNumber(1, _MOST_JOBS, _JOBS)
        self.jobs.setToolTip(tr("Each takes about eight times the pixels of a photo in memory"))
        self.disclosure = muted_label()
        self._lay_out()

    def _lay_out(self) -> None:
        column_of(
            self,
            named(tr("P&hotos and folders, also dropped here"), self.inputs),
            self.inputs,
            row_of(
                button(tr("Add ph&otos…"), self._ask_photos),
                button(tr("Add a &folder…"), self._ask_folder),
                button(tr("Re&move"), self.remove_selected),
            ),
            named(tr("Results &go to"), self.folder),
            row_of(self.folder, button(tr("&Choose…"), self._ask_target)),
            named(tr("S&ettings"), self.settings),
            self.settings,
            named(tr("E&xport as"), self.export),
            *(self.export, self.projects, self.doubtful, self.again),
            row_of(named(tr("Photos at a &time"), self.jobs), self.jobs, None),
            self.disclosure,
            spacing=2 * GRID_PX,
        )

    def offer(
        self, recipes: Mapping[str, Recipe], exports: Mapping[str, Export], disclosure: str
    ) -> None:
        """Show what there is to choose, by name, and what results tell of themselves."""
        self._recipes, self._exports = list(recipes.values()), list(exports.values())
        for box, names in ((self.settings, recipes), (self.export, exports)):
            chosen = box.currentText()
            box.clear()
            box.addItems(list(names))
            box.setCurrentIndex(max(0, box.findText(chosen)))
        self.disclosure.setText(disclosure)
        self.disclosure.setVisible(bool(disclosure))

    def add(self, paths: Sequence[Path]) -> None:
        """Add photos and folders; the first one suggests where results go."""
        listed = self.paths
        for path in paths:
            if path not in listed:
                self.inputs.addItem(str(path))
        if paths and not self.folder.text():
            home = paths[0] if os.path.isdir(paths[0]) else paths[0].parent
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
            self.doubtful.isChecked(),
            export=self._exports[self.export.currentIndex()],
        )

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept files."""
        if files_in(event.mimeData()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Add files and folders."""
        event.acceptProposedAction()
        self.add(files_in(event.mimeData()))

    def _ask_photos(self) -> None:
        title = tr("Add photos")
        ask_path(self, title, lambda path: self.add([path]), "files", filters=[photo_filter()])

    def _ask_folder(self) -> None:
        ask_path(self, tr("Add a folder"), lambda path: self.add([path]), "folder")

    def _ask_target(self) -> None:
        ask_path(self, tr("Results go to"), lambda path: self.folder.setText(str(path)), "folder")


class BatchDialog(Dialog):
    """Takes the order for a batch and follows it."""

    wanted = Signal(object)
    stopped = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(tr("Batch"), parent, _SIZE_PX)
        # It can be closed while it works, and opened again.
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose, False)
        self._report: Path | None = None
        self.form = OrderForm()
        self.form.changed.connect(self._allow)
        self.progress = QProgressBar()
        self.progress.setAccessibleName(tr("Progress"))
        self.progress.setTextVisible(False)
        self.note = QLabel()
        self.note.setWordWrap(True)
        self.bad = _framed_list()
        self.go = QPushButton(tr("&Start"))
        self.go.setDefault(True)
        self.go.clicked.connect(self._go)
        self.report = button(tr("Open the &report"), self._open_report)
        self.report.setToolTip(tr("One line a photo, with what became of it"))
        self._lay_out()
        self.show_idle()

    def _lay_out(self) -> None:
        self._bad_title = named(tr("&Not done"), self.bad)
        below = row_of(self.report, None, button(tr("Close"), self.close), self.go)
        content = self.form, self.progress, self.note, self._bad_title, self.bad, below
        column = column_of(self, *content, margin=4 * GRID_PX, spacing=2 * GRID_PX)
        column.setStretchFactor(self.form, 3)
        column.setStretchFactor(self.bad, 2)

    def _go(self) -> None:
        if self.form.isEnabled():
            order = self.form.order()
            self._report = order.report
            self.wanted.emit(order)
        else:
            self.go.setEnabled(False)
            self.note.setText(tr("The photos in hand are finished first…"))
            self.stopped.emit()

    def _allow(self) -> None:
        if self.form.isEnabled():
            self.go.setEnabled(self.form.is_complete)

    def _open_report(self) -> None:
        if self._report is not None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(self._report)))

    def show_idle(self, text: str = "", *, again: bool = False) -> None:
        """Take orders; `again` when there is a batch to go on with."""
        self.form.setEnabled(True)
        self.go.setText(tr("Res&ume") if again else tr("&Start"))
        self.note.setText(text)
        self.progress.setVisible(again)
        self.report.setEnabled(self._report is not None and os.path.exists(self._report))
        self._show_bad()
        self._allow()

    def show_running(self) -> None:
        """Take no orders until it is over."""
        self.form.setEnabled(False)
        self.bad.clear()
        self._show_bad()
        self.progress.setRange(0, 0)
        self.progress.show()
        self.note.setText(tr("Looking for photos…"))
        self.go.setText(tr("S&top"))
        self.go.setEnabled(True)

    def show_progress(self, progress: BatchProgress, *, stopping: bool) -> None:
        """Show how many photos are done and how long the rest will take."""
        self.progress.setRange(0, max(1, progress.total))
        self.progress.setValue(progress.finished)
        self.report.setEnabled(True)
        if not stopping:
            self.note.setText(progress.line)

    def show_bad(self, outcome: Outcome) -> None:
        """Add a photo that couldn't be done, with its sentence."""
        is_named = outcome.reason.startswith(outcome.source)
        why = translated(outcome.reason)
        self.bad.addItem(why if is_named else f"{outcome.source}: {why}")
        self._show_bad()

    def _show_bad(self) -> None:
        for widget in (self.bad, self._bad_title):
            widget.setVisible(self.bad.count() > 0)


def _framed_list() -> QListWidget:
    """Return a list in a frame, whose long lines are wrapped."""
    rows = QListWidget()
    rows.setProperty("framed", "true")
    rows.setMinimumHeight(_LIST_PX)
    rows.setWordWrap(True)
    rows.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    rows.setSelectionMode(QListWidget.SelectionMode.ExtendedSelection)
    return rows
