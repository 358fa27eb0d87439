"""Non-blocking dialogs: each calls a callback with the answer."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Literal

from PySide6.QtCore import QMimeData, QSize, Qt, QUrl
from PySide6.QtGui import QDesktopServices, QShowEvent
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
from .controls import column_of, name_buttons, row_of

_MARGIN_PX = 60  # space for title bar and task bar
_LINE_PX = 18  # line height for which dialog sizes are given


def photo_filter(formats: Iterable[str] = READABLE, *more: str) -> str:
    """Return a file dialog filter for photo suffixes and other patterns."""
    patterns = " ".join((*(f"*{suffix}" for suffix in formats), *more))
    return tr("Photos ({patterns})", patterns=patterns)


class Dialog(QDialog):
    """A dialog that is deleted on close and grows with the text.

    Parameters
    ----------
    title : str
        Window title.
    parent : QWidget
        The window.
    size_px : (int, int)
        Width and height at a line height of 18 px; scaled with the font, limited by the screen.
    """

    def __init__(self, title: str, parent: QWidget, size_px: tuple[int, int]) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(title)
        grown = max(1.0, self.fontMetrics().height() / _LINE_PX)
        self.resize((QSize(*size_px) * grown).boundedTo(room(parent)))

    def closing(self) -> QDialogButtonBox:
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        return buttons

    def deciding(self, take: Callable[[], object]) -> QDialogButtonBox:
        """Return a button row with OK, which calls `take`, and Cancel."""
        kinds = QDialogButtonBox.StandardButton
        buttons = QDialogButtonBox(kinds.Ok | kinds.Cancel)
        buttons.accepted.connect(take)
        buttons.rejected.connect(self.reject)
        return buttons

    def showEvent(self, event: QShowEvent) -> None:
        """Grow until no line is cut: Qt computes the height for a wider dialog."""
        name_buttons(self)
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
    """Request a path with the native dialog if Qt supports it, else with Qt's dialog.

    All paths chosen by users pass through this function. Callers may use only `reject` and
    `rejected` of the returned dialog: native dialogs have no more.
    """
    dialog = QFileDialog(parent, title)
    # Qt's catalogues have no translation for these two texts.
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
                # The native dialog confirmed the typed name only, without the suffix.
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
    """Return a message box without buttons; call `open` to show it."""
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setIcon(icon)
    box.setText(text)
    return box


def confirm(parent: QWidget, text: str, act: str, then: Callable[[], object]) -> None:
    """Call `then` if the user clicks `act`; Escape and Enter cancel."""
    box = question(parent, text, QMessageBox.Icon.Warning)
    agree = box.addButton(act, QMessageBox.ButtonRole.DestructiveRole)
    box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
    agree.clicked.connect(lambda: then())
    box.open()


def ask_name(parent: QWidget, title: str, label: str, taken: Callable[[str], object]) -> None:
    """Request a name and pass it to `taken`."""
    dialog = QInputDialog(parent)
    dialog.setWindowTitle(title)
    dialog.setLabelText(label)
    dialog.textValueSelected.connect(taken)
    dialog.open()
    for line in dialog.findChildren(QLineEdit):
        line.setAccessibleName(label)


def button(text: str, slot: Callable[[], object]) -> QPushButton:
    """Return a button that Return in another field doesn't press."""
    made = QPushButton(text)
    made.setAutoDefault(False)
    made.clicked.connect(slot)
    return made


def open_path(path: Path) -> None:
    """Open a file or folder with the desktop's default program."""
    QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))


def files_in(data: QMimeData) -> list[Path]:
    """Return the local files and folders of dropped data."""
    return [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile()]


class PathLine(QWidget):
    """A field for the path of a folder, with a button for a file dialog."""

    def __init__(self, title: str, path: str) -> None:
        super().__init__()
        self._title = title
        self.line = QLineEdit(path)
        self.line.setAcceptDrops(False)  # Qt would insert a URL
        self.line.setAccessibleName(title)
        self.line.setPlaceholderText(title)
        self.choose = button(tr("Choose…"), self._ask)
        self.choose.setAccessibleName(tr("{title}, choose", title=title))
        column_of(self, row_of(self.line, self.choose))

    @property
    def path(self) -> str:
        """The text of the field without surrounding spaces."""
        return self.line.text().strip()

    def _ask(self) -> None:
        at = Path(self.path) if os.path.exists(self.path) else None
        ask_path(self, self._title, lambda one: self.line.setText(str(one)), "folder", at=at)


def ask_choice(
    parent: QWidget, text: str, about: str, answers: Mapping[str, Callable[[], object]]
) -> QMessageBox:
    """Return a question with a button for each answer and Cancel, to open."""
    box, kinds = question(parent, text), QMessageBox.ButtonRole
    box.setInformativeText(about)
    for title, answer in answers.items():
        button = box.addButton(title, kinds.AcceptRole)
        button.clicked.connect(lambda _=False, answer=answer: answer())
    box.setEscapeButton(box.addButton(QMessageBox.StandardButton.Cancel))
    return box


def room(window: QWidget) -> QSize:
    """Return the maximum window size on the screen of `window`."""
    return window.screen().availableSize() - QSize(_MARGIN_PX, _MARGIN_PX)


def table(
    title: str,
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    widths: QHeaderView.ResizeMode = QHeaderView.ResizeMode.Stretch,
) -> QTableWidget:
    """Return a read-only table: text in the first column, numbers in the others."""
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
