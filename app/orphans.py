"""Recovery files whose program is gone, and the locks by which that is known."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QLockFile

from kogao_core.project import Project, load
from kogao_core.strict import BadFile


@dataclass(frozen=True, eq=False, slots=True)
class Orphan:
    """A recovery file whose program is gone, with the lock that keeps others from it."""

    path: Path
    project: Project
    lock: QLockFile

    @property
    def name(self) -> str:
        """The photo's file name."""
        return Path(self.project.original.path).name

    def delete(self) -> None:
        """Remove it for good."""
        self.path.unlink(missing_ok=True)
        self.lock.unlock()


def orphans(folder: Path) -> list[Orphan]:
    """Return the recovery files in a folder that no running program holds, newest first."""
    found = []
    for path in sorted(folder.glob("*.json"), key=_modified, reverse=True):
        lock = locked(path)
        if lock is None:
            continue
        try:
            found.append(Orphan(path, load(path), lock))
        except BadFile:  # gone, not ours, or of a newer Kogao: left for that one
            lock.unlock()
    return found


def _modified(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:  # another program has ended in good order since
        return 0.0


def locked(path: Path) -> QLockFile | None:
    """Return the lock of a recovery file; None while a running program holds it."""
    lock = QLockFile(str(path.with_suffix(".lock")))
    # However long ago, a lock holds while its program runs, and no longer.
    lock.setStaleLockTime(0)
    return lock if lock.tryLock(0) else None
