"""Honest timing: every figure comes with its spread."""

from __future__ import annotations

import statistics
from collections.abc import Mapping

from kogao_core.experiments.machine import machine
from kogao_core.experiments.spread import Spread, take_turns

__all__ = ["machine", "ratio", "take_turns"]


def ratio(times: Mapping[str, list[float]], over: str, under: str) -> dict[str, float]:
    """Return the ratio of medians and the quartiles of the ratio round by round."""
    by_round = Spread.of([a / b for a, b in zip(times[over], times[under], strict=True)])
    return {
        "ratio": statistics.median(times[over]) / statistics.median(times[under]),
        "q1": by_round.q1,
        "q3": by_round.q3,
        "median_ms": statistics.median(times[over]),
        "unit_ms": statistics.median(times[under]),
    }
