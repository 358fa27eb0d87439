"""The project file of the open photo: written beside it, and taken up again with it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, QThreadPool, Signal

from kogao_core import sidecar
from kogao_core.photo import Photo
from kogao_core.project import Project, save

from ..document import Document
from ..i18n import reason, sentence, tr
from ..photos import is_sample
from ..projects import Work, is_project, opened_with, to_keep_beside
from ..views.bar import Message, Step
from ..workers import Lane
from .editing import Editing
from .files import Files


class Projects(QObject):
    """Saves what was done to the open photo, and opens photos by their project files.

    Parameters
    ----------
    document, editing, files : Document, Editing, Files
        What is saved, who ends a gesture before it, and who opens photos.
    guard : callable
        Asks before unsaved changes are lost, then calls its argument.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    working(str)
        What is under way.
    saved(Path)
        The project has been written.
    wants_place(Path)
        The user has to choose where the project goes; this name is suggested.
    wants_photo(Path, Project)
        The user has to say which photo this project file is about.
    """

    said = Signal(object)
    working = Signal(str)
    saved = Signal(object)
    wants_place = Signal(object)
    wants_photo = Signal(object, object)

    def __init__(
        self,
        document: Document,
        editing: Editing,
        files: Files,
        guard: Callable[[Callable[[], object]], None],
        pool: QThreadPool,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._document, self._editing, self._files = document, editing, files
        self._guard = guard
        # What was read from there, or written there, may be written over without a question.
        self._own: Path | None = None
        self._loading = Lane(pool, lambda problem: self._refuse(sentence(problem)), self)
        self._loading.done.connect(self._loaded)
        self._writing = Lane(pool, self._not_written, self)
        self._writing.done.connect(self._written)
        document.opened.connect(self._forget)
        files.restored.connect(self._take_up)

    @property
    def busy(self) -> bool:
        """True while a project is read or written."""
        return self._loading.busy or self._writing.busy

    def stop(self) -> None:
        """Start nothing more."""
        self._loading.drop()
        self._writing.drop()

    # -- saving ----------------------------------------------------------------------------------

    def save(self) -> None:
        """Write the project beside its photo; ask where that isn't ours to write."""
        path = self._document.path
        if path is None:
            return
        file = self._own or sidecar.sidecar_of(path)
        if is_sample(path) and self._own is None:
            self.wants_place.emit(Path.home() / file.name)
        else:
            self.save_to(file)

    def save_to(self, file: Path, *, replace: bool = False) -> None:
        """Write the project to a file; one that isn't this photo's own is replaced if told to."""
        photo = self._document.photo
        if photo is None:
            return
        self._files.quiet.emit()
        if not is_project(file):
            file, replace = file.with_name(file.name + sidecar.SUFFIX), False
        if file.exists() and file != self._own and not replace:
            text = tr("There is another project already: {file}.", file=file.name)
            instead = Step(tr("Replace it"), lambda: self.save_to(file, replace=True))
            self.said.emit(Message(text, (instead, self._elsewhere(file))))
            return
        self._editing.commit()
        state, step = self._document.committed, self._document.undo.index()

        def job() -> tuple[Path, int, Photo]:
            save(to_keep_beside(state, photo), file)
            return file, step, photo

        self.working.emit(tr("Saving {name}…", name=file.name))
        self._writing.submit(job)

    def _written(self, written: tuple[Path, int, Photo]) -> None:
        file, step, photo = written
        if self._document.photo is photo:
            self._own = file
            if self._document.undo.index() == step:
                self._document.undo.setClean()
        self.working.emit(tr("Saved {name}", name=file.name))
        self.saved.emit(file)

    def _not_written(self, problem: Exception) -> None:
        path = self._document.path
        text = tr("The project can't be saved there: {problem}", problem=reason(problem))
        steps = () if path is None else (self._elsewhere(sidecar.sidecar_of(path)),)
        self.working.emit("")
        self.said.emit(Message(sentence(text), steps))

    def _elsewhere(self, file: Path) -> Step:
        return Step(tr("Choose another place…"), lambda: self.wants_place.emit(file))

    # -- taking up -------------------------------------------------------------------------------

    def open(self, file: Path) -> None:
        """Open the photo that a project file is about, with what the file holds."""
        self._files.quiet.emit()
        self.working.emit(tr("Opening {name}…", name=file.name))
        self._loading.submit(lambda: (file, *opened_with(file)))

    def _loaded(self, loaded: tuple[Path, Project, Path | None]) -> None:
        file, project, photo = loaded
        self.working.emit("")
        if photo is None:
            self.wants_photo.emit(file, project)
        else:
            self._files.open(photo, Work(project, file))

    def _refuse(self, text: str) -> None:
        self.working.emit("")
        self.said.emit(Message(text))
        self._files.unreadable.emit(text)

    def _forget(self) -> None:
        self._own = None

    def _take_up(self, work: Work) -> None:
        if work.file is None:
            return
        self._own = work.file
        lines = [tr("Your work on this photo is back, from {file}.", file=work.file.name)]
        if work.note:
            lines.append(sentence(work.note))
        afresh = Step(tr("Start afresh"), lambda: self._guard(self._start_afresh))
        self.said.emit(Message("\n".join(lines), (afresh,), wrong=bool(work.note)))

    def _start_afresh(self) -> None:
        path = self._document.path
        if path is not None:
            self._files.open(path, afresh=True)
