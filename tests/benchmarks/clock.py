"""Honest timing: every figure comes with its spread."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping

from kogao_core.experiments.machine import machine
from kogao_core.experiments.spread import Spread, in_turns

__all__ = ["machine", "ratio", "take_turns"]


def take_turns(cases: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, list[float]]:
    """Run every case in turns, after one round that doesn't count; return the times of each, ms."""
    times: dict[str, list[float]] = {name: [] for name in cases}
    for name, counts in in_turns(list(cases), rounds, 1):
        start = time.perf_counter()
        cases[name]()
        elapsed_ms = (time.perf_counter() - start) * 1e3
        if counts:
            times[name].append(elapsed_ms)
    return times


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
