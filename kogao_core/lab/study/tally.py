"""Join ratings with the key, and apply the rules that exclude answers."""

from __future__ import annotations

import dataclasses
import itertools
import math
import statistics
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.lab.study import plan, results
from kogao_core.lab.study.design import Rules, Variant
from kogao_core.lab.study.plan import Key, Meaning, PictureFigures
from kogao_core.lab.study.results import Record, Session
from kogao_core.lab.study.shares import Correlations, Judgement, Share

_MOST_FILES: Final = 10_000
# Distances of table 1, % of D, that nearly all students called natural, and that most called
# unnatural. The rule on equal answers applies to raters who saw both.
_NATURAL_PERCENT: Final = 2.0
_UNNATURAL_PERCENT: Final = 10.0
# Largest AUC that the rule on guessing asks for: reached from about 24 answers, 8 of each kind, on.
_HIGHEST_LIMIT: Final = 0.8


@dataclass(frozen=True, slots=True)
class Grades:
    """Mean and sample standard deviation of grades; NaN for too few grades."""

    count: int
    mean: float
    deviation: float

    @staticmethod
    def of(values: Sequence[float]) -> Grades:
        """Return count, mean and deviation of grades."""
        mean = statistics.fmean(values) if values else math.nan
        deviation = statistics.stdev(values) if len(values) > 1 else math.nan
        return Grades(len(values), mean, deviation)


@dataclass(frozen=True, slots=True, eq=False)
class Answered:
    """One answer, not undone."""

    key: Key  # key of the study
    session: Session
    place: int  # position in the session, from 1
    record: Record
    subject: str  # face: file name of the photo; numbered if photos differ but have one name

    @property
    def meaning(self) -> Meaning:
        return self.key.pictures[self.record.picture]

    @property
    def variant(self) -> Variant:
        return self.meaning.variant

    @property
    def is_unnatural(self) -> bool | None:
        """Whether the answer is unnatural; None for grades."""
        answer = self.record.answer
        return None if answer is None else answer == "unnatural"

    @property
    def is_early(self) -> bool:
        """Whether the answer took less than the minimum time of the rules."""
        return self.record.took_ms < self.key.rules.least_ms


@dataclass(frozen=True, slots=True, kw_only=True)
class Quality:
    """Quality of one rater's answers, without practice."""

    rater: str
    answers: int
    median_ms: float
    quick: float  # share of answers below the minimum time, 0 to 1
    judged: int  # answers "natural" and "unnatural", without catch pictures
    unnatural: float | None  # share of "unnatural" of `judged`; None without such answers
    distances: tuple[float, float]  # smallest and largest requested distance, % of D
    longest_run: int  # longest run of equal answers
    # Number of pairs of identical pictures, and of pairs with equal answers.
    pairs: int
    agreeing: int
    # Number of catch pictures, and of catch pictures called unnatural.
    catches: int
    caught: int
    # AUC of the answers over the warp distance: the probability that of two pictures with different
    # answers the "unnatural" one has the larger distance (0.5: guessing); and the standard error of
    # guessing. None without both answers.
    follows: float | None
    guess_error: float | None
    away_ms: int  # in another tab or window during trials
    taken_back: int  # answers
    sizes: tuple[tuple[int, int], ...]  # sizes of pictures, CSS px, most frequent first
    reasons: tuple[Text, ...] = ()  # reasons for exclusion

    def broken(self, rules: Rules) -> tuple[Text, ...]:
        """Return the reasons for exclusion under some rules; empty if the answers count."""
        reasons = []
        if self.quick > rules.most_quick:
            share = Text(
                "{share:.0f} % of answers in under {ms} ms",
                share=100.0 * self.quick,
                ms=rules.least_ms,
            )
            reasons.append(share)
        low, high = self.distances
        ends = low <= _NATURAL_PERCENT and high >= _UNNATURAL_PERCENT
        if ends and self.judged >= rules.straight:
            # A tolerant rater can find every warp natural; catch pictures tell sleepers.
            if self.unnatural == 0.0 and not self.catches:
                reasons.append(Text("natural for all {n} warps", n=self.judged))
            if self.unnatural == 1.0:
                reasons.append(Text("unnatural for all {n} warps", n=self.judged))
        if self.catches and self.caught < rules.least_caught * self.catches:
            caught = Text("{n} of {of} catch pictures seen", n=self.caught, of=self.catches)
            reasons.append(caught)
        if ends and self.follows is not None and self.guess_error is not None:
            least = 0.5 + rules.least_follows * self.guess_error
            # With few answers of one kind, chance explains orders that honest raters reach, too.
            if least <= _HIGHEST_LIMIT and self.follows < least:
                reasons.append(
                    Text("answers follow the warp distance no better than chance "
                         "(AUC {auc:.2f})", auc=self.follows)
                )  # fmt: skip
        return tuple(reasons)


