"""The sessions of one study's folder: begun, gone on with, and each open in one program only."""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path
from typing import Any, BinaryIO, Final

from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile, Node
from kogao_core.lab.study import plan, results
from kogao_core.lab.study.results import Log
from kogao_core.lab.study.session import Record, Session

if sys.platform == "win32":
    import msvcrt

    # Windows locks bytes against writing, too: one that no log ever has.
    _LOCKED_BYTE: Final = 2**31 - 2

    def _lock(file: int) -> None:
        os.lseek(file, _LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


class Behind(Exception):
    """The session went on elsewhere; `session` is its state."""

    def __init__(self, session: dict[str, Any]) -> None:
        super().__init__("the session went on in another window")
        self.session = session


class Sessions:
    """A study and its open sessions; may be called from many threads."""

    def __init__(self, folder: Path) -> None:
        self.study = plan.load_study(folder)
        self.folder = folder
        self._names = {*self.study.ratings, *self.study.satisfaction, *self.study.practice}
        self._lock = threading.Lock()
        self._open: dict[str, tuple[Log, BinaryIO]] = {}

    def picture(self, name: str) -> bytes | None:
        """Return one of the study's pictures; None where it is none, or missing."""
        if name not in self._names:
            return None
        try:
            return (self.folder / name).read_bytes()
        except OSError:
            return None

    def open(self, rater: str, beginning: Node) -> dict[str, Any]:
        """Go on with the session of this code, or begin it as the page has drawn; its state.

        Without a beginning a new session's number is returned, from which the page draws: how many
        there are. Raises BadFile.
        """
        if not plan.is_rater(rater):
            raise BadFile(Text("A code is made of a to z, 0 to 9 and dashes, 32 at most."))
        with self._lock:
            if rater not in self._open:
                path = self.folder / plan.RATINGS_FOLDER / f"{rater}{results.SUFFIX}"
                begins = beginning.field("order").value is not None
                if not begins and not (path.exists() and b"\n" in path.read_bytes()):
                    return {"number": len(list(path.parent.glob(f"*{results.SUFFIX}")))}
                order = plan.names(beginning.field("order")) if begins else ()
                keys = results.keys_of(beginning.field("keys")) if begins else "fj"
                path.parent.mkdir(exist_ok=True)
                file = _locked(path, rater)
                try:
                    self._open[rater] = Log(path, self.study, rater, order, keys), file
                except (BadFile, OSError):
                    file.close()
                    if not path.stat().st_size:
                        path.unlink()
                    raise
            return _state_of(self._open[rater][0].session)

    def add(self, rater: str, record: Record) -> dict[str, Any]:
        """Put a record on the disk and count it. Raises Behind, BadFile."""
        with self._lock:
            if rater not in self._open:
                raise BadFile(Text("this session isn't open; load the page again"))
            log = self._open[rater][0]
            if record.number <= len(log.session.records):
                raise Behind(_state_of(log.session))
            log.add(record)
            return {}

    def close(self) -> None:
        """Let every session go."""
        with self._lock:
            for _, file in self._open.values():
                file.close()
            self._open.clear()


def _locked(path: Path, rater: str) -> BinaryIO:
    """Return a session's file, locked until it is closed or this program ends in any way."""
    file = path.open("ab")
    try:
        _lock(file.fileno())
    except (BlockingIOError, PermissionError):
        file.close()
        raise BadFile(
            Text(
                "The session {rater} is open in another program; go on there, or end that one.",
                rater=rater,
            )
        ) from None
    except OSError:
        file.close()
        raise
    return file


def _state_of(session: Session) -> dict[str, Any]:
    records = [record.to_dict() for record in session.records]
    state = {"rater": session.rater, "order": session.order, "keys": session.keys}
    return {**state, "records": records}
