"""Unsaved work in a file of its own, and an offer to go on with it after a crash."""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from PySide6.QtCore import QLockFile, QObject, QThreadPool, QTimer, Signal

from kogao_core.photo import Photo
from kogao_core.project import Project, load, save, sha256_of
from kogao_core.strict import BadFile

from ..document import Document, State
from ..i18n import reason, tr
from ..projects import Work, project_of
from ..views.bar import Message, Step
from ..workers import Lane
from .files import Files

# A crash costs at most the steps of this long.
AFTER_MS: Final = 1000


@dataclass(frozen=True, slots=True)
class Orphan:
    """A recovery file whose program is gone, with the lock that keeps others from it."""

    path: Path
    project: Project
    lock: QLockFile

    def delete(self) -> None:
        """Remove it for good."""
        self.path.unlink(missing_ok=True)
        self.lock.unlock()


class Recovery(QObject):
    """Writes the document aside after each step, and finds what a crash has left.

    Parameters
    ----------
    document, files : Document, Files
        What is saved, and what opens photos again.
    folder : Path
        Where recovery files lie; never beside the user's photos.
    guard : callable
        Asks before unsaved changes are lost, then calls its argument.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    """

    said = Signal(object)

    def __init__(
        self,
        document: Document,
        files: Files,
        folder: Path,
        guard: Callable[[Callable[[], object]], None],
        pool: QThreadPool,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._document, self._files, self._folder, self._guard = document, files, folder, guard
        self._file = folder / f"{uuid.uuid4().hex}.json"
        self._lock: QLockFile | None = None
        self._orphans: list[Orphan] = []
        self._taken_over: Orphan | None = None
        self._hashes: dict[Path, str] = {}
        self._complained = False
        self._writing = Lane(pool, self._complain, self)
        self._looking = Lane(pool, self._not_looked, self)
        self._looking.done.connect(self._offer)
        self._checking = Lane(pool, self._not_checked, self)
        self._checking.done.connect(self._warn)
        self._soon = QTimer(self, singleShot=True, interval=AFTER_MS)
        self._soon.timeout.connect(self._write)
        document.undo.indexChanged.connect(self._follow)
        document.undo.cleanChanged.connect(self._follow)
        document.opened.connect(self._follow)
        files.restored.connect(self._take_over)

    @property
    def busy(self) -> bool:
        """True while files are read or written."""
        return any(lane.busy for lane in (self._writing, self._looking, self._checking))

    @property
    def file(self) -> Path:
        """Where this program's unsaved work is kept."""
        return self._file

    def stop(self) -> None:
        """Start nothing more."""
        self._soon.stop()
        for lane in (self._writing, self._looking, self._checking):
            lane.drop()

    def clear(self) -> None:
        """Remove this program's file: it ends in good order. Nothing may run any more."""
        self._file.unlink(missing_ok=True)
        for lock in (self._lock, *(orphan.lock for orphan in self._orphans)):
            if lock is not None:
                lock.unlock()

    def look(self) -> None:
        """Look for what a crash has left, and offer it."""
        folder = self._folder
        self._looking.submit(lambda: orphans(folder))

    # -- writing ---------------------------------------------------------------------------------

    def _follow(self) -> None:
        if self._document.photo is not None and not self._soon.isActive():
            self._soon.start()

    def _write(self) -> None:
        photo, state = self._document.photo, self._document.committed
        if photo is None:
            return
        clean = self._document.undo.isClean()
        old, self._taken_over = self._taken_over, None
        self._writing.submit(lambda: self._put(None if clean else state, photo, old))

    def _put(self, state: State | None, photo: Photo, old: Orphan | None) -> None:
        if state is None:
            self._file.unlink(missing_ok=True)
        else:
            self._folder.mkdir(parents=True, exist_ok=True)
            if self._lock is None:
                self._lock = _locked(self._file)
            save(project_of(state, photo, self._hash(photo.path)), self._file)
        if old is not None:
            # Only now is there another file that holds the same work.
            old.delete()

    def _hash(self, path: Path) -> str:
        if path not in self._hashes:
            try:
                self._hashes = {path: sha256_of(path)}
            except OSError:  # the photo is gone; its points are still worth keeping
                return ""
        return self._hashes[path]

    def _complain(self, problem: Exception) -> None:
        if not self._complained:
            self._complained = True
            text = tr("Unsaved changes can't be kept for a crash ({why}).", why=reason(problem))
            self.said.emit(Message(text))

    # -- going on after a crash --------------------------------------------------------------------

    def _not_looked(self, problem: Exception) -> None:
        text = tr(
            "Work that a crash may have left can't be looked for ({why}); it stays in {folder}.",
            why=reason(problem),
            folder=self._folder,
        )
        self.said.emit(Message(text))

    def _offer(self, found: list[Orphan]) -> None:
        self._orphans = found
        if not found:
            return
        orphan = found[0]
        name = Path(orphan.project.original.path).name
        text = tr("Kogao ended before the changes to {name} were saved.", name=name)
        steps = (
            Step(tr("Restore"), lambda: self._guard(lambda: self._restore(orphan))),
            Step(tr("Discard"), lambda: self._discard(orphan)),
        )
        self.said.emit(Message(text, steps, wrong=False, holds=lambda: True))

    def _restore(self, orphan: Orphan) -> None:
        self._files.open(Path(orphan.project.original.path), Work(orphan.project))

    def _discard(self, orphan: Orphan) -> None:
        orphan.delete()
        self._offer(self._orphans[1:])

    def _take_over(self, work: Work) -> None:
        project = work.project
        for orphan in self._orphans:
            if orphan.project is project:
                self._taken_over = orphan
                self._orphans.remove(orphan)
                self._checking.submit(lambda: _is_changed(project))
                return

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


def orphans(folder: Path) -> list[Orphan]:
    """Return the recovery files in a folder that no running program holds, newest first."""
    found = []
    for path in sorted(folder.glob("*.json"), key=os.path.getmtime, reverse=True):
        lock = _locked(path)
        if lock is None:
            continue
        try:
            found.append(Orphan(path, load(path), lock))
        except BadFile:  # not ours, or of a newer Kogao: left for that one
            lock.unlock()
    return found


def _is_changed(project: Project) -> bool:
    known = project.original.sha256
    return bool(known) and sha256_of(project.original.path) != known


def _locked(path: Path) -> QLockFile | None:
    lock = QLockFile(str(path.with_suffix(".lock")))
    # However long ago, a lock holds while its program runs, and no longer.
    lock.setStaleLockTime(0)
    return lock if lock.tryLock(0) else None
