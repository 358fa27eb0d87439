"""Honest timing: cases take turns in one process, and every figure comes with its spread."""

from __future__ import annotations

import math
import random
import statistics
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

from kogao_core.base.language import Text

Name = TypeVar("Name")


@dataclass(frozen=True, slots=True)
class Spread:
    """Median and quartiles of some measurements, in their own unit."""

    median: float
    q1: float
    q3: float
    count: int

    @staticmethod
    def of(values: Sequence[float]) -> Spread:
        """Return the spread of at least one value; quartiles include the ends (Tukey's hinges)."""
        if not values:
            raise ValueError(Text("a spread needs at least one value"))
        ordered = sorted(values)
        half = (len(ordered) + 1) // 2
        return Spread(
            statistics.median(ordered),
            statistics.median(ordered[:half]),
            statistics.median(ordered[-half:]),
            len(ordered),
        )

    def text(self) -> str:
        """Return median and quartiles, such as ``12.3 (11.9-13.0)``; one value stands alone."""
        if self.count == 1:
            return rounded(self.median)
        low, high = rounded(self.q1), rounded(self.q3)
        return f"{rounded(self.median)} ({low}\N{EN DASH}{high})"


def in_columns(name: str, spread: Spread | None, unit_ms: float = 1.0) -> dict[str, object]:
    """Return median and quartiles, ms, as a record has them; None for a spread that isn't there."""
    ends = ("median", "q1", "q3")
    return {f"{name}_{end}_ms": spread and unit_ms * getattr(spread, end) for end in ends}


def rounded(value: float) -> str:
    """Return a number with three significant digits, never in powers of ten."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    places = max(0, 2 - math.floor(math.log10(abs(value))))
    return f"{value:.{places}f}"


def in_turns(names: Sequence[Name], rounds: int, warm_up: int) -> Iterator[tuple[Name, bool]]:
    """Yield every name once a round, and whether the round counts.

    Each round has an order of its own, drawn from the same seed in every run: what came before
    leaves caches behind, and none always follows the same other.
    """
    order = random.Random(0)
    for turn in range(-warm_up, rounds):
        for name in order.sample(names, len(names)):
            yield name, turn >= 0
