"""Simulated rating studies: coverage of intervals, rules that exclude raters, and model.R.

Each rater has a threshold, % of D, and each face moves all thresholds. An answer is "unnatural" if
the warp distance exceeds the threshold of the rater, the deviation of the face and logistic noise.

    python tests/benchmarks/study.py intervals STUDIES
    python tests/benchmarks/study.py rules RATERS
    python tests/benchmarks/study.py model STUDIES    # needs R with lme4
"""

from __future__ import annotations

import csv
import itertools
import math
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from kogao_core.faces.naturalness import DISTANCES
from kogao_core.lab.study import data
from kogao_core.lab.study.design import RULES, Variant, variants
from kogao_core.lab.study.shares import Correlations, Judgement, Share
from kogao_core.lab.study.tally import Quality, follows

MEAN, RATERS_SD, FACES_SD, NOISE = 7.0, 0.8, 0.5, 0.6  # % of D
_CENTERS = 4


def coverage(
    raters: int, faces: int, studies: int, seed: int, distances: tuple[float, ...] = (4.5, 6.8, 9.0)
) -> list[float]:
    """Return the share of the intervals that contain the share of all raters and faces."""
    generator = np.random.default_rng(seed)
    many = 1_000_000
    people = math.hypot(RATERS_SD, FACES_SD) * generator.normal(size=many)
    thresholds = MEAN + people + NOISE * generator.logistic(size=many)
    inside = np.zeros(len(distances))
    for _ in range(studies):
        limit = MEAN + RATERS_SD * generator.normal(size=(raters, 1))
        limit = limit + FACES_SD * generator.normal(size=(1, faces))
        kinds = []
        for distance in np.repeat(distances, _CENTERS):
            said = limit + NOISE * generator.logistic(size=limit.shape) < distance
            kinds.append(tuple(Judgement(*place, bool(hit)) for place, hit in np.ndenumerate(said)))
        correlations = Correlations.of(kinds)
        for index, distance in enumerate(distances):
            low, high = Share(kinds[index * _CENTERS], correlations).interval
            inside[index] += low <= np.mean(thresholds < distance) <= high
    return list(inside / studies)


def excluded(
    kinds: tuple[Variant, ...],
    faces: int,
    raters: int,
    answer: Callable[[np.random.Generator, np.ndarray], np.ndarray],
    catches_seen: float,
    seed: int,
) -> float:
    """Return the share of raters whom the rules exclude, for a design and a way to answer."""
    generator = np.random.default_rng(seed)
    distances = np.array([kind.percent for kind in kinds if kind.is_judged] * faces)
    catches = sum(kind.kind == "catch" for kind in kinds) * faces
    count = 0
    for _ in range(raters):
        said = answer(generator, distances)
        caught = int(np.count_nonzero(generator.random(catches) < catches_seen))
        quality = Quality(
            "r", len(distances) + catches, 900.0, 0.0, len(distances), float(said.mean()),
            (float(distances.min()), float(distances.max())), 1, 0, 0, catches, caught,
            *follows(distances, said), 0, 0, (),
        )  # fmt: skip
        count += bool(quality.broken(RULES))
    return count / raters


def honest(mean: float, deviation: float) -> Callable[..., np.ndarray]:
    """Return a rater with a threshold drawn from a normal distribution, % of D."""

    def answer(generator: np.random.Generator, distances: np.ndarray) -> np.ndarray:
        limit = mean + deviation * generator.normal()
        return limit + NOISE * generator.logistic(size=len(distances)) < distances

    return answer


def guess(generator: np.random.Generator, distances: np.ndarray) -> np.ndarray:
    """Answer by the toss of a coin."""
    return generator.random(len(distances)) < 0.5


def thresholds_of_model(
    raters: int, faces: int, studies: int, seed: int, signed: tuple[float, ...], mean: float,
    slopes_sd: float, lapses: float,
) -> Iterator[dict[str, tuple[float, float, float]]]:  # fmt: skip
    """Yield the threshold and its interval per direction, as model.R prints them."""
    generator = np.random.default_rng(seed)
    script = Path(data.__file__).with_name("model.R").read_text(encoding="utf-8")
    for _ in range(studies):
        of_rater = RATERS_SD * generator.normal(size=raters)
        of_face = FACES_SD * generator.normal(size=faces)
        slope = np.exp(slopes_sd * generator.normal(size=raters)) / NOISE
        with tempfile.TemporaryDirectory() as name:
            with Path(name, "answers.csv").open("w", newline="", encoding="utf-8") as file:
                table = csv.writer(file)
                table.writerow(["study", "rater", "subject", "kind", "percent", "achieved_percent",
                                "center", "unnatural", "counts"])  # fmt: skip
                for r, f, percent, _pair in itertools.product(
                    range(raters), range(faces), signed, range(2)
                ):
                    past = abs(percent) - mean - of_rater[r] - of_face[f]
                    p = lapses + (1.0 - 2.0 * lapses) / (1.0 + math.exp(-slope[r] * past))
                    said = int(generator.random() < p)
                    table.writerow(["s", f"r{r}", f"f{f}", "table1", percent, percent, 2, said, 1])
            done = subprocess.run(
                ["Rscript", "-e", script], cwd=name, capture_output=True, text=True, check=True
            )
        yield {
            line.partition(":")[0]: tuple(map(float, re.findall(r"-?\d+\.\d+", line)[:3]))
            for line in done.stdout.splitlines()
            if "unnatural at" in line
        }


def main(what: str, number: int) -> None:
    """Print the results of one kind of simulation."""
    if what == "intervals":
        for raters, faces in ((12, 6), (32, 25)):
            found = ", ".join(f"{100.0 * part:.1f}" for part in coverage(raters, faces, number, 1))
            print(f"{raters} raters, {faces} faces: {found} % of the intervals hold the share")
    elif what == "rules":
        ten = tuple(Variant("table1", p, c, 1.0) for p in DISTANCES for c in (2, 3))
        default = variants(catch=True)
        catch = tuple(kind for kind in default if kind.kind == "catch")
        for design, kinds, faces in (
            ("10 pictures", ten + catch, 1), ("one face", default, 1), ("6 faces", default, 6)
        ):  # fmt: skip
            bots = excluded(kinds, faces, number, guess, 0.5, 1)
            good = [
                excluded(kinds, faces, number, honest(*limit), 0.98, 1)
                for limit in ((7.0, 0.8), (9.0, 2.5), (5.0, 1.5))
            ]
            told = ", ".join(f"{100.0 * part:.2f}" for part in good)
            print(f"{design}: excluded {100.0 * bots:.1f} % of guessers, {told} % of honest raters")
    elif what == "model":
        both = (-9.0, -7.0, -5.0, -3.0, 3.0, 5.0, 7.0, 9.0)
        for name, signed, mean, slopes, lapses in (
            ("equal slopes", both, 7.0, 0.0, 0.0), ("other slopes", both, 7.0, 0.4, 0.0),
            ("lapses", both, 7.0, 0.4, 0.03),
            ("one larger distance", (-4.0, 3.0, 5.0, 7.0, 9.0), 5.0, 0.0, 0.0),
        ):  # fmt: skip
            rows = list(thresholds_of_model(24, 6, number, 1, signed, mean, slopes, lapses))
            for direction in ("Larger", "Smaller"):
                found = np.array([row[direction] for row in rows if direction in row])
                inside = np.mean((found[:, 1] <= mean) & (mean <= found[:, 2]))
                print(f"{name}, {direction}: mean {found[:, 0].mean():.2f} for {mean}, "
                      f"{100.0 * inside:.1f} % of {len(found)} intervals hold it")  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
