"""Unsaved work in a file of its own, and an offer to go on with it after a crash."""

from __future__ import annotations

import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from PySide6.QtCore import QLockFile, QObject, QThreadPool, QTimer, Signal

from kogao_core.photo import Photo
from kogao_core.project import Project, save, sha256_of

from ..document import Document, State
from ..i18n import reason, tr
from ..orphans import Orphan, locked, orphans
from ..projects import Work, hash_of, project_of
from ..views.bar import Message, Step
from ..workers import Lane
from .dialogs import Dialogs
from .files import Files

_AGAIN_MS: Final = 1000


@dataclass(frozen=True, eq=False, slots=True)
class _Kept:
    """What was written: a state, or None for nothing, and the orphans it makes superfluous."""

    state: State | None
    replaced: tuple[Orphan, ...]


class Recovery(QObject):
    """Writes the document aside after each step, and finds what a crash has left.

    Parameters
    ----------
    document, files, dialogs : Document, Files, Dialogs
        What is saved, what opens photos again, and who asks before something is lost.
    folder : Path
        Where recovery files lie; never beside the user's photos.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    answered
        An offer no longer holds.
    """

    said = Signal(object)
    answered = Signal()

    def __init__(
        self,
        document: Document,
        files: Files,
        dialogs: Dialogs,
        folder: Path,
        pool: QThreadPool,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._document, self._files, self._dialogs = document, files, dialogs
        self._folder = folder
        self._file = folder / f"{uuid.uuid4().hex}.json"
        self._lock: QLockFile | None = None
        self._orphans: list[Orphan] = []
        self._waiting: list[Orphan] = []
        self._taken_over: list[Orphan] = []
        self._hashed: Photo | None = None
        self._digest = ""
        self._complained = False
        # A thread of its own: whatever else the program works on, an edit is kept at once.
        self._own_pool = QThreadPool(self)
        self._own_pool.setMaxThreadCount(1)
        self._writing = Lane(self._own_pool, self._complain, self)
        # A disk that was full may have room again.
        self._again = QTimer(self, singleShot=True, interval=_AGAIN_MS)
        self._again.timeout.connect(self._write)
        self._writing.done.connect(self._written)
        self._looking = Lane(pool, self._not_looked, self)
        self._looking.done.connect(self._take)
        self._checking = Lane(pool, self._not_checked, self)
        self._checking.done.connect(self._warn)
        self._hashing = Lane(pool, self._not_checked, self)
        self._hashing.done.connect(self._take_hash)
        document.undo.indexChanged.connect(self._write)
        document.marked.connect(self._write)
        document.opened.connect(self._begin)
        files.restored.connect(self._take_over)

    @property
    def busy(self) -> bool:
        """True while files are read or written."""
        lanes = (self._writing, self._looking, self._checking, self._hashing)
        return any(lane.busy for lane in lanes)

    @property
    def file(self) -> Path:
        """Where this program's unsaved work is kept."""
        return self._file

    def stop(self) -> None:
        """Start nothing more."""
        self._again.stop()
        for lane in (self._writing, self._looking, self._checking, self._hashing):
            lane.drop()

    def clear(self) -> None:
        """Remove this program's file: it ends in good order."""
        self._own_pool.waitForDone()
        self._file.unlink(missing_ok=True)
        for lock in (self._lock, *(orphan.lock for orphan in self._orphans)):
            if lock is not None:
                lock.unlock()

    def look(self) -> None:
        """Look for what a crash has left, and offer it."""
        folder = self._folder
        self._looking.submit(lambda: orphans(folder))

    # -- writing ---------------------------------------------------------------------------------

    def _begin(self) -> None:
        # What was restored into the last photo and not kept since stays for the next start.
        self._taken_over = []
        self._write()

    def _write(self) -> None:
        photo = self._document.photo
        if photo is None:
            return
        state = None if self._document.saved else self._document.committed
        kept = _Kept(state, tuple(self._taken_over))
        if state is not None and self._hashed is not photo:
            # A large photo takes its time: the work is kept without its hash until then.
            self._hashed, self._digest = photo, ""
            self._hashing.submit(lambda: (photo, hash_of(photo)))
        digest = self._digest
        self._writing.submit(lambda: self._put(kept, photo, digest))

    def _put(self, kept: _Kept, photo: Photo, digest: str) -> _Kept:
        if kept.state is None:
            self._file.unlink(missing_ok=True)
        else:
            self._folder.mkdir(parents=True, exist_ok=True)
            if self._lock is None:
                self._lock = locked(self._file)
            save(project_of(kept.state, photo, digest), self._file)
        return kept

    def _written(self, kept: _Kept) -> None:
        if kept.state is None:
            return
        self._complained = False
        # Only now is there another file that holds the same work.
        for orphan in kept.replaced:
            if orphan in self._taken_over:
                self._taken_over.remove(orphan)
                self._delete(orphan)

    def _take_hash(self, hashed: tuple[Photo, str]) -> None:
        photo, digest = hashed
        if photo is self._hashed:
            self._digest = digest
            self._write()

    def _complain(self, problem: Exception) -> None:
        self._again.start()
        if not self._complained:
            self._complained = True
            text = tr("Unsaved changes can't be kept for a crash ({why}).", why=reason(problem))
            self.said.emit(Message(text))

    # -- going on after a crash --------------------------------------------------------------------

    def _take(self, found: list[Orphan]) -> None:
        self._orphans, self._waiting = found, list(found)
        self.offer()

    def _not_looked(self, problem: Exception) -> None:
        text = tr(
            "Work that a crash may have left can't be looked for ({why}); it stays in {folder}.",
            why=reason(problem),
            folder=self._folder,
        )
        self.said.emit(Message(text))

    def offer(self) -> None:
        """Offer what a crash has left and wasn't offered yet, one after the other."""
        if self._waiting:
            self._offer(self._waiting.pop(0))

    def _offer(self, orphan: Orphan) -> None:
        text = tr("Kogao ended before the changes to {name} were saved.", name=orphan.name)
        steps = (
            Step(tr("Restore"), lambda: self._ask_restore(orphan)),
            Step(tr("Discard…"), lambda: self._ask_discard(orphan)),
        )
        self.said.emit(Message(text, steps, wrong=False, holds=lambda: self._is_open(orphan)))

    def _is_open(self, orphan: Orphan) -> bool:
        return orphan in self._orphans and orphan not in self._taken_over

    def _ask_restore(self, orphan: Orphan) -> None:
        # The offer stands until the photo is opened, should the user keep the present one.
        self._offer(orphan)
        path, work = Path(orphan.project.original.path), Work(orphan.project)
        self._dialogs.guard(lambda: self._files.open(path, work))

    def _ask_discard(self, orphan: Orphan) -> None:
        # It stands here, too: one slip beside "Dismiss" must lose nothing.
        self._offer(orphan)
        text = tr("Discard the unsaved changes to {name} for good?", name=orphan.name)
        self._dialogs.confirm(text, tr("&Discard"), lambda: self._discard(orphan))

    def _discard(self, orphan: Orphan) -> None:
        self._delete(orphan)
        if self._waiting:
            self.offer()
        else:
            text = tr("The changes to {name} are discarded.", name=orphan.name)
            self.said.emit(Message(text, wrong=False))

    def _delete(self, orphan: Orphan) -> None:
        orphan.delete()
        self._orphans.remove(orphan)

    def _take_over(self, work: Work) -> None:
        project = work.project
        for orphan in self._orphans:
            if orphan.project is project:
                self._taken_over.append(orphan)
                self.answered.emit()
                self._write()
                self._checking.submit(lambda: _is_changed(project))

    def _not_checked(self, problem: Exception) -> None:
        text = tr(
            "Whether the photo is still the same can't be told ({why}): look closely.",
            why=reason(problem),
        )
        self.said.emit(Message(text))

    def _warn(self, changed: bool) -> None:
        if changed:
            text = tr("The photo is another one than when these changes were made: look closely.")
            self.said.emit(Message(text))
        else:
            self.offer()


def _is_changed(project: Project) -> bool:
    known = project.original.sha256
    return bool(known) and sha256_of(project.original.path) != known
