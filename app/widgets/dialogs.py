"""Dialogs that never stop the program: each calls what was asked for once there is an answer."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Literal

from PySide6.QtCore import QMimeData, QSize, Qt
from PySide6.QtGui import QDragEnterEvent, QDropEvent, QShowEvent
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QHeaderView,
    QInputDialog,
    QLineEdit,
    QMessageBox,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from kogao_core.photo import READABLE

from ..i18n import tr
from .controls import column_of, row_of

_MARGIN_PX = 60  # what a title bar and a task bar take
_LINE_PX = 18  # a line of text for which sizes are given


def photo_filter(formats: Iterable[str] = READABLE, *more: str) -> str:
    """Return the filter of a dialog for photos: their endings, and other patterns."""
    patterns = " ".join((*(f"*{suffix}" for suffix in formats), *more))
    return tr("Photos ({patterns})", patterns=patterns)


class Dialog(QDialog):
    """A dialog that is gone once it is closed, and as large as its texts need.

    Parameters
    ----------
    title : str
        What it is called.
    parent : QWidget
        The window.
    size_px : (int, int)
        Width and height for small text; it grows with larger one, as far as the screen has room.
    """

    def __init__(self, title: str, parent: QWidget, size_px: tuple[int, int]) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(title)
        grown = max(1.0, self.fontMetrics().height() / _LINE_PX)
        self.resize((QSize(*size_px) * grown).boundedTo(room(parent)))

    def closing(self) -> QDialogButtonBox:
        """Return the row of buttons of a dialog that is only closed."""
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        return buttons

    def deciding(self, take: Callable[[], object]) -> QDialogButtonBox:
        """Return the row of buttons of a dialog whose answer is taken, or not."""
        kinds = QDialogButtonBox.StandardButton
        buttons = QDialogButtonBox(kinds.Ok | kinds.Cancel)
        buttons.accepted.connect(take)
        buttons.rejected.connect(self.reject)
        return buttons

    def present(self) -> None:
        """Show it, in front and with the focus."""
        self.show()
        self.raise_()
        self.activateWindow()

    def showEvent(self, event: QShowEvent) -> None:
        """Grow until no line is cut: Qt reckons with the lines that a wider dialog would have."""
        layout = self.layout()
        if layout is not None:
            layout.activate()
            least = layout.totalMinimumSize()
            width = max(self.width(), least.width())
            height = max(least.height(), layout.totalMinimumHeightForWidth(width))
            self.resize(width, max(self.height(), height))
        super().showEvent(event)


def ask_path(
    parent: QWidget,
    title: str,
    taken: Callable[[Path], object],
    kind: Literal["file", "files", "folder", "new"] = "file",
    *,
    filters: Sequence[str] = (),
    endings: Sequence[str] = (),
    at: Path | None = None,
) -> QFileDialog:
    """Ask for a path, by the desktop's own dialog where Qt knows it, else by Qt's.

    Every path that a user chooses comes through here. Of the dialog itself callers use no more than
    `reject` and `rejected`: of the desktop's there is no more.
    """
    dialog = QFileDialog(parent, title)
    # Qt's own catalogues lack these two.
    dialog.setLabelText(QFileDialog.DialogLabel.LookIn, tr("&Look in:"))
    dialog.setLabelText(QFileDialog.DialogLabel.FileType, tr("Files of &type:"))
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    if kind == "new":
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    else:
        modes = QFileDialog.FileMode
        known = {"folder": modes.Directory, "files": modes.ExistingFiles}
        dialog.setFileMode(known.get(kind, modes.ExistingFile))
    dialog.setNameFilters(list(filters))
    if at is not None:
        dialog.setDirectory(str(at if os.path.isdir(at) else at.parent))
        if not os.path.isdir(at):
            dialog.selectFile(at.name)
    ending = dict(zip(filters, endings, strict=True)) if endings else {}

    def take(names: Sequence[str]) -> None:
        for path in map(Path, names):
            whole = path.with_name(path.name + ending.get(dialog.selectedNameFilter(), ""))
            if path.suffix or whole == path:
                taken(path)
            elif os.path.exists(whole):
                # The dialog has asked about the name as it was typed.
                text = tr("{name} is there already. Replace it?", name=whole.name)
                confirm(parent, text, tr("&Replace"), partial(taken, whole))
            else:
                taken(whole)

    dialog.filesSelected.connect(take)
    dialog.open()
    return dialog


def question(
    parent: QWidget, text: str, icon: QMessageBox.Icon = QMessageBox.Icon.Question
) -> QMessageBox:
    """Return a box that is yet to get its buttons; `open` shows it."""
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setIcon(icon)
    box.setText(text)
    return box


def confirm(parent: QWidget, text: str, act: str, then: Callable[[], object]) -> None:
    """Do `then` only if the user agrees to `act`; Escape and Enter don't."""
    box = question(parent, text, QMessageBox.Icon.Warning)
    agree = box.addButton(act, QMessageBox.ButtonRole.DestructiveRole)
    box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
    agree.clicked.connect(lambda: then())
    box.open()


