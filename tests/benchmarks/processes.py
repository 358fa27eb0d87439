"""What a process costs, as JSON: ``python tests/benchmarks/processes.py COMMAND...``.

The command runs as the child of this small process: Linux counts what the parent of a process held
before the child's own memory, so a large parent would hide the child's peak.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

TESTS = str(Path(__file__).resolve().parents[1])
CLI = (sys.executable, "-c", "from kogao_core.cli import main; main()")
EDITOR = (sys.executable, "-m", "kogao_app")


@dataclass(frozen=True, slots=True)
class Cost:
    """What a process and those that it started and waited for took."""

    wall_ms: float
    cpu_ms: float  # user and system mode
    peak_mb: float  # largest resident size of any of them, 10^6 bytes


def run(*command: object) -> Cost:
    """Run a command to its end and return what it took; end with what it said if it fails."""
    words = [sys.executable, "-S", __file__, *map(str, command)]
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "PYTHONPATH": TESTS}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # installed programs are compiled already
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(words[3:])} ended with {done.returncode}:\n{done.stderr}")
    return Cost(**json.loads(done.stdout))


def _measured(command: list[str]) -> int:
    start = time.perf_counter()
    done = subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
    wall_ms = (time.perf_counter() - start) * 1e3
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    unit = 1.0 if sys.platform == "darwin" else 1024.0  # bytes there, KiB here
    cost = {
        "wall_ms": wall_ms,
        "cpu_ms": (used.ru_utime + used.ru_stime) * 1e3,
        "peak_mb": used.ru_maxrss * unit / 1e6,
    }
    print(json.dumps(cost))
    return done.returncode


if __name__ == "__main__":
    sys.exit(_measured(sys.argv[1:]))
