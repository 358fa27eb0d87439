"""Made-up raters: what a page sends of a session."""

from __future__ import annotations

import random
from pathlib import Path

from kogao_core.lab.study.design import Answer
from kogao_core.lab.study.plan import Study
from kogao_core.lab.study.results import Display, Log, Record, Session

DISPLAY = Display((960, 720), (1280, 960), 1.25)


def answered(session: Session, answer: Answer, took_ms: int = 900) -> Record:
    """An answer about the current picture; `take` or a log makes it count."""
    return Record(
        _next(session), session.current, answer, took_ms=took_ms, away_ms=0, display=DISPLAY
    )


def graded(session: Session, grade: int | None, took_ms: int = 900) -> Record:
    """A grade of the current picture, None skips it."""
    return Record(
        _next(session), session.current, None, grade, took_ms=took_ms, away_ms=0, display=DISPLAY
    )


def judged(session: Session, answer: Answer = "natural", grade: int = 50) -> Record:
    """Whichever of the two is asked for."""
    return graded(session, grade) if session.grading else answered(session, answer)


def taken_back(session: Session) -> Record:
    """The last answer taken back."""
    return Record(_next(session), session.answered[-1].picture, back=True)


def log_of(path: Path, study: Study, rater: str) -> Log:
    """A session's log, in an order drawn by chance where it is new."""
    blocks = (study.practice, study.ratings, study.satisfaction)
    order = [name for block in blocks for name in random.sample(block, len(block))]
    return Log(path, study, rater, order)


def _next(session: Session) -> int:
    return len(session.records) + 1
