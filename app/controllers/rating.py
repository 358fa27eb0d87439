"""One person's rating session: each answer is on the disk before the next picture shows."""

from __future__ import annotations

import secrets
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from PySide6.QtCore import QLockFile, QObject, Signal

from kogao_core.experiments.study import plan, results
from kogao_core.experiments.study.plan import Study
from kogao_core.experiments.study.results import Log
from kogao_core.experiments.study.session import Answer, Record, Session
from kogao_core.strict import BadFile

from ..i18n import tr

_CODE_BYTES: Final = 4


@dataclass(frozen=True, slots=True)
class Begun:
    """A session that can go on: its code, how many pictures are judged, and of how many."""

    rater: str
    done: int
    total: int


class Rating(QObject):
    """A study's folder, and the session in it that is open.

    Parameters
    ----------
    folder : Path
        What ``kogao-cli experiment study make`` has made.
    parent : QObject, optional
        Owner.

    Signals
    -------
    changed
        Another picture is to be shown, or the session is over.
    failed(str)
        An answer couldn't be kept and doesn't count; a sentence.

    Raises
    ------
    BadFile
        If the folder holds no study.
    """

    changed = Signal()
    failed = Signal(str)

    def __init__(self, folder: Path, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._folder = folder
        self.study: Study = plan.load_study(folder)
        self._log: Log | None = None
        self._lock: QLockFile | None = None
        self._shown_at: float | None = None  # nothing to judge before it was seen

    @property
    def session(self) -> Session | None:
        """The session that is open."""
        return None if self._log is None else self._log.session

    def path(self, picture: str) -> Path:
        """Return where a picture lies."""
        return self._folder / picture

    def begun(self) -> list[Begun]:
        """Return the sessions of this folder that aren't finished."""
        found = []
        for path in sorted((self._folder / plan.RATINGS_FOLDER).glob(f"*{results.SUFFIX}")):
            try:
                held = results.load(path)
                session = Session(self.study, held.rater, list(held.records))
            except BadFile:
                continue  # what can't go on isn't offered; the report names it
            if held.study == self.study.identity and session.current is not None:
                found.append(Begun(held.rater, len(session.answered), session.total))
        return found

    @staticmethod
    def new_code() -> str:
        """Draw a code for a person who was given none."""
        return secrets.token_hex(_CODE_BYTES)

    def start(self, rater: str) -> None:
        """Begin a session, or go on with the one of this code.

        Raises
        ------
        BadFile
            If the code can't be one, the session is open elsewhere, or its file can't be used.
        OSError
            If the folder can't be written to.
        """
        if not plan.is_rater(rater):
            raise BadFile(tr("A code is made of a to z, 0 to 9 and dashes, 32 at most."))
        path = self._folder / plan.RATINGS_FOLDER / f"{rater}{results.SUFFIX}"
        path.parent.mkdir(exist_ok=True)
        lock = QLockFile(f"{path}.lock")
        # A killed program leaves its lock behind; its age says nothing.
        lock.setStaleLockTime(0)
        if not lock.tryLock(0):
            raise BadFile(
                tr("The session {rater} is open in another window; go on there.", rater=rater)
            )
        self._log, self._lock = Log(path, self.study, rater), lock
        self._shown_at = None
        self.changed.emit()

    def stop(self) -> None:
        """Let the session go; nothing is lost."""
        self._log = None
        if self._lock is not None:
            self._lock.unlock()
            self._lock = None

    def shown(self) -> None:
        """Note that the current picture is on the screen: the time of the answer begins."""
        self._shown_at = time.perf_counter()

    def answer(self, answer: Answer) -> None:
        """Judge the current picture; before it is on the screen this does nothing."""
        session, took_ms = self.session, self._took_ms()
        if session is None or took_ms is None or session.current is None or session.grading:
            return
        self._add(session.answer(answer, took_ms))

    def grade(self, grade: int | None) -> None:
        """Grade the current picture from 0 to 100, None skips it; see `answer`."""
        session, took_ms = self.session, self._took_ms()
        if session is not None and took_ms is not None and session.grading:
            self._add(session.grade(grade, took_ms))

    def back(self) -> None:
        """Take the last answer back and ask again."""
        record = None if self.session is None else self.session.back()
        if record is not None:
            self._add(record)

    def _took_ms(self) -> float | None:
        return None if self._shown_at is None else 1e3 * (time.perf_counter() - self._shown_at)

    def _add(self, record: Record) -> None:
        assert self._log is not None
        try:
            self._log.add(record)
        except OSError as problem:
            reason = problem.strerror or str(problem)
            self.failed.emit(
                tr("The answer wasn't kept ({reason}). Make room and answer again.", reason=reason)
            )
            return
        self._shown_at = None
        self.changed.emit()
