"""Whose answers count: what each rater's log says of their care, and rules fixed beforehand."""

from __future__ import annotations

import itertools
import statistics
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from kogao_core.base.language import Text
from kogao_core.base.strict import Node

if TYPE_CHECKING:
    from kogao_core.lab.study.tally import Answered

# Nobody sees a face, judges it and presses a key sooner; the page takes no answer before.
LEAST_MS: Final = 200
# Distances, % of D, that table 1's students all but agreed on, and that most called unnatural: only
# who saw both must have said both.
_NATURAL_PERCENT: Final = 2.0
_UNNATURAL_PERCENT: Final = 10.0


@dataclass(frozen=True, slots=True)
class Rules:
    """Whose answers are left out; a study's key holds what held when it was made."""

    least_ms: int = LEAST_MS  # a quicker answer doesn't count
    # Nor does any of a rater who is quicker in a larger share of answers, who said one thing to all
    # of this many pictures or more, up to 2 % and from 10 % of D, or who saw through a smaller
    # share of the catch pictures.
    most_quick: float = 0.1
    straight: int = 20
    least_caught: float = 0.75

    @staticmethod
    def parse(node: Node) -> Rules:
        """Read what a key holds."""
        node.only(("least_ms", "most_quick", "straight", "least_caught"))
        return Rules(
            node.field("least_ms").whole(0, 10**6),
            node.field("most_quick").number(0.0, 1.0),
            node.field("straight").whole(1, 10**6),
            node.field("least_caught").number(0.0, 1.0),
        )

    def broken_by(self, one: Quality) -> tuple[Text, ...]:
        """Return why a rater's answers are left out; empty where they count."""
        reasons = []
        if one.quick > self.most_quick:
            share = Text(
                "{share:.0f} % of answers in under {ms} ms",
                share=100.0 * one.quick,
                ms=self.least_ms,
            )
            reasons.append(share)
        low, high = one.distances
        ends = low <= _NATURAL_PERCENT and high >= _UNNATURAL_PERCENT
        if ends and one.answers >= self.straight and one.is_straight:
            reasons.append(Text("the same answer to all {n} pictures", n=one.answers))
        if one.catches and one.caught < self.least_caught * one.catches:
            caught = Text("{n} of {of} catch pictures seen", n=one.caught, of=one.catches)
            reasons.append(caught)
        return tuple(reasons)


RULES: Final = Rules()


@dataclass(frozen=True, slots=True)
class Quality:
    """What the answers of one rater say of their care; practice isn't among them."""

    rater: str
    answers: int
    median_ms: float
    quick: float  # share of answers that came sooner than the rules' least time, 0 to 1
    is_straight: bool  # whether all answers are the same
    unnatural: float | None  # share of "unnatural"; None where nothing is answered by that
    distances: tuple[float, float]  # smallest and largest asked for, % of D
    longest_run: int  # most times in a row that the same was said
    # Pairs of pictures that are the same, and how many of them were answered the same.
    pairs: int
    agreeing: int
    # Catch pictures, and how many were called unnatural.
    catches: int
    caught: int
    away_ms: int  # in another tab or window while a picture was on the screen
    taken_back: int  # answers
    sizes: tuple[tuple[int, int], ...]  # in which pictures were shown, CSS px, most often first
    degrees: tuple[float, float] | None  # smallest and largest width of a picture
    reasons: tuple[Text, ...] = ()  # why the answers are left out


def of_rater(rows: Sequence[Answered], rules: Rules) -> Quality:
    """Return what the answers of one rater say."""
    judged = [row for row in rows if row.record.answer is not None]
    asked = [abs(row.variant.percent) for row in judged if row.variant.kind != "catch"]
    catches = [row for row in judged if row.variant.kind == "catch"]
    others = [row for row in judged if row.variant.kind != "catch"]
    said = [row.record.answer for row in others]
    times = [row.record.took_ms for row in rows]
    runs = (len(list(same)) for _, same in itertools.groupby(said))
    shown = [row.record.display for row in rows if row.record.display is not None]
    widths = [one.degrees for one in shown if one.degrees is not None]
    twins = _twins(others)
    sessions = {id(row.session): row.session for row in rows}.values()
    return Quality(
        rows[0].session.rater,
        len(rows),
        statistics.median(times),
        sum(ms < rules.least_ms for ms in times) / len(times),
        len(set(said)) == 1,
        sum(bool(row.is_unnatural) for row in others) / len(said) if said else None,
        (min(asked, default=0.0), max(asked, default=0.0)),
        max(runs, default=0),
        len(twins),
        sum(first == second for first, second in twins),
        len(catches),
        sum(bool(row.is_unnatural) for row in catches),
        sum(row.record.away_ms for row in rows),
        sum(record.back for session in sessions for record in session.records),
        tuple(sorted({one.shown for one in shown}, key=[one.shown for one in shown].count)[::-1]),
        (min(widths), max(widths)) if widths else None,
    )


def _twins(rows: Sequence[Answered]) -> list[tuple[bool | None, bool | None]]:
    """Return the answers to each two pictures that are the same but for their names."""
    same = defaultdict(list)
    for row in rows:
        same[row.key.identity, row.meaning.subject, row.variant.what].append(row.is_unnatural)
    return [pair for answers in same.values() for pair in itertools.combinations(answers, 2)]
