"""One rater's answers: lines that follow from one another, and the picture to ask about next."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from kogao_core.experiments.study import plan
from kogao_core.experiments.study.plan import Study
from kogao_core.strict import BadFile

Answer = Literal["natural", "unnatural"]


@dataclass(frozen=True, slots=True)
class Record:
    """One line: what was said of a picture, or that it was taken back.

    Parameters
    ----------
    number : int
        Counts the lines of a session from 1.
    picture : str
        Its name.
    answer : {"natural", "unnatural"}, optional
        For a picture of the first block.
    grade : int, optional
        0 to 100 for a picture of the second block; None there for one that was skipped.
    back : bool
        The last answer, about this picture, is taken back.
    took_ms : float
        From the picture's appearance to the answer.
    """

    number: int
    picture: str
    answer: Answer | None = None
    grade: int | None = None
    back: bool = False
    took_ms: int = 0

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        said: dict[str, Any] = {"n": self.number, "picture": self.picture}
        if self.back:
            return {**said, "back": True}
        said |= {"grade": self.grade} if self.answer is None else {"answer": self.answer}
        return {**said, "ms": self.took_ms}


@dataclass(slots=True)
class Session:
    """One rater's answers to a study so far, and the picture to ask about next.

    Parameters
    ----------
    study : Study
        Its pictures.
    rater : str
        The code that orders them.
    records : list of Record
        Every line so far.
    """

    study: Study
    rater: str
    records: list[Record] = field(default_factory=list)
    _told: dict[str, Record] = field(init=False, default_factory=dict)
    _todo: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        """Replay the records.

        Raises
        ------
        BadFile
            If they don't follow from one another.
        """
        ratings = plan.order(self.study.ratings, self.rater)
        self._todo = (*ratings, *plan.order(self.study.satisfaction, self.rater))
        past, self.records = self.records, []
        for record in past:
            self.take(record)

    @property
    def answered(self) -> list[Record]:
        """Answers that stand, in the order given."""
        return list(self._told.values())

    @property
    def total(self) -> int:
        """Number of pictures."""
        return len(self._todo)

    @property
    def current(self) -> str | None:
        """The picture to ask about; None at the end."""
        return self._at(0)

    @property
    def following(self) -> str | None:
        """The picture after that, to be made ready."""
        return self._at(1)

    @property
    def grading(self) -> bool:
        """Whether the current picture is to be graded."""
        return self.current in self.study.satisfaction

    def _at(self, ahead: int) -> str | None:
        place = len(self._told) + ahead
        return self._todo[place] if place < len(self._todo) else None

    def answer(self, answer: Answer, took_ms: float) -> Record:
        """Return the record of an answer about the current picture; `take` makes it count."""
        return Record(self._number, self._asked, answer=answer, took_ms=round(took_ms))

    def grade(self, grade: int | None, took_ms: float) -> Record:
        """Return the record of a grade of the current picture, None to skip it."""
        return Record(self._number, self._asked, grade=grade, took_ms=round(took_ms))

    def back(self) -> Record | None:
        """Return the record that takes the last answer back; None before the first."""
        if not self._told:
            return None
        return Record(self._number, next(reversed(self._told)), back=True)

    def take(self, record: Record) -> None:
        """Let a record count.

        Raises
        ------
        BadFile
            If it isn't the next one of this session: a line is missing, doubled or foreign.
        """
        if record.number != self._number:
            raise BadFile(f"line {self._number} is missing, or {record.number} is there twice")
        if record.back:
            if not self._told or next(reversed(self._told)) != record.picture:
                raise BadFile(f"line {record.number} takes back what wasn't the last answer")
            del self._told[record.picture]
        else:
            if record.picture != self.current or (record.answer is None) != self.grading:
                raise BadFile(f"line {record.number} is about a picture that wasn't shown then")
            self._told[record.picture] = record
        self.records.append(record)

    @property
    def _number(self) -> int:
        return len(self.records) + 1

    @property
    def _asked(self) -> str:
        if self.current is None:
            raise ValueError("every picture has been judged")
        return self.current
