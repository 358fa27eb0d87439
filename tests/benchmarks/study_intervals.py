"""Coverage of the 95 % intervals of shares in simulated studies.

Each rater has a threshold of his own and each face another, % of D: an answer is "unnatural" if the
warp distance exceeds the sum of both deviations, the mean threshold and logistic noise. The true
share is that of all raters and faces. Run: python tests/benchmarks/study_intervals.py STUDIES
"""

from __future__ import annotations

import math
import sys

import numpy as np

from kogao_core.lab.study.shares import Correlations, Judgement, Share

DISTANCES = (4.5, 6.8, 9.0)  # % of D
CENTERS = 4
MEAN, RATERS_SD, FACES_SD, NOISE = 7.0, 0.8, 0.5, 0.6  # % of D
DESIGNS = ((12, 6), (32, 25))  # raters, faces


def coverage(raters: int, faces: int, studies: int, seed: int) -> list[float]:
    """Return the share of intervals that contain the true share, by distance."""
    generator = np.random.default_rng(seed)
    many = 1_000_000
    people = math.hypot(RATERS_SD, FACES_SD) * generator.normal(size=many)
    thresholds = MEAN + people + NOISE * generator.logistic(size=many)
    truth = [float(np.mean(thresholds < distance)) for distance in DISTANCES]
    inside = np.zeros(len(DISTANCES))
    for _ in range(studies):
        limit = MEAN + RATERS_SD * generator.normal(size=(raters, 1))
        limit = limit + FACES_SD * generator.normal(size=(1, faces))
        kinds = []
        for distance in np.repeat(DISTANCES, CENTERS):
            said = limit + NOISE * generator.logistic(size=limit.shape) < distance
            kinds.append(tuple(Judgement(*place, bool(hit)) for place, hit in np.ndenumerate(said)))
        correlations = Correlations.of(kinds)
        for index, true in enumerate(truth):
            low, high = Share(kinds[index * CENTERS], correlations).interval
            inside[index] += low <= true <= high
    return list(inside / studies)


def main(studies: int) -> None:
    """Print a row for each design."""
    for raters, faces in DESIGNS:
        found = ", ".join(f"{100.0 * part:.1f} %" for part in coverage(raters, faces, studies, 1))
        print(f"{raters} raters, {faces} faces, {studies} studies: {found} at {DISTANCES} % of D")


if __name__ == "__main__":
    main(int(sys.argv[1]))
