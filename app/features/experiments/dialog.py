"""Window of an experiment: progress, then tables and report."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QDialogButtonBox,
    QHeaderView,
    QProgressBar,
    QPushButton,
    QScrollArea,
    QTableWidget,
    QVBoxLayout,
    QWidget,
)

from ...i18n import tr
from ...theme import GRID_PX
from ...widgets.controls import column_of, heading, muted_label, row_of
from ...widgets.dialogs import Dialog, table

if TYPE_CHECKING:
    from kogao_core.lab.reports.report import Table

_SIZE_PX: Final = (900, 680)


@dataclass(frozen=True, eq=False)
class Findings:
    """Results of an experiment."""

    name: str  # which one
    lead: str  # the question, as one sentence
    tables: list[Table]
    left_out: list[str] = field(default_factory=list)  # sentences about photos and methods left out
    # The report by kind of file: html, json and csv.
    texts: dict[str, str] = field(default_factory=dict)


class ExperimentDialog(Dialog):
    """Shows the progress and the results of an experiment."""

    def __init__(self, title: str, parent: QWidget, settings: str) -> None:
        super().__init__(title, parent, _SIZE_PX)
        self.settings = muted_label(settings, wraps=True)
        self.paper = QPushButton(tr("Repeat with the &paper's settings"))
        row = row_of(self.settings, None, self.paper)
        self.progress = QProgressBar()
        self.progress.setAccessibleName(tr("Progress"))
        self.progress.setTextVisible(False)
        self.state = muted_label(tr("Measuring…"), wraps=True)
        self.tables: list[QTableWidget] = []
        self._page = QVBoxLayout()
        self._page.setSpacing(3 * GRID_PX)
        page = _scrolled(self._page)
        content = heading(title), row, self.state, self.progress, page, self._buttons()
        column = column_of(self, *content, margin=4 * GRID_PX, spacing=3 * GRID_PX)
        column.setStretchFactor(page, 1)

    def show_progress(self, done: int, of: int) -> None:
        """Show the number of finished runs."""
        self.progress.setRange(0, of)
        self.progress.setValue(done)

    def show_findings(self, findings: Findings) -> None:
        """Show the results in place of the progress."""
        self.progress.hide()
        self.state.setText("\n".join([findings.lead, *findings.left_out]))
        for content in findings.tables:
            caption = heading(content.caption)
            caption.setWordWrap(True)
            self._page.addWidget(caption)
            self.tables.append(_table(content))
            self._page.addWidget(self.tables[-1])
            if content.note:
                self._page.addWidget(muted_label(content.note, wraps=True))
        self._page.addStretch()
        for button in (self.in_browser, self.to_file):
            button.setEnabled(True)

    def show_failure(self, sentence: str) -> None:
        self.progress.hide()
        self.state.setText(sentence)

    def _buttons(self) -> QDialogButtonBox:
        buttons = self.closing()
        role = QDialogButtonBox.ButtonRole.ActionRole
        self.in_browser = buttons.addButton(tr("Open in a &browser"), role)
        self.to_file = buttons.addButton(tr("&Save the report…"), role)
        for button in (self.in_browser, self.to_file):
            button.setEnabled(False)
        return buttons


def _scrolled(page: QVBoxLayout) -> QScrollArea:
    inside, area = QWidget(), QScrollArea()
    inside.setLayout(page)
    page.setContentsMargins(0, 0, 2 * GRID_PX, 0)
    area.setWidgetResizable(True)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    area.setAccessibleName(tr("Results"))
    area.setWidget(inside)
    return area


def _table(content: Table) -> QTableWidget:
    made = table(
        content.caption, content.header, content.rows, QHeaderView.ResizeMode.ResizeToContents
    )
    made.setWordWrap(False)
    rows_px = sum(made.rowHeight(row) for row in range(len(content.rows)))
    bar_px = made.horizontalScrollBar().sizeHint().height()
    made.setFixedHeight(made.horizontalHeader().sizeHint().height() + rows_px + bar_px + 4)
    made.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    return made
