"""The batch dialog: the order above, and below it how far it is."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QUrl, Signal
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QDialog, QLabel, QProgressBar, QPushButton, QWidget

from kogao_core.batch import Outcome

from ...i18n import tr
from ...theme import GRID_PX
from ...widgets.controls import column_of
from .order import OrderForm, button, framed_list, named, row_of
from .run import BatchProgress


class BatchDialog(QDialog):
    """Takes the order for a batch and follows it.

    Signals
    -------
    wanted(Order)
        Begin, or go on.
    stopped
        Hand out no more photos.
    """

    wanted = Signal(object)
    stopped = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Batch"))
        self._report: Path | None = None
        self.form = OrderForm()
        self.form.changed.connect(self._allow)
        self.progress = QProgressBar()
        self.progress.setAccessibleName(tr("Progress"))
        self.progress.setTextVisible(False)
        self.note = QLabel()
        self.note.setWordWrap(True)
        self.bad = framed_list()
        self.go = QPushButton(tr("&Start"))
        self.go.setDefault(True)
        self.go.clicked.connect(self._go)
        self.report = button(tr("Open the &report"), self._open_report)
        self.report.setToolTip(tr("One line a photo, with what became of it"))
        self._lay_out()
        self.show_idle()
        self.resize(560, 620)

    def _lay_out(self) -> None:
        self._bad_title = named(tr("&Not done"), self.bad)
        column = column_of(self, margin=4 * GRID_PX, spacing=2 * GRID_PX)
        column.addWidget(self.form, 3)
        for widget in (self.progress, self.note, self._bad_title):
            column.addWidget(widget)
        column.addWidget(self.bad, 2)
        column.addLayout(row_of(self.report, None, button(tr("Close"), self.close), self.go))

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
        self.report.setEnabled(self._report is not None and self._report.exists())
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
            self.note.setText(progress_line(progress))

    def show_bad(self, outcome: Outcome) -> None:
        """Add a photo that couldn't be done, with its sentence."""
        is_named = outcome.reason.startswith(outcome.source)
        self.bad.addItem(outcome.reason if is_named else f"{outcome.source}: {outcome.reason}")
        self._show_bad()

    def _show_bad(self) -> None:
        for widget in (self.bad, self._bad_title):
            widget.setVisible(self.bad.count() > 0)


def progress_line(progress: BatchProgress) -> str:
    """Return how far a batch is, in words."""
    words = {
        "done": tr("done"),
        "skipped": tr("done before"),
        "no face": tr("without a face"),
        "failed": tr("failed"),
    }
    counts = [f"{progress.counts[kind]} {words[kind]}" for kind in words if progress.counts[kind]]
    parts = [tr("{n} of {total}", n=progress.finished, total=progress.total), *counts]
    left = progress.left_s
    if left is not None:
        soon = left < 90.0
        parts.append(
            tr("about {n:.0f} s left", n=left)
            if soon
            else tr("about {n:.0f} min left", n=left / 60)
        )
    return " · ".join(parts)
