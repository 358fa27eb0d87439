"""Restores after random operations: ``python tests/benchmarks/originals.py [--count 5000]``.

Photos with equal results are edited in place, restored, moved, copied, changed and deleted at
random, with a store that is now too small and now not. A restore must never bring bytes that the
file has not held before.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from itertools import count
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from originals_oracle import Trial

STEPS = 60


def main() -> None:
    """Run trials and exit with 1 if a restore brought wrong bytes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=5000)
    options = parser.parse_args()
    restores, wrong = 0, list[str]()
    for seed in count():
        if restores >= options.count:
            break
        with tempfile.TemporaryDirectory() as folder:
            trial = Trial(Path(folder), random.Random(seed))
            wrong += trial.run(STEPS)
            restores += trial.restores
    print(f"{restores} restores, {len(wrong)} wrong", *wrong, sep="\n")
    raise SystemExit(bool(wrong))


if __name__ == "__main__":
    main()
