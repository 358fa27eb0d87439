"""Honest timing: cases take turns in one process, and every figure comes with its spread."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable, Mapping
from importlib.metadata import PackageNotFoundError, version

Case = Callable[[], object]
PACKAGES = (
    "kogao",
    "numpy",
    "opencv-contrib-python-headless",
    "scipy",
    "SimpleITK",
    "scikit-image",
    "facetweak",
)


def take_turns(cases: Mapping[str, Case], rounds: int) -> dict[str, list[float]]:
    """Run every case once a round, after one warm-up round; return the times of each, ms."""
    for case in cases.values():
        case()
    times: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(rounds):
        for name, case in cases.items():
            start = time.perf_counter()
            case()
            times[name].append((time.perf_counter() - start) * 1e3)
    return times


def ratio(times: Mapping[str, list[float]], over: str, under: str) -> dict[str, float]:
    """Return the ratio of medians and the quartiles of the ratio round by round."""
    by_round = sorted(a / b for a, b in zip(times[over], times[under], strict=True))
    quarter = len(by_round) // 4
    return {
        "ratio": statistics.median(times[over]) / statistics.median(times[under]),
        "q1": by_round[quarter],
        "q3": by_round[-1 - quarter],
        "median_ms": statistics.median(times[over]),
        "unit_ms": statistics.median(times[under]),
    }


def machine() -> dict[str, object]:
    """Return processor, cores and versions, for the head of a report."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in PACKAGES},
    }


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as stream:  # noqa: PTH123
            names = [line.split(":")[1].strip() for line in stream if line.startswith("model name")]
        return names[0] if names else platform.processor()
    except OSError:
        return platform.processor()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"
