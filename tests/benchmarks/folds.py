"""Throw landmarks about and look for folds: ``python tests/benchmarks/folds.py [--drags N]``.

Each drag moves one to five landmarks or targets of one or two faces by up to the size of the face,
with settings from the whole range of the sliders. The guarded field is then looked at on a grid of
its own, at other places than the guard's; so is the field as asked for, where the report finds
nothing to say. ``--guard-off`` leaves the guarded half out, which takes most of the time.

A drag follows from its number and the seed, so that ``--first`` goes on where a run ended, and
``--first N --drags 1`` shows one again.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from scenes import oval_face

from kogao_core.base.threads import one_blas_thread
from kogao_core.faces.face import Face
from kogao_core.faces.targets import aim
from kogao_core.lab.reports.report import machine
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import SETTINGS
from kogao_core.warp.domain import fade_of
from kogao_core.warp.field import Field
from kogao_core.warp.fit import fit
from kogao_core.warp.guard import hold_back
from kogao_core.warp.limits import OutOfBounds
from kogao_core.warp.one_to_one import check_one_to_one

ZONES = ("cheeks", "jaw", "chin", "left", "right")
FITS = SETTINGS["fit"].choices
SAMPLES_PER_CELL = 11
MOST_SAMPLES = 250  # along an axis: bounds the time of tiny lattices
MEASURED_LOOKS = 8  # where the report has samples alone and no proof
BAD = {"folds rendered with the guard", "folds not reported", "folds certified"}
TOLD_EVERY = 1000  # drags


def thrown(rng: np.random.Generator) -> Face:
    """Return a face with a few points dragged somewhere else."""
    face = oval_face(center=(float(rng.choice([170.0, 330.0, 900.0])), 170.0))
    for _ in range(rng.integers(1, 6)):
        index = int(rng.integers(len(face.outline)))
        spot = face.outline[index] + rng.normal(0.0, np.exp(rng.uniform(0.0, 5.0)), 2)
        move = face.with_target if rng.random() < 0.5 else face.with_outline_point
        face = move(index, spot)
    return face


def any_recipe(rng: np.random.Generator) -> Recipe:
    """Return settings from the whole range of the sliders."""
    plain = Recipe(
        percent=rng.uniform(0.0, 15.0),
        center=int(rng.integers(1, 5)),
        lattice=float(np.exp(rng.uniform(np.log(0.25), np.log(4.0)))),
        fit=FITS[int(rng.integers(3))],
        threshold_px=float(rng.choice([1 / 64, rng.uniform(0.02, 2.0)])),
    )
    zones = {name: rng.uniform(0.0, 200.0) for name in ZONES if rng.random() < 0.5}
    return dataclasses.replace(plain, even_out=float(rng.choice([0.0, 50.0, 100.0])), **zones)


def lowest_det(field: Field, rng: np.random.Generator) -> float:
    """Return the smallest det J at random rows and columns of every lattice's reach."""
    lowest = 1.0
    for lattice in field.lattices:
        left, top, right, bottom = lattice.reach_px
        columns, rows = (
            min(MOST_SAMPLES, SAMPLES_PER_CELL * (count + 3)) for count in lattice.shape[::-1]
        )
        xs = np.sort(rng.uniform(left, right, columns))
        ys = np.sort(rng.uniform(top, bottom, rows))
        lowest = min(lowest, float(field.det_jacobian(xs, ys).min()))
    return lowest


def main() -> None:
    """Run and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drags", type=int, default=100_000)
    parser.add_argument("--seconds", type=float, default=3000.0, help="stop after this long")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, metavar="N", help="where to begin")
    parser.add_argument("--guard-off", action="store_true", help="look at the report alone")
    options = parser.parse_args()
    counts: Counter[str] = Counter()
    bad: dict[int, list[str]] = {}
    start = time.perf_counter()
    with one_blas_thread():
        for drag in range(options.first, options.first + options.drags):
            if time.perf_counter() - start > options.seconds:
                break
            seen = judge(np.random.default_rng((options.seed, drag)), options.guard_off)
            counts.update(["drags", *seen])
            if BAD.intersection(seen):
                bad[drag] = seen
            if counts["drags"] % TOLD_EVERY == 0:
                print(json.dumps({"last drag": drag, **counts}), file=sys.stderr, flush=True)
    seconds = round(time.perf_counter() - start, 1)
    told = {"machine": machine(), "seconds": seconds, **counts, "drags to look at": bad}
    print(json.dumps(told, indent=1))
    sys.exit(bool(bad))


def judge(rng: np.random.Generator, guard_off: bool) -> list[str]:
    """Return what one drag showed."""
    faces, recipe = [thrown(rng) for _ in range(int(rng.integers(1, 3)))], any_recipe(rng)
    pairs = [aim(face, recipe) for face in faces]
    try:
        lattices = fit(pairs, [face.anchor for face in faces], [recipe] * len(faces))
    except OutOfBounds:
        return ["refused: too many control points"]
    field = Field(lattices, fade_of(recipe))
    guarded = [] if guard_off else see_guarded(field, rng)
    report = check_one_to_one(field)
    if report.folds:
        return [*guarded, "reported as folding"]
    if not report.settled:
        return [*guarded, "reported as not proven"]
    looks = 1 if report.certified else MEASURED_LOOKS
    if min(lowest_det(field, rng) for _ in range(looks)) <= 0.0:
        return [*guarded, "folds certified" if report.certified else "folds not reported"]
    return [*guarded, "certified" if report.certified else "measured not to fold"]


def see_guarded(field: Field, rng: np.random.Generator) -> list[str]:
    """Return what the guard did with a field, and whether it still folds."""
    guarded, shares = hold_back(field)
    seen = []
    if min(shares) < 1.0:
        seen.append("held back")
    if guarded.fade_px != field.fade_px:
        seen.append("fade refused")
    if lowest_det(guarded, rng) <= 0.0:
        seen.append("folds rendered with the guard")
    return seen


if __name__ == "__main__":
    main()
