"""Lose no edit: ``python tests/benchmarks/interleavings.py [--runs N] [--seed S] [--json OUT]``.

Each run mixes edits, undo, redo, copies, projects, closing, opening, slow and full disks and
crashes at random in the real editor, without a screen. After every act an oracle of its own (see
``tests/interleaving.py``) asks whether all that the user made and did not discard is in the
document and, unless a file that was reported saved holds it, in a recovery file. Ends with 1 if
anything is lost.
"""

from __future__ import annotations

import argparse
import json
import logging
import multiprocessing
import os
import platform
import sys
import tempfile
import time
from collections import Counter
from functools import partial
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np
from bookkeeping import Lost
from interleaving import LATEST_S, Interleaving
from PySide6.QtWidgets import QApplication

RUNS_IN_A_PROCESS = 10


def begin() -> None:
    """Prepare a process for runs."""
    # Damaged photos and full disks are what it is about.
    logging.disable()
    QApplication([])


def trial(seed: int, acts: int) -> dict[str, object]:
    """Do one run and return what there is to count."""
    app = QApplication.instance()
    with tempfile.TemporaryDirectory(prefix="interleavings-") as folder:
        run = Interleaving(app, Path(folder), seed)
        lost = ""
        try:
            run.run(acts)
        except Lost as problem:
            lost = str(problem)
    return {"seed": seed, "lost": lost, "log": run.log, "counts": run.counts, "kept_s": run.kept_s}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--acts", type=int, default=60, help="in a run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path, metavar="OUT")
    options = parser.parse_args()
    counts: Counter[str] = Counter()
    kept_s: list[float] = []
    lost = []
    start = time.perf_counter()
    seeds = range(options.seed, options.seed + options.runs)
    one_run = partial(trial, acts=options.acts)
    spawn = multiprocessing.get_context("spawn")
    # A program that opens hundreds of windows one after the other is nobody's: few in a process.
    with spawn.Pool(1, initializer=begin, maxtasksperchild=RUNS_IN_A_PROCESS) as pool:
        for done in pool.imap(one_run, seeds):
            counts.update(done["counts"])
            kept_s += done["kept_s"]
            if done["lost"]:
                lost.append({"seed": done["seed"], "what": done["lost"], "acts": done["log"]})
                print(f"seed {done['seed']}: {done['lost']}", file=sys.stderr, flush=True)
            if done["seed"] % 10 == 0:
                print(f"{done['seed'] - options.seed + 1} runs", file=sys.stderr, flush=True)
    result = {
        "machine": f"{platform.machine()}, {os.cpu_count()} processors",
        "python": platform.python_version(),
        "runs": options.runs,
        "seed": options.seed,
        "seconds": round(time.perf_counter() - start),
        "acts": dict(sorted(counts.items())),
        "kept_ms": {
            name: round(1e3 * float(np.percentile(kept_s, share)), 1)
            for name, share in (("median", 50), ("p99", 99), ("most", 100))
        },
        "later_than_half_a_second": sum(taken > LATEST_S for taken in kept_s),
        "lost": lost,
    }
    print(json.dumps({**result, "lost": len(lost)}, indent=1))
    if options.json is not None:
        options.json.write_text(json.dumps(result, indent=1))
    return int(bool(lost))


if __name__ == "__main__":
    sys.exit(main())
