"""Dialogs for files, and the question before unsaved changes are lost. None stops the program."""

from __future__ import annotations

from collections.abc import Callable, Iterable
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
        self._projects: Projects | None = None
        self._after_saving: Then | None = None
        files.wants_open.connect(self.ask_open)
        files.wants_save.connect(self._ask_copy)
        files.wants_leave.connect(self.guard)
        files.saved.connect(self._go_on)

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
        # An earlier save that failed may have stood in the way of closing; this one doesn't.
        self._forget()
        self._ask_copy()

    def _ask_copy(self) -> None:
        suggested = self._files.suggested()
        if suggested is None:
            return
        dialog = self._dialog(tr("Save a copy"), formats=FORMATS)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setDirectory(str(suggested.parent))
        dialog.selectFile(suggested.name)
        dialog.setDefaultSuffix(suggested.suffix.lstrip("."))
        dialog.fileSelected.connect(lambda name: self._files.save(Path(name)))
        dialog.rejected.connect(self._forget)
        dialog.open()

    def take_projects(self, projects: Projects) -> None:
        """Ask on behalf of these, too."""
        self._projects = projects
        projects.wants_place.connect(self._ask_place)
        projects.wants_photo.connect(self._ask_photo)
        projects.saved.connect(self._go_on)
        # What it says stands in the way: a save much later must not close the window.
        projects.said.connect(self._forget)

    def _ask_place(self, suggested: Path) -> None:
        projects = self._projects
        if projects is None:
            return
        dialog = self._dialog(tr("Save the project"))
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilter(tr("Projects ({patterns})", patterns=f"*{SUFFIX}"))
        dialog.setDirectory(str(suggested.parent))
        dialog.selectFile(suggested.name)
        # The dialog has asked before replacing a file.
        dialog.fileSelected.connect(lambda name: projects.save_to(Path(name), replace=True))
        dialog.rejected.connect(self._forget)
        dialog.open()

    def _ask_photo(self, file: Path, project: Project) -> None:
        dialog = self._dialog(tr("Which photo is {name} about?", name=file.name))
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.setDirectory(str(file.parent))
        dialog.fileSelected.connect(lambda name: self._files.open(Path(name), Work(project, file)))
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
        box.setText(tr("Save before the changes are lost?"))
        box.setInformativeText(
            tr("A copy is the finished picture; a project keeps points and settings to go on with.")
        )
        box.setStandardButtons(buttons.Save | buttons.Discard | buttons.Cancel)
        box.button(buttons.Save).setText(tr("&Save a copy…"))
        if self._projects is not None:
            project = box.addButton(tr("Save &project"), QMessageBox.ButtonRole.AcceptRole)
            project.clicked.connect(lambda: self._save_project(then))
        box.setDefaultButton(buttons.Save)
        box.finished.connect(lambda answer: self._answer(answer, then))
        box.open()

    def _save_project(self, then: Then) -> None:
        if self._projects is not None:
            self._after_saving = then
            self._projects.save()

    def _answer(self, answer: int, then: Then) -> None:
        buttons = QMessageBox.StandardButton
        if answer == buttons.Discard.value:
            then()
        elif answer == buttons.Save.value:
            self._after_saving = then
            self._ask_copy()

    def _go_on(self) -> None:
        then, self._after_saving = self._after_saving, None
        if then is not None:
            then()

    def _forget(self) -> None:
        self._after_saving = None

    def _dialog(self, title: str, *more: str, formats: Iterable[str] = READABLE) -> QFileDialog:
        dialog = QFileDialog(self._window, title)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        path = self._document.path
        if path is not None and not is_sample(path):
            dialog.setDirectory(str(path.parent))
        patterns = " ".join((*(f"*{suffix}" for suffix in formats), *more))
        dialog.setNameFilter(tr("Photos ({patterns})", patterns=patterns))
        return dialog
