"""Recovery files for unsaved work, offered after a crash."""

from __future__ import annotations

import os
import uuid
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from PySide6.QtCore import QLockFile, QThreadPool, QTimer

from kogao_core.base.json_reader import BadFile
from kogao_core.base.wording import printable
from kogao_core.photo import Photo
from kogao_core.projects.project import Original, Project, load, save

from ..document import State
from ..i18n import reason, tr
from ..widgets.dialogs import confirm
from ..widgets.messages import BarAction
from .feature import Context, Feature
from .files import Files
from .files.history import project_of
from .files.opening import EarlierWork
from .files.saver import Saver

_AGAIN_MS: Final = 1000


@dataclass(frozen=True, eq=False, slots=True)
class _Kept:
    """A written state (None: no unsaved work), and the leftovers that this file replaces."""

    state: State | None
    replaced: tuple[Leftover, ...]


class Recovery(Feature):
    """Writes a recovery file after each edit, and offers recovery files after a crash.

    The files are in the program's data folder, never next to the user's photos.
    """

    def __init__(self, context: Context, saver: Saver, files: Files) -> None:
        super().__init__(context)
        self._saver, self._files = saver, files
        self._folder = self.storage.recovery
        self._file = self._folder / f"{uuid.uuid4().hex}.json"
        self._lock: QLockFile | None = None
        self._left: list[Leftover] = []
        self._waiting: list[Leftover] = []
        self._taken_over: list[Leftover] = []
        self._complained = False
        # A separate thread, so that other jobs don't delay the recovery file.
        self._own_pool = QThreadPool(self)
        self._own_pool.setMaxThreadCount(1)
        self._writing = self.lane(self._written, self._complain, self._own_pool)
        # Retry later: the disk may have been full.
        self._again = QTimer(self, singleShot=True, interval=_AGAIN_MS)
        self._again.timeout.connect(self._write)
        self._looking = self.lane(self._take, self._not_looked)
        self.document.undo.indexChanged.connect(self._write)
        self.document.marked.connect(self._write)
        self.document.opened.connect(self._begin)
        files.restored.connect(self._take_over)
        self.window.bar.dismissed.connect(self.offer)

    @property
    def file(self) -> Path:
        return self._file

    def stop(self) -> None:
        """Stop retries and discard waiting jobs."""
        super().stop()
        self._again.stop()

    def finish(self) -> None:
        """Delete the recovery file at the normal end of the program."""
        self._own_pool.waitForDone()
        with suppress(OSError):  # not accessible: the next start offers the file
            self._file.unlink(missing_ok=True)
        for lock in (self._lock, *(one.lock for one in self._left)):
            if lock is not None:
                lock.unlock()

    def look(self) -> None:
        """Search for recovery files of crashed programs and offer the first."""
        folder = self._folder
        self._looking.submit(lambda: leftovers(folder))

    # -- writing ---------------------------------------------------------------------------------

    def _begin(self) -> None:
        # Keep restored work that was not stored again for the next start.
        self._taken_over = []
        self._write()

    def _write(self) -> None:
        photo = self.document.photo
        if photo is None:
            return
        state = None if self.document.saved else self.document.committed
        kept = _Kept(state, tuple(self._taken_over))
        self._writing.submit(lambda: self._put(kept, photo))

    def _put(self, kept: _Kept, photo: Photo) -> _Kept:
        if kept.state is None:
            if os.path.exists(self._file):
                self._file.unlink(missing_ok=True)
        else:
            self._folder.mkdir(parents=True, exist_ok=True)
            if self._lock is None:
                self._lock = locked(self._file)
            original = Original(str(photo.path), photo.picture, photo.width, photo.height)
            save(project_of(kept.state, original), self._file, private=True)
        return kept

    def _written(self, kept: _Kept) -> None:
        if kept.state is None:
            return
        self._complained = False
        self.window.bar.refresh()
        # Another file with the same work exists only from now on.
        for left in kept.replaced:
            if left in self._taken_over:
                self._taken_over.remove(left)
                self._delete(left)

    def _complain(self, problem: Exception) -> None:
        self._again.start()
        if not self._complained:
            self._complained = True
            text = tr("Unsaved changes can't be kept for a crash ({why}).", why=reason(problem))
            self.say(text, applies=lambda: self._complained)

    # -- recovery after a crash -------------------------------------------------------------------

    def _take(self, found: list[Leftover]) -> None:
        self._left, self._waiting = found, list(found)
        self.offer()

    def _not_looked(self, problem: Exception) -> None:
        text = tr(
            "Work that a crash may have left can't be looked for ({why}); it stays in {folder}.",
            why=reason(problem),
            folder=self._folder,
        )
        self.say(text)

    def offer(self) -> None:
        """Offer the next recovery file that has not been offered yet."""
        if self._waiting:
            self._offer(self._waiting.pop(0))

    def _offer(self, left: Leftover) -> None:
        folder = printable(str(Path(left.project.original.path).parent))
        text = tr(
            "Kogao ended before the changes to {name} in {folder} were saved.",
            name=left.name,
            folder=folder,
        )
        # "Dismiss" comes last, so that the button to discard is far from it.
        steps = (
            BarAction(tr("Discard…"), lambda: self._ask_discard(left)),
            BarAction(tr("Restore"), lambda: self._ask_restore(left)),
        )
        self.say(text, *steps, wrong=False, applies=lambda: self._is_open(left))

    def _is_open(self, left: Leftover) -> bool:
        return left in self._left and left not in self._taken_over

    def _ask_restore(self, left: Leftover) -> None:
        # Offer again: the user may keep the present photo.
        self._offer(left)
        path, work = Path(left.project.original.path), EarlierWork(left.project)
        self._saver.guard(lambda: self._files.read(path, work))

    def _ask_discard(self, left: Leftover) -> None:
        # Confirm in a dialog, so that a slip loses no work.
        self._offer(left)
        text = tr("Discard the unsaved changes to {name} for good?", name=left.name)
        confirm(self.window, text, tr("&Discard"), lambda: self._discard(left))

    def _discard(self, left: Leftover) -> None:
        if not self._is_open(left):
            return  # the restored photo was opened while the question was shown
        self._delete(left)
        if self._waiting:
            self.offer()
        else:
            text = tr("The changes to {name} are discarded.", name=left.name)
            self.say(text, wrong=False)

    def _delete(self, left: Leftover) -> None:
        left.delete()
        self._left.remove(left)

    def _take_over(self, work: EarlierWork) -> None:
        project, photo = work.project, self.document.photo
        for left in self._left:
            if left.project is project and photo is not None:
                self._taken_over.append(left)
                self.window.bar.refresh()
                self._write()
                known = project.original.sha256
                self._warn(known not in ("", photo.picture, photo.sha256))

    def _warn(self, changed: bool) -> None:
        if changed:
            text = tr("The photo has changed since these edits were made. Check the result.")
            self.say(text)
        else:
            self.offer()


