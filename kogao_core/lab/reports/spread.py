"""Timing: cases take turns in one process; results are medians with quartiles."""

from __future__ import annotations

import math
import random
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final, TypeVar

from kogao_core.base.language import BadValue

Name = TypeVar("Name")
Result = TypeVar("Result")
_TICKS: Final = 12  # of the processor clock; the last one may be missing: an error of 8 %


@dataclass(frozen=True, slots=True)
class Spread:
    """Median and quartiles of some measurements, in the unit of the measurements."""

    median: float
    q1: float
    q3: float
    count: int

    @staticmethod
    def of(values: Sequence[float]) -> Spread:
        """Return the spread of at least one value; quartiles include the ends (Tukey's hinges)."""
        if not values:
            raise BadValue("a spread needs at least one value")
        ordered = sorted(values)
        half = (len(ordered) + 1) // 2
        return Spread(
            statistics.median(ordered),
            statistics.median(ordered[:half]),
            statistics.median(ordered[-half:]),
            len(ordered),
        )

    def text(self) -> str:
        """Return text such as ``12.3 (11.9-13.0)``; without quartiles for a single value."""
        if self.count == 1:
            return rounded(self.median)
        low, high = rounded(self.q1), rounded(self.q3)
        return f"{rounded(self.median)} ({low}\N{EN DASH}{high})"


def in_columns(name: str, spread: Spread | None, unit_ms: float = 1.0) -> dict[str, object]:
    """Return columns of a record with median and quartiles, ms; None without a spread."""
    ends = ("median", "q1", "q3")
    return {f"{name}_{end}_ms": spread and unit_ms * getattr(spread, end) for end in ends}


def rounded(value: float) -> str:
    """Return a number with three significant digits, without an exponent."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    places = max(0, 2 - math.floor(math.log10(abs(value))))
    return f"{value:.{places}f}"


@cache
def _tick_s() -> float:
    """Return the step of the processor clock: 15.6 ms on Windows, well below 1 ms elsewhere."""
    start = time.process_time()
    while (now := time.process_time()) == start:
        pass
    return now - start


def processor_ms(work: Callable[[], Result]) -> tuple[Result, float]:
    """Repeat `work` until the processor clock has ticked often enough.

    Return the last result and the processor time of one repetition, ms.
    """
    enough_s, start, runs, took_s = _TICKS * _tick_s(), time.process_time(), 0, 0.0
    while took_s < enough_s:
        result, runs = work(), runs + 1
        took_s = time.process_time() - start
    return result, 1e3 * took_s / runs


def in_turns(names: Sequence[Name], rounds: int, warm_up: int) -> Iterator[tuple[Name, bool]]:
    """Yield each name once per round, and whether the round counts.

    The order changes from round to round, so that no case always follows the same case and profits
    from the same caches. The seed is fixed.
    """
    order = random.Random(0)
    for turn in range(-warm_up, rounds):
        for name in order.sample(names, len(names)):
            yield name, turn >= 0