@dataclass(slots=True)
class Tally:
    """Answers, raters and keys of one or more studies."""

    keys: list[Key] = field(default_factory=list)  # the studies
    answers: list[Answered] = field(default_factory=list)  # all answers, in the order of the files
    raters: dict[str, Quality] = field(
        default_factory=dict
    )  # by code; a code is one person in all studies
    unfinished: list[Session] = field(default_factory=list)
    # Files that are not counted, each with the reason.
    refused: list[tuple[Path, str]] = field(default_factory=list)

    @property
    def subjects(self) -> int:
        """Number of judged faces, without the practice face."""
        return sum(
            len({one.subject for one in key.pictures.values() if one.variant.kind != "practice"})
            for key in self.keys
        )

    @property
    def careful(self) -> set[str]:
        """Raters whose answers count."""
        return {rater for rater, one in self.raters.items() if not one.reasons}

    @property
    def left_out(self) -> list[Quality]:
        """Raters whose answers don't count."""
        return [one for one in self.raters.values() if one.reasons]

    @property
    def counted(self) -> list[Answered]:
        return [row for row in self.answers if not self.reasons(row)]

    def reasons(self, row: Answered) -> tuple[Text, ...]:
        """Return the reasons why an answer doesn't count; empty if it counts."""
        early = (Text("too early"),) if row.is_early else ()
        is_left = row.session.current is not None and not row.key.rules.unfinished
        left = (Text("session not finished"),) if is_left else ()
        return (*self.raters[row.session.rater].reasons, *left, *early)

    def shares(self, rows: Iterable[Answered] | None = None) -> dict[Variant, Share]:
        """Return the share of "unnatural" per variant, of `rows` or of the answers that count."""
        judgements = defaultdict[Variant, list[Judgement]](list)
        for row in self.counted if rows is None else rows:
            if row.is_unnatural is not None:
                answer = Judgement(row.session.rater, row.subject, row.is_unnatural)
                judgements[row.variant].append(answer)
        kinds = {one.variant for key in self.keys for one in key.pictures.values()}
        judged = sorted(one for one in kinds if one.is_judged)
        correlations = Correlations.of([judgements[variant] for variant in judged])
        return {variant: Share(tuple(judgements[variant]), correlations) for variant in judged}

    def grades(self) -> tuple[Grades, Grades, int]:
        """Return grades of the own face, grades of other faces, and the number of skipped pictures.

        A rater who graded several faces graded other people: each photo shows another person.
        """
        own: list[int] = []
        others: list[int] = []
        skipped = 0
        by_rater: defaultdict[str, list[Answered]] = defaultdict(list)
        for row in self.counted:
            if row.variant.kind == "satisfaction":
                by_rater[row.session.rater].append(row)
        for rows in by_rater.values():
            graded = [row for row in rows if row.record.grade is not None]
            faces = {(row.key.identity, row.meaning.subject) for row in graded}
            given = [row.record.grade for row in graded if row.record.grade is not None]
            (own if len(faces) == 1 else others).extend(given)
            skipped += len(rows) - len(graded)
        return Grades.of(own), Grades.of(others), skipped

    def measured(self) -> dict[Variant, PictureFigures]:
        """Return means over the subjects."""
        found: defaultdict[Variant, list[PictureFigures]] = defaultdict(list)
        for key in self.keys:
            for meaning in key.pictures.values():
                found[meaning.variant].append(meaning.measured)
        return {variant: _mean(values) for variant, values in found.items()}


def _mean(values: Sequence[PictureFigures]) -> PictureFigures:
    ratios = [one.lattice_in_warps for one in values if one.lattice_in_warps is not None]
    return PictureFigures(
        statistics.fmean(one.achieved for one in values),
        statistics.fmean(ratios) if ratios else None,
    )


def tally(
    studies: Sequence[tuple[Path, Path]], others: Iterable[Path] = (), exclude: Collection[str] = ()
) -> Tally:
    """Join the answers of some studies with their keys. Raises BadFile.

    Unusable files are listed in the result.
    """
    total, known = Tally(), {}
    for folder, key_file in studies:
        study, key = plan.load_study(folder), plan.load_key(key_file)
        _check(study, key, key_file)
        total.keys.append(key)
        known[study.identity] = study, key
    names = _face_names(total.keys)
    files = [path for folder, _ in studies for path in _rating_files(folder)]
    by_session = defaultdict(list)
    for path in [*files, *others]:
        try:
            ratings = results.load(path)
        except BadFile as problem:
            total.refused.append((path, str(problem)))
        else:
            by_session[ratings.study, ratings.rater].append((path, ratings))
    for (identity, _), copies in by_session.items():
        try:
            if identity not in known:
                raise BadFile("ratings of another study, {study}", study=identity)
            study, key = known[identity]
            ratings = results.newest([ratings for _, ratings in copies])
            _add(ratings.session(study), key, names[identity], total)
        except BadFile as problem:
            total.refused += [
                (path, Text("{path}: {problem}", path=path, problem=problem)) for path, _ in copies
            ]
    _judge_raters(total, exclude)
    return total


