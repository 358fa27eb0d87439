"""Intervals of a share of answers, and of grades."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

# The standard normal quantile of 97.5 %.
_Z: Final = 1.959963984540054


@dataclass(frozen=True, slots=True)
class Share:
    """A share of answers with its 95 % interval, 0 to 1."""

    # How many of how many.
    hits: int
    answers: int

    @property
    def value(self) -> float:
        """The share; NaN without answers."""
        return self.hits / self.answers if self.answers else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's score interval (J. Amer. Statist. Assoc. 22, 1927, 209-212), without correction.

        With n answers, share p and quantile z its middle is ``(p + z²/2n) / (1 + z²/n)`` and its
        half width ``z sqrt(p (1 - p) / n + z²/4n²) / (1 + z²/n)``. It never leaves 0 to 1 and,
        unlike the textbook's, has a width when all answers agree. Without answers it is 0 to 1.
        """
        if not self.answers:
            return 0.0, 1.0
        share, extra = self.value, _Z * _Z / self.answers
        middle = (share + extra / 2.0) / (1.0 + extra)
        spread = share * (1.0 - share) / self.answers + extra / (4.0 * self.answers)
        half = _Z * math.sqrt(spread) / (1.0 + extra)
        # Rounding must not take the ends past the shares that they equal exactly.
        low = 0.0 if self.hits == 0 else max(0.0, middle - half)
        high = 1.0 if self.hits == self.answers else min(1.0, middle + half)
        return low, high


@dataclass(frozen=True, slots=True)
class Grades:
    """Mean and sample standard deviation of grades; NaN where there are too few."""

    count: int
    mean: float
    deviation: float

    @staticmethod
    def of(values: Sequence[float]) -> Grades:
        """Return what grades amount to."""
        mean = statistics.fmean(values) if values else math.nan
        deviation = statistics.stdev(values) if len(values) > 1 else math.nan
        return Grades(len(values), mean, deviation)
