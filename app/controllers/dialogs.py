"""Dialogs for files, and the question before unsaved changes are lost. None stops the program."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from kogao_core.photo import FORMATS

from ..document import Document
from ..i18n import tr
from .files import Files

Then = Callable[[], object]


class Dialogs(QObject):
    """Asks for names and permission, and passes the answers on to `Files`.

    Signals
    -------
    folder_chosen(Path)
        A folder of photos is wanted.
    """

    folder_chosen = Signal(object)

    def __init__(self, document: Document, files: Files, window: QWidget) -> None:
        super().__init__(window)
        self._document, self._files, self._window = document, files, window
        self._after_saving: Then | None = None
        files.wants_open.connect(self.ask_open)
        files.wants_save.connect(self.ask_save)
        files.saved.connect(self._go_on)

    def ask_open(self) -> None:
        """Ask which photo to open."""
        dialog = self._dialog(tr("Open a photo"))
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.fileSelected.connect(lambda name: self.open(Path(name)))
        dialog.open()

    def ask_folder(self) -> None:
        """Ask for a folder of photos."""
        dialog = self._dialog(tr("Open a folder"))
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.fileSelected.connect(lambda name: self.folder_chosen.emit(Path(name)))
        dialog.open()

    def open(self, path: Path) -> None:
        """Open a photo once unsaved changes are dealt with."""
        self.guard(lambda: self._files.open(path))

    def open_sample(self) -> None:
        """Open the sample once unsaved changes are dealt with."""
        self.guard(self._files.open_sample)

    def ask_save(self) -> None:
        """Ask where the copy goes; a name beside the original is suggested."""
        suggested = self._files.suggested()
        if suggested is None:
            return
        dialog = self._dialog(tr("Save a copy"))
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setDirectory(str(suggested.parent))
        dialog.selectFile(suggested.name)
        dialog.setDefaultSuffix(suggested.suffix.lstrip("."))
        dialog.fileSelected.connect(lambda name: self._files.save(Path(name)))
        dialog.rejected.connect(self._forget)
        dialog.open()

    def guard(self, then: Then) -> None:
        """Do `then` at once, or after the user has saved or discarded unsaved changes."""
        if self._document.undo.isClean() and not self._document.in_gesture:
            then()
            return
        buttons = QMessageBox.StandardButton
        box = QMessageBox(self._window)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(tr("Save a copy before the changes are lost?"))
        box.setStandardButtons(buttons.Save | buttons.Discard | buttons.Cancel)
        box.button(buttons.Save).setText(tr("&Save a copy…"))
        box.setDefaultButton(buttons.Save)
        box.finished.connect(lambda answer: self._answer(buttons(answer), then))
        box.open()

    def _answer(self, answer: QMessageBox.StandardButton, then: Then) -> None:
        if answer == QMessageBox.StandardButton.Discard:
            then()
        elif answer == QMessageBox.StandardButton.Save:
            self._after_saving = then
            self.ask_save()

    def _go_on(self) -> None:
        then, self._after_saving = self._after_saving, None
        if then is not None:
            then()

    def _forget(self) -> None:
        self._after_saving = None

    def _dialog(self, title: str) -> QFileDialog:
        dialog = QFileDialog(self._window, title)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        patterns = " ".join(f"*{suffix}" for suffix in FORMATS)
        dialog.setNameFilter(tr("Photos ({patterns})", patterns=patterns))
        return dialog