def _rating_files(folder: Path) -> list[Path]:
    places = (folder, folder / plan.RATINGS_FOLDER)
    found = sorted(path for place in places for path in place.glob(f"*{results.SUFFIX}"))
    return found[:_MOST_FILES]


def _check(study: plan.Study, key: Key, key_file: Path) -> None:
    named = {*study.ratings, *study.satisfaction, *study.practice}
    if key.identity != study.identity or named != set(key.pictures):
        raise BadFile(
            "{key_file} is the key of another study; give the right key", key_file=key_file
        )


def _face_names(keys: Sequence[Key]) -> dict[str, list[str]]:
    """Return a name for each subject of each study; photos of one digest have one name."""
    names: dict[tuple[object, ...], str] = {}
    files: dict[str, int] = defaultdict(int)
    found: dict[str, list[str]] = {}
    for key in keys:
        for index, photo in enumerate(key.subjects):
            face = (photo.name, photo.sha256 or (key.identity, index))
            if face not in names:
                files[photo.name] += 1
                number = files[photo.name]
                names[face] = photo.name if number == 1 else f"{photo.name} ({number})"
            found.setdefault(key.identity, []).append(names[face])
    return found


def _add(session: Session, key: Key, names: Sequence[str], total: Tally) -> None:
    if session.current is not None:
        total.unfinished.append(session)
    places = {name: place for place, name in enumerate(session.order, start=1)}
    total.answers += [
        Answered(key, session, places[record.picture], record, names[meaning.subject])
        for record in session.answered
        if (meaning := key.pictures[record.picture]).variant.kind != "practice"
    ]


def _judge_raters(total: Tally, exclude: Collection[str]) -> None:
    by_rater: defaultdict[str, list[Answered]] = defaultdict(list)
    for row in total.answers:
        by_rater[row.session.rater].append(row)
    for rater, rows in sorted(by_rater.items()):
        rules = rows[0].key.rules
        one = of_rater(rows, rules)
        reasons = one.broken(rules)
        if rater in exclude:
            reasons = (Text("excluded by hand"), *reasons)
        total.raters[rater] = dataclasses.replace(one, reasons=reasons)


def of_rater(rows: Sequence[Answered], rules: Rules) -> Quality:
    """Return the quality of one rater's answers."""
    judged = [row for row in rows if row.record.answer is not None]
    asked = [abs(row.variant.percent) for row in judged if row.variant.kind != "catch"]
    catches = [row for row in judged if row.variant.kind == "catch"]
    others = [row for row in judged if row.variant.kind != "catch"]
    said = [row.record.answer for row in others]
    times = [row.record.took_ms for row in rows]
    runs = (len(list(same)) for _, same in itertools.groupby(said))
    shown = [row.record.display for row in rows if row.record.display is not None]
    twins = _twins(others)
    sessions = {id(row.session): row.session for row in rows}.values()
    results = [row for row in judged if row.variant.is_judged]
    auc, guess_error = follows(
        np.array([abs(row.meaning.measured.achieved) for row in results]),
        np.array([bool(row.is_unnatural) for row in results], bool),
    )
    return Quality(
        rater=rows[0].session.rater,
        answers=len(rows),
        median_ms=statistics.median(times),
        quick=sum(ms < rules.least_ms for ms in times) / len(times),
        judged=len(said),
        unnatural=sum(bool(row.is_unnatural) for row in others) / len(said) if said else None,
        distances=(min(asked, default=0.0), max(asked, default=0.0)),
        longest_run=max(runs, default=0),
        pairs=len(twins),
        agreeing=sum(first == second for first, second in twins),
        catches=len(catches),
        caught=sum(bool(row.is_unnatural) for row in catches),
        follows=auc,
        guess_error=guess_error,
        away_ms=sum(row.record.away_ms for row in rows),
        taken_back=sum(record.back for session in sessions for record in session.records),
        sizes=tuple(
            sorted({one.shown for one in shown}, key=[one.shown for one in shown].count)[::-1]
        ),
    )


def follows(
    distances: Array, unnatural: npt.NDArray[np.bool_]
) -> tuple[float | None, float | None]:
    """Return the AUC of "unnatural" over distance, and the standard error of guessing.

    Both are None if all answers are alike. The variance is that of Mann and Whitney (1947).
    """
    few, many = np.count_nonzero(unnatural), np.count_nonzero(~unnatural)
    if not few * many:
        return None, None
    farther = np.sign(np.subtract.outer(distances[unnatural], distances[~unnatural]))
    error = math.sqrt((len(distances) + 1) / (12.0 * few * many))
    return float(0.5 + 0.5 * farther.mean()), error


def _twins(rows: Sequence[Answered]) -> list[tuple[bool | None, bool | None]]:
    """Return the answers to each pair of identical pictures."""
    same = defaultdict(list)
    for row in rows:
        same[row.key.identity, row.meaning.subject, row.variant.what].append(row.is_unnatural)
    return [pair for answers in same.values() for pair in itertools.combinations(answers, 2)]
