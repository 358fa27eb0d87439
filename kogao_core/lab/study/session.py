"""One rater's answers: lines that follow from one another, and the picture to ask about next."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.lab.study.conduct import ANSWERS, Answer
from kogao_core.lab.study.plan import Study

# The keys that say natural and unnatural.
Keys = Literal["fj", "jf"]


@dataclass(frozen=True, slots=True)
class Display:
    """How a picture was displayed when it was judged."""

    # Width and height of the picture and of the browser's viewport, CSS px.
    shown: tuple[int, int]
    window: tuple[int, int]
    ratio: float  # device px a CSS px
    # Width of the picture, degrees of visual angle, and the distance of the eyes, mm, that it
    # follows from. None where the screen wasn't measured.
    degrees: float | None = None
    distance_mm: float | None = None


@dataclass(frozen=True, slots=True)
class Record:
    """One line of a log: an answer about a picture, or that the last one was taken back."""

    number: int  # counts the lines of a session from 1
    picture: str  # its name
    answer: Answer | None = None  # for a picture of the first block
    # 0 to 100 for a picture of the second block; None there for one that was skipped.
    grade: int | None = None
    back: bool = False  # the last answer, about this picture, is taken back
    # From the picture's appearance to the answer; without `away_ms`, the time in which another
    # tab or window was in front.
    took_ms: int = 0
    away_ms: int = 0
    display: Display | None = None  # how it was displayed; None where it is taken back

    @property
    def skipped(self) -> bool:
        """Whether it is an answer, and says nothing."""
        return not self.back and self.answer is None and self.grade is None

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        line: dict[str, Any] = {"n": self.number, "picture": self.picture}
        if self.back:
            return {**line, "back": True}
        line |= {"grade": self.grade} if self.answer is None else {"answer": self.answer}
        line |= {"ms": self.took_ms, "away": self.away_ms}
        if self.display is not None:
            seen = self.display
            line |= {"shown": list(seen.shown), "window": list(seen.window), "ratio": seen.ratio}
            line |= {"degrees": seen.degrees, "distance": seen.distance_mm}
        return line


@dataclass(slots=True)
class Session:
    """One rater's answers to a study so far, and the picture to ask about next."""

    study: Study  # its pictures
    rater: str  # the rater's code
    # Pictures to practise with, those to judge and those of oneself, each in the order of showing:
    # of all faces, or of as many as a rater judges.
    order: tuple[str, ...]
    records: list[Record] = field(default_factory=list)  # every line so far
    keys: Keys = "fj"
    _answers: dict[str, Record] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Replay the records. Raises BadFile."""
        if not self._is_whole():
            raise BadFile(Text("the order doesn't hold every picture of this study once"))
        past, self.records = self.records, []
        for record in past:
            self.take(record)

    def _is_whole(self) -> bool:
        study, place = self.study, 0
        faces = study.faces or ((*study.ratings, *study.satisfaction),)
        chosen = [face for face in faces if not set(face).isdisjoint(self.order)]
        shown = {name for face in chosen for name in face}
        blocks = (
            study.practice,
            [name for name in study.ratings if name in shown],
            [name for name in study.satisfaction if name in shown],
        )
        for block in blocks:
            if sorted(self.order[place : place + len(block)]) != sorted(block):
                return False
            place += len(block)
        wanted = min(study.conduct.faces_each or len(faces), len(faces))
        return place == len(self.order) and len(chosen) == wanted

    @property
    def answered(self) -> list[Record]:
        """Answers that weren't taken back, in the order given."""
        return list(self._answers.values())

    @property
    def current(self) -> str | None:
        """The picture to ask about; None at the end."""
        done = len(self._answers)
        return self.order[done] if done < len(self.order) else None

    @property
    def grading(self) -> bool:
        """Whether the current picture is to be graded."""
        slider = self.study.conduct.task == "slider"
        return self.current in self.study.satisfaction or (slider and self.current is not None)

    def check(self, record: Record) -> None:
        """Check that a record may come next. Raises BadFile."""
        number = len(self.records) + 1
        if record.number != number:
            raise BadFile(
                Text(
                    "line {number} is missing, or {other} is there twice",
                    number=number,
                    other=record.number,
                )
            )
        if record.back:
            if not self._answers or next(reversed(self._answers)) != record.picture:
                raise BadFile(
                    Text("line {number} takes back what wasn't the last answer", number=number)
                )
        elif record.picture != self.current or (record.answer is None) != self.grading:
            raise BadFile(
                Text("line {number} is about a picture that wasn't shown then", number=number)
            )
        elif record.answer is not None and record.answer not in ANSWERS[self.study.conduct.task]:
            raise BadFile(Text("line {number} isn't answered as was asked", number=number))
        elif record.skipped and record.picture not in self.study.satisfaction:
            raise BadFile(Text("line {number} has no answer", number=number))

    def take(self, record: Record) -> None:
        """Let a record count; see `check` for what is refused."""
        self.check(record)
        if record.back:
            del self._answers[record.picture]
        else:
            self._answers[record.picture] = record
        self.records.append(record)
