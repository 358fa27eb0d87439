"""Ratings: files of one rater's answers, saved by the page, with one line of JSON per answer.

An undone answer gets a further line.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

from kogao_core import __version__
from kogao_core.base.json_reader import BadFile, Node, parse, read
from kogao_core.base.language import Text
from kogao_core.base.web_page import SURROUND
from kogao_core.lab.study import plan
from kogao_core.lab.study.design import Answer, one_of
from kogao_core.lab.study.plan import Study

# Keys for natural and unnatural.
Keys = Literal["fj", "jf"]
SUFFIX: Final = ".jsonl"
VERSION: Final = 3
_LARGEST_GRADE: Final = 100
_FORMAT: Final = "kogao-ratings"
_MOST_BYTES: Final = 64 * 2**20
_MOST_LINE_BYTES: Final = 4096
_MOST_RECORDS: Final = 10_000_000
_LONGEST_MS: Final = 10**9
_LONGEST_SIDE: Final = 100_000
_LARGEST_RATIO: Final = 100.0


@dataclass(frozen=True, slots=True)
class Display:
    """Displayed size of a judged picture."""

    # Width and height of the picture and of the browser's viewport, CSS px.
    shown: tuple[int, int]
    window: tuple[int, int]
    ratio: float  # device px per CSS px


@dataclass(frozen=True, slots=True)
class Record:
    """One line of ratings: an answer, or the undo of the last answer."""

    number: int  # number of the line in the session, from 1
    picture: str  # name
    answer: Answer | None = None  # for pictures to judge
    # 0 to 100 for pictures to grade; None if skipped.
    grade: int | None = None
    back: bool = False  # True: undo the last answer, about this picture
    # Time from the picture's appearance to the answer, without `away_ms`, the time in another tab
    # or window.
    took_ms: int = 0
    away_ms: int = 0
    display: Display | None = None  # None for an undo


@dataclass(slots=True)
class Session:
    """Answers of one rater so far, and the next picture."""

    study: Study
    rater: str  # the rater's code
    # Pictures in the order of showing: practice, pictures to judge, pictures to grade; of all faces
    # or of the faces assigned to this rater.
    order: tuple[str, ...]
    records: list[Record] = field(default_factory=list)  # all lines so far
    keys: Keys = "fj"
    _answers: dict[str, Record] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Replay the records. Raises BadFile."""
        if not self._is_whole():
            raise BadFile("the order doesn't contain each picture of this study once")
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
        """Answers without undone ones, in order."""
        return list(self._answers.values())

    @property
    def current(self) -> str | None:
        """The next picture; None at the end."""
        done = len(self._answers)
        return self.order[done] if done < len(self.order) else None

    @property
    def grading(self) -> bool:
        """Whether the next picture needs a grade."""
        return self.current in self.study.satisfaction

    def take(self, record: Record) -> None:
        """Add a record if it is a valid next line. Raises BadFile."""
        number = len(self.records) + 1
        if record.number != number:
            raise BadFile(
                "line {number} is missing, or line {other} is repeated",
                number=number,
                other=record.number,
            )
        if record.back:
            if not self._answers or next(reversed(self._answers)) != record.picture:
                raise BadFile("line {number} undoes an answer that wasn't the last", number=number)
        elif record.picture != self.current or (record.answer is None) != self.grading:
            raise BadFile("line {number} is about a picture that wasn't shown then", number=number)
        if record.back:
            del self._answers[record.picture]
        else:
            self._answers[record.picture] = record
        self.records.append(record)


@dataclass(frozen=True, slots=True)
class Ratings:
    """Content of a file of ratings."""

    # Names of the study and the rater.
    study: str
    rater: str
    order: tuple[str, ...]  # in which the pictures are shown
    keys: Keys  # for natural and unnatural
    records: tuple[Record, ...]  # the lines in their order

    def session(self, study: Study) -> Session:
        """Return the session. Raises BadFile."""
        return Session(study, self.rater, self.order, list(self.records), self.keys)


def header(study: Study) -> dict[str, Any]:
    """Return the first line of ratings, without rater, keys and order."""
    return {
        "format": _FORMAT,
        "version": VERSION,
        "study": study.identity,
        "program": __version__,
        "surround": SURROUND,
    }


def load(path: Path) -> Ratings:
    """Read a file of ratings. Raises BadFile."""
    data = read(path, _MOST_BYTES)
    if len(data) > _MOST_BYTES:
        raise BadFile("{path} is too large for a rating file", path=path)
    try:
        top, *rest = _lines(data)
        top.field("format").text(40, (_FORMAT,))
        top.field("version").whole(VERSION, VERSION)
        rater = top.field("rater").text(32)
        if not plan.is_rater(rater):
            top.field("rater").refuse("is no code of a rater")
        study = top.field("study").text(64)
        order, keys = plan.names(top.field("order")), one_of(top.field("keys"), Keys, 2)
        records = tuple(map(record, rest))
    except BadFile as error:
        raise BadFile("{path} is not a rating file: {error}", path=path, error=error) from None
    return Ratings(study, rater, order, keys, records)


def _lines(data: bytes) -> Iterator[Node]:
    """Yield the lines. Raises BadFile."""
    for number, line in enumerate(data.rstrip().split(b"\n"), start=1):
        # The first line contains all picture names.
        most = _MOST_BYTES if number == 1 else _MOST_LINE_BYTES
        yield Node(parse(line, most).value, root=Text("line {number}", number=number))


def record(node: Node) -> Record:
    """Read one line. Raises BadFile."""
    number = node.field("n").whole(1, _MOST_RECORDS)
    picture = node.field("picture").text(40)
    if node.field("back").value is not None:
        node.only(("n", "picture", "back")).field("back").flag()
        return Record(number, picture, back=True)
    # Files of 1.0.0 have degrees of visual angle and a viewing distance.
    viewed = ("ms", "away", "shown", "window", "ratio", "degrees", "distance")
    took, away = (node.field(name).whole(0, _LONGEST_MS) for name in viewed[:2])
    display = _display(node)
    if "answer" in node.value:
        node.only(("n", "picture", "answer", *viewed))
        answer = one_of(node.field("answer"), Answer)
        return Record(number, picture, answer, took_ms=took, away_ms=away, display=display)
    node.only(("n", "picture", "grade", *viewed))
    grade = node.field("grade")
    value = None if grade.value is None else grade.whole(0, _LARGEST_GRADE)
    return Record(number, picture, None, value, took_ms=took, away_ms=away, display=display)


def _display(node: Node) -> Display:
    ratio = node.field("ratio").number(1.0 / _LARGEST_RATIO, _LARGEST_RATIO)
    shown, window = _size(node.field("shown")), _size(node.field("window"))
    return Display(shown, window, ratio)


def _size(node: Node) -> tuple[int, int]:
    sides = [side.whole(1, _LONGEST_SIDE) for side in node.items(2)]
    if len(sides) != 2:
        node.refuse("must be a width and a height")
    return sides[0], sides[1]


def newest(copies: Sequence[Ratings]) -> Ratings:
    """Return the longest of several copies of a session; raise BadFile if they differ."""
    *shorter, longest = sorted(copies, key=lambda one: len(one.records))
    for one in shorter:
        if longest.records[: len(one.records)] != one.records:
            raise BadFile(
                "rater {rater} has two contradicting files; remove the wrong file", rater=one.rater
            )
    return longest