@dataclass(frozen=True, eq=False, slots=True)
class Leftover:
    """A recovery file of an ended program, with a lock against other programs."""

    path: Path
    project: Project
    lock: QLockFile

    @property
    def name(self) -> str:
        """The photo's file name."""
        return Path(self.project.original.path).name

    def delete(self) -> None:
        self.path.unlink(missing_ok=True)
        self.lock.unlock()


def leftovers(folder: Path) -> list[Leftover]:
    """Return the recovery files without a running program, newest first."""
    found = []
    for path in sorted(folder.glob("*.json"), key=modified, reverse=True):
        lock = locked(path)
        if lock is None:
            continue
        try:
            found.append(Leftover(path, load(path), lock))
        except BadFile:  # missing, foreign, or of a newer version: keep the file
            lock.unlock()
    return found


def modified(path: Path) -> float:
    """Return the modification time of a file, s; 0 for a missing file."""
    try:
        return path.stat().st_mtime
    except OSError:  # another program has ended normally
        return 0.0


def locked(path: Path) -> QLockFile | None:
    """Lock a recovery file and return the lock; None while a running program has the lock."""
    lock = QLockFile(str(path.with_suffix(".lock")))
    # A lock is valid exactly as long as the program runs, regardless of age.
    lock.setStaleLockTime(0)
    return lock if lock.tryLock(0) else None
