"""Landmarks from other programs and for them: the File menu's import and export."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QFileDialog

from kogao_core import interchange
from kogao_core.face import Face
from kogao_core.strict import BadFile

from .. import actions
from ..controllers.editing import Editing
from ..document import Document
from ..i18n import tr
from ..views.bar import Message
from ..views.window import Window


class InterchangePart(QObject):
    """Asks for files and passes points between them and the document.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    """

    said = Signal(object)

    def __init__(
        self, document: Document, editing: Editing, window: Window, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._document, self._editing, self._window = document, editing, window
        actions.connect(
            window.actions_by_name,
            {"import-landmarks": self.ask_import, "export-landmarks": self.ask_export},
        )
        document.changed.connect(self._show)
        self._show()

    def ask_import(self) -> None:
        """Ask for a file of points."""
        dialog = QFileDialog(self._window, tr("Import landmarks"))
        endings = " ".join(f"*{form.suffix}" for form in interchange.FORMATS.values())
        dialog.setNameFilter(tr("Landmarks ({endings})", endings=endings))
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.fileSelected.connect(lambda name: self.import_file(Path(name)))
        dialog.open()

    def import_file(self, path: Path) -> None:
        """Take a file's faces in place of the present ones, as one undo step."""
        try:
            faces = interchange.read(path)
            interchange.check_inside(faces, self._document.image)
        except BadFile as problem:
            self.said.emit(Message(f"{problem}."))
            return
        # Into the mode at work: points by hand may come from a file as well.
        state = dataclasses.replace(self._document.state, faces=tuple(faces), off=frozenset())
        self._editing.step(state, tr("Import landmarks"))
        self._window.status.hint(tr("Landmarks from {name}", name=path.name))

    def ask_export(self) -> None:
        """Ask where to write the points; the chosen kind tells the format."""
        dialog = QFileDialog(self._window, tr("Export landmarks"))
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        forms = {f"{form.title} (*{form.suffix})": form for form in interchange.FORMATS.values()}
        dialog.setNameFilters(list(forms))
        dialog.filterSelected.connect(lambda kind: dialog.setDefaultSuffix(forms[kind].name))
        dialog.setDefaultSuffix(next(iter(forms.values())).name)
        if self._document.path is not None:
            dialog.setDirectory(str(self._document.path.parent))
            dialog.selectFile(self._document.path.stem)
        dialog.fileSelected.connect(lambda name: self.export_file(Path(name)))
        dialog.open()

    def export_file(self, path: Path) -> None:
        """Write the faces' points; several faces take a file each where the format holds one."""
        faces = self._faces()
        try:
            # The dialog has asked about the first file only.
            there = [file for file in interchange.files(path, faces)[1:] if file.exists()]
            if there:
                raise BadFile(tr("{name} is there already", name=there[0].name))
            written = interchange.write(faces, path)
        except BadFile as problem:
            self.said.emit(Message(f"{problem}."))
        except OSError as problem:
            reason = problem.strerror or str(problem)
            text = tr("{path} can't be written ({reason}).", path=path, reason=reason)
            self.said.emit(Message(text))
        else:
            notes = {one.note for one in written if one.note}
            text = tr("Landmarks written to {name}", name=path.name)
            self._window.status.hint("; ".join([text, *sorted(notes)]))

    def _faces(self) -> list[Face]:
        return list(self._document.state.faces)

    def _show(self) -> None:
        opened = self._document.photo is not None
        named = self._window.actions_by_name
        named["import-landmarks"].setEnabled(opened)
        named["export-landmarks"].setEnabled(opened and bool(self._faces()))
