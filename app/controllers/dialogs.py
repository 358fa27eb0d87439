"""Dialogs for files, and the question before unsaved changes are lost. None stops the program."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from kogao_core.photo import FORMATS, READABLE
from kogao_core.project import Project
from kogao_core.sidecar import SUFFIX

from ..document import Document
from ..i18n import tr
from ..photos import is_sample
from ..projects import Work, is_project
from .files import Files
from .projects import Projects
from .saver import Saver, Then


class Dialogs(QObject):
    """Asks for names and permission, and passes the answers on to `Files`.

    Signals
    -------
    folder_chosen(Path)
        A folder of photos is wanted.
    """

    folder_chosen = Signal(object)

    def __init__(self, document: Document, files: Files, saver: Saver, window: QWidget) -> None:
        super().__init__(window)
        self._document, self._files, self._saver = document, files, saver
        self._window = window
        self._projects: Projects | None = None
        files.wants_open.connect(self.ask_open)
        files.wants_save.connect(self.ask_save)
        files.wants_leave.connect(self.guard)
        saver.wants_leave.connect(self.guard)

    def ask_open(self) -> None:
        """Ask which photo to open."""
        dialog = self._dialog(tr("Open a photo"), f"*{SUFFIX}")
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
        """Open a photo or a project once unsaved changes are dealt with."""
        # Recent files and recovery outlive the folder that this program was started in.
        path = path.absolute()
        projects = self._projects
        if projects is not None and is_project(path):
            self.guard(lambda: projects.open(path))
        else:
            self.guard(lambda: self._files.open(path))

    def open_sample(self) -> None:
        """Open the sample once unsaved changes are dealt with."""
        self.guard(self._files.open_sample)

    def ask_save(self) -> None:
        """Ask where the copy goes; a name beside the original is suggested."""
        self._ask_copy(None)

    def _ask_copy(self, then: Then | None) -> None:
        suggested = self._files.suggested()
        if suggested is None:
            return
        dialog = self._save_dialog(tr("Save a copy"), formats=FORMATS)
        dialog.setDirectory(str(suggested.parent))
        dialog.selectFile(suggested.name)
        dialog.setDefaultSuffix(suggested.suffix.lstrip("."))
        dialog.fileSelected.connect(lambda name: self._files.save(Path(name), then))
        dialog.open()

    def take_projects(self, projects: Projects) -> None:
        """Ask on behalf of these, too."""
        self._projects = projects
        projects.wants_place.connect(self._ask_place)
        projects.wants_photo.connect(self._ask_photo)

    def _ask_place(self, suggested: Path, then: Then | None) -> None:
        projects = self._projects
        if projects is None:
            return
        dialog = self._save_dialog(tr("Save the project"))
        dialog.setNameFilter(tr("Projects ({patterns})", patterns=f"*{SUFFIX}"))
        dialog.setDirectory(str(suggested.parent))
        dialog.selectFile(suggested.name)
        # The dialog has asked before replacing a file.
        dialog.fileSelected.connect(lambda name: projects.save_to(Path(name), then, replace=True))
        dialog.open()

    def _ask_photo(self, file: Path, project: Project) -> None:
        dialog = self._dialog(tr("Which photo is {name} about?", name=file.name))
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.setDirectory(str(file.parent))
        dialog.fileSelected.connect(lambda name: self._files.open(Path(name), Work(project, file)))
        dialog.open()

    def guard(self, then: Then) -> None:
        """Do `then` at once, or after the user has saved or discarded unsaved changes."""
        self._saver.forget()
        if not self._document.dirty:
            then()
            return
        buttons = QMessageBox.StandardButton
        box = QMessageBox(self._window)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(tr("Save before the changes are lost?"))
        lines = [
            tr("A copy is the finished picture; a project keeps points and settings to go on with.")
        ]
        if self._document.state.draft:
            lines.append(tr("Points of a face that isn't complete yet are in neither."))
        box.setInformativeText("\n".join(lines))
        box.setStandardButtons(buttons.Save | buttons.Discard | buttons.Cancel)
        box.button(buttons.Save).setText(tr("&Save a copy…"))
        if self._projects is not None:
            project = box.addButton(tr("Save &project"), QMessageBox.ButtonRole.AcceptRole)
            project.clicked.connect(lambda: self._save_project(then))
        box.setDefaultButton(buttons.Save)
        box.finished.connect(lambda answer: self._answer(answer, then))
        # It was asked about the photo that was open.
        self._document.opened.connect(box.reject)
        box.open()

    def confirm(self, text: str, act: str, then: Then) -> None:
        """Do `then` only if the user agrees to `act`; Escape and Enter don't."""
        box = QMessageBox(self._window)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Warning)
        box.setText(text)
        agree = box.addButton(act, QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
        agree.clicked.connect(lambda: then())
        box.open()

    def _save_project(self, then: Then) -> None:
        if self._projects is not None:
            self._projects.save(then)

    def _answer(self, answer: int, then: Then) -> None:
        buttons = QMessageBox.StandardButton
        if answer == buttons.Discard.value:
            then()
        elif answer == buttons.Save.value:
            self._ask_copy(then)

    def _save_dialog(self, title: str, formats: Iterable[str] = READABLE) -> QFileDialog:
        self._saver.forget()
        dialog = self._dialog(title, formats=formats)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        # The name is for the photo that is open now, and for no other.
        self._document.opened.connect(dialog.reject)
        return dialog

    def _dialog(self, title: str, *more: str, formats: Iterable[str] = READABLE) -> QFileDialog:
        dialog = QFileDialog(self._window, title)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        path = self._document.path
        if path is not None and not is_sample(path):
            dialog.setDirectory(str(path.parent))
        patterns = " ".join((*(f"*{suffix}" for suffix in formats), *more))
        dialog.setNameFilter(tr("Photos ({patterns})", patterns=patterns))
        return dialog
