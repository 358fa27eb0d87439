"""The project file of the open photo: written beside it, and taken up again with it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, QThreadPool, Signal

from kogao_core import sidecar
from kogao_core.photo import Photo
from kogao_core.project import Project, save

from ..document import Document, State
from ..i18n import reason, sentence, tr
from ..photos import is_sample
from ..projects import Work, is_project, opened_with, to_keep_beside
from ..views.bar import Message, Step
from ..workers import Lane
from .files import Files
from .saver import Request, Saver, Then


class Projects(QObject):
    """Saves what was done to the open photo, and opens photos by their project files.

    Parameters
    ----------
    document, saver, files : Document, Saver, Files
        What is saved, who writes it, and who opens photos.
    guard : callable
        Asks before unsaved changes are lost, then calls its argument.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    working(str)
        What is under way.
    wants_place(Path, callable or None)
        The user has to choose where the project goes; this name is suggested, and this comes after.
    wants_photo(Path, Project)
        The user has to say which photo this project file is about.
    """

    said = Signal(object)
    working = Signal(str)
    wants_place = Signal(object, object)
    wants_photo = Signal(object, object)

    def __init__(
        self,
        document: Document,
        saver: Saver,
        files: Files,
        guard: Callable[[Callable[[], object]], None],
        pool: QThreadPool,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._document, self._saver, self._files = document, saver, files
        self._guard = guard
        # What was read from there, or written there, may be written over without a question.
        self._own: Path | None = None
        self._loading = Lane(pool, lambda problem: self._refuse(sentence(problem)), self)
        self._loading.done.connect(self._loaded)
        document.opened.connect(self._forget)
        files.restored.connect(self._take_up)

    @property
    def busy(self) -> bool:
        """True while a project is read."""
        return self._loading.busy

    def stop(self) -> None:
        """Start nothing more."""
        self._loading.drop()

    # -- saving ----------------------------------------------------------------------------------

    def save(self, then: Then | None = None) -> None:
        """Write the project beside its photo; ask where that isn't ours to write.

        Parameters
        ----------
        then : callable, optional
            What to do once it is written, see `Saver`.
        """
        path = self._document.path
        if path is None:
            return
        file = self._own or sidecar.sidecar_of(path)
        if is_sample(path) and self._own is None:
            self.wants_place.emit(Path.home() / file.name, then)
        else:
            self.save_to(file, then)

    def save_to(self, file: Path, then: Then | None = None, *, replace: bool = False) -> None:
        """Write the project to a file; one that isn't this photo's own is replaced if told to."""
        self._files.quiet.emit()
        if not is_project(file):
            file, replace = file.with_name(file.name + sidecar.SUFFIX), False
        if file.exists() and file != self._own and not replace:
            text = tr("There is another project already: {file}.", file=file.name)
            instead = Step(tr("Replace it"), lambda: self.save_to(file, replace=True))
            self.said.emit(Message(text, (instead, self._elsewhere(file))))
            return

        def write(photo: Photo, state: State) -> str:
            save(to_keep_beside(state, photo), file)
            return ""

        self._saver.save(file, write, self._written, self._not_written, then, whole=True)

    def _written(self, request: Request, _: str) -> None:
        if self._document.photo is request.photo:
            self._own = request.file

    def _not_written(self, problem: Exception) -> None:
        path = self._document.path
        text = tr("The project can't be saved there: {problem}", problem=reason(problem))
        steps = () if path is None else (self._elsewhere(sidecar.sidecar_of(path)),)
        self.said.emit(Message(sentence(text), steps))

    def _elsewhere(self, file: Path) -> Step:
        return Step(tr("Choose another place…"), lambda: self.wants_place.emit(file, None))

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
