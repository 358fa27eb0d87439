"""Ratings joined with the key: what was called unnatural, variant by variant."""

from __future__ import annotations

import statistics
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.lab.study import plan, results
from kogao_core.lab.study.origin import PictureFigures
from kogao_core.lab.study.plan import Key
from kogao_core.lab.study.results import Ratings
from kogao_core.lab.study.session import Session
from kogao_core.lab.study.statistics import Grades, Share
from kogao_core.lab.study.variants import Variant

_MOST_FILES: Final = 10_000


@dataclass(slots=True)
class Tally:
    """What one or more studies found."""

    # Answers "unnatural" to each variant, over all subjects and raters.
    shares: dict[Variant, Share] = field(default_factory=dict)
    grades: list[int] = field(default_factory=list)  # satisfaction, 0 to 100
    skipped: int = 0  # pictures that weren't graded
    # How many photos, and torn lines.
    subjects: int = 0
    torn: int = 0
    # Of the raters; one code is one person in all studies.
    codes: set[str] = field(default_factory=set)
    # Means over the subjects; without variants that a key doesn't have.
    measured: dict[Variant, PictureFigures] = field(default_factory=dict)
    keys: list[Key] = field(default_factory=list)  # the studies
    # Begun and not brought to their end; their answers count.
    unfinished: list[Session] = field(default_factory=list)
    # Files of ratings that aren't counted, and the study that each names.
    foreign: list[tuple[Path, str]] = field(default_factory=list)

    @property
    def raters(self) -> int:
        """How many people answered."""
        return len(self.codes)

    @property
    def satisfaction(self) -> Grades:
        """Mean and deviation of the grades."""
        return Grades.of(self.grades)


def _rating_files(folder: Path) -> list[Path]:
    """Return the files of ratings in a study's folder: the editor's, and those handed in."""
    places = (folder, folder / plan.RATINGS_FOLDER)
    return sorted(path for place in places for path in place.glob(f"*{results.SUFFIX}"))


def tally(studies: Sequence[tuple[Path, Path]], others: Iterable[Path] = ()) -> Tally:
    """Count the answers of some studies. Raises BadFile."""
    total, hits, answers = Tally(), Counter[Variant](), Counter[Variant]()
    extra = _by_study(others)
    for folder, key_file in studies:
        study, key = plan.load_study(folder), plan.load_key(key_file)
        _check(study, key, key_file)
        own = list(_own(study, folder, total))
        ratings = results.newest([*own, *extra.pop(study.identity, [])])
        total.subjects += len(key.subjects)
        total.keys.append(key)
        for one in ratings:
            _count(_session(study, one), key, total, hits, answers)
            total.torn += one.torn
        judged = (meaning.variant for meaning in key.pictures.values())
        answers.update(dict.fromkeys((v for v in judged if v.kind != "satisfaction"), 0))
    if extra:
        raise BadFile(
            Text("the ratings of study {extra} belong to none of these folders", extra=min(extra))
        )
    total.shares = {variant: Share(hits[variant], answers[variant]) for variant in sorted(answers)}
    total.measured = _measured(total.keys)
    return total


def _own(study: plan.Study, folder: Path, total: Tally) -> Iterator[Ratings]:
    """Yield the ratings in a study's folder; those of other studies are named and left out."""
    for path in _rating_files(folder)[:_MOST_FILES]:
        ratings = results.load(path)
        if ratings.study == study.identity:
            yield ratings
        else:
            total.foreign.append((path, ratings.study))


def _measured(keys: Iterable[Key]) -> dict[Variant, PictureFigures]:
    found: defaultdict[Variant, list[PictureFigures | None]] = defaultdict(list)
    for key in keys:
        for meaning in key.pictures.values():
            found[meaning.variant].append(meaning.measured)
    known = {variant: [one for one in all_ if one] for variant, all_ in found.items()}
    return {
        variant: _mean(values)
        for variant, values in known.items()
        if len(values) == len(found[variant])
    }


def _mean(values: Sequence[PictureFigures]) -> PictureFigures:
    ratios = [one.lattice_in_warps for one in values if one.lattice_in_warps is not None]
    return PictureFigures(
        statistics.fmean(one.achieved for one in values),
        statistics.fmean(ratios) if ratios else None,
    )


def _by_study(files: Iterable[Path]) -> dict[str, list[Ratings]]:
    found: defaultdict[str, list[Ratings]] = defaultdict(list)
    for path in files:
        ratings = results.load(path)
        found[ratings.study].append(ratings)
    return found


def _check(study: plan.Study, key: Key, key_file: Path) -> None:
    named = {*study.ratings, *study.satisfaction}
    if key.identity != study.identity or named != set(key.pictures):
        raise BadFile(
            Text(
                "{key_file} is the key of another study; name the right one",
                key_file=key_file,
            )
        )


def _session(study: plan.Study, ratings: Ratings) -> Session:
    try:
        return ratings.session(study)
    except BadFile as error:
        raise BadFile(
            Text("the ratings of {rater} can't be used: {error}", rater=ratings.rater, error=error)
        ) from None


def _count(
    session: Session, key: Key, total: Tally, hits: Counter[Variant], answers: Counter[Variant]
) -> None:
    if session.answered:
        total.codes.add(session.rater)
    if session.answered and session.current is not None:
        total.unfinished.append(session)
    for record in session.answered:
        variant = key.pictures[record.picture].variant
        if variant.kind != "satisfaction":
            answers[variant] += 1
            hits[variant] += record.answer == "unnatural"
        elif record.grade is None:
            total.skipped += 1
        else:
            total.grades.append(record.grade)