def ask_name(parent: QWidget, title: str, label: str, taken: Callable[[str], object]) -> None:
    """Ask for a name."""
    dialog = QInputDialog(parent)
    dialog.setWindowTitle(title)
    dialog.setLabelText(label)
    dialog.textValueSelected.connect(taken)
    dialog.open()
    for line in dialog.findChildren(QLineEdit):
        line.setAccessibleName(label)


def button(text: str, slot: Callable[[], object]) -> QPushButton:
    """Return a button that the Return key elsewhere doesn't press."""
    made = QPushButton(text)
    made.setAutoDefault(False)
    made.clicked.connect(slot)
    return made


def files_in(data: QMimeData) -> list[Path]:
    """Return the files and folders of this computer among what is dropped."""
    return [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile()]


class PathEdit(QLineEdit):
    """A line for a path; a file or folder that is dropped on it gives its own."""

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept files, besides text."""
        super().dragEnterEvent(event)
        if files_in(event.mimeData()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Take the first file or folder, else the text."""
        files = files_in(event.mimeData())
        if files:
            self.setText(str(files[0]))
            event.acceptProposedAction()
        else:
            super().dropEvent(event)


class PathLine(QWidget):
    """A line for a path, and a button to look for one."""

    def __init__(
        self,
        title: str,
        path: str,
        filters: Sequence[str] = (),
        kind: Literal["file", "folder"] = "file",
    ) -> None:
        super().__init__()
        self._title, self._filters, self._kind = title, filters, kind
        self.line = PathEdit(path)
        self.line.setAccessibleName(title)
        self.line.setPlaceholderText(title)
        self.choose = button(tr("Choose…"), self._ask)
        self.choose.setAccessibleName(tr("{title}, choose", title=title))
        column_of(self, row_of(self.line, self.choose))

    @property
    def path(self) -> str:
        """What is in the line."""
        return self.line.text().strip()

    def _ask(self) -> None:
        at = Path(self.path) if os.path.exists(self.path) else None
        put = self.line.setText
        ask_path(
            self, self._title, lambda it: put(str(it)), self._kind, filters=self._filters, at=at
        )


def room(window: QWidget) -> QSize:
    """Return how large a window may be on the screen of another one, or on its own."""
    return window.screen().availableSize() - QSize(_MARGIN_PX, _MARGIN_PX)


def table(
    title: str,
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    widths: QHeaderView.ResizeMode = QHeaderView.ResizeMode.Stretch,
) -> QTableWidget:
    """Return a table to read: texts in its first column, figures in the others."""
    made = QTableWidget(len(rows), len(head))
    made.setAccessibleName(title)
    made.setHorizontalHeaderLabels(list(head))
    made.verticalHeader().hide()
    made.setEditTriggers(QTableWidget.EditTrigger.NoEditTriggers)
    made.horizontalHeader().setSectionResizeMode(widths)
    for row, cells in enumerate(rows):
        for column, text in enumerate(cells):
            item = QTableWidgetItem(text)
            if column:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            made.setItem(row, column, item)
    return made
