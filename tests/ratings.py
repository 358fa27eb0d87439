"""Made-up raters: sessions, and the files that a page saves of them."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

from kogao_core.lab.study import results
from kogao_core.lab.study.design import Answer
from kogao_core.lab.study.plan import Study
from kogao_core.lab.study.results import Display, Record, Session

DISPLAY = Display((960, 720), (1280, 960), 1.25)


def begun(study: Study, rater: str = "r1") -> Session:
    """Return a session without answers, in an order drawn by chance."""
    blocks = (study.practice, study.ratings, study.satisfaction)
    order = [name for block in blocks for name in random.sample(block, len(block))]
    return Session(study, rater, tuple(order))


def answered(session: Session, answer: Answer, took_ms: int = 900) -> Record:
    """Return an answer about the current picture; `take` makes it count."""
    return Record(_next(session), session.current, answer, took_ms=took_ms, display=DISPLAY)


def graded(session: Session, grade: int | None, took_ms: int = 900) -> Record:
    """Return a grade of the current picture; None skips it."""
    return Record(_next(session), session.current, None, grade, took_ms=took_ms, display=DISPLAY)


def judged(session: Session, answer: Answer = "natural", grade: int = 50) -> Record:
    """Return an answer or a grade, as the current picture needs."""
    return graded(session, grade) if session.grading else answered(session, answer)


def taken_back(session: Session) -> Record:
    """Return the undo of the last answer."""
    return Record(_next(session), session.answered[-1].picture, back=True)


def line_of(record: Record) -> dict[str, Any]:
    """Return the line of a record, as the page writes it."""
    line = {"n": record.number, "picture": record.picture}
    if record.back:
        return {**line, "back": True}
    said = {"grade": record.grade} if record.answer is None else {"answer": record.answer}
    times = {"ms": record.took_ms, "away": record.away_ms}
    seen = record.display
    return line | said | times | {"shown": seen.shown, "window": seen.window, "ratio": seen.ratio}


def save(session: Session, path: Path) -> None:
    """Write the file of a session."""
    whose = {"rater": session.rater, "keys": session.keys, "order": session.order}
    lines = [results.header(session.study) | whose, *map(line_of, session.records)]
    path.parent.mkdir(exist_ok=True)
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))


def _next(session: Session) -> int:
    return len(session.records) + 1
