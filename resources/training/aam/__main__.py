"""Train the Active Appearance Model: ``python -m resources.training.aam DATA OUT``.

DATA is the folder of shared photographs. ``--leave-out LABELS`` excludes the people in a file of
hand labels. ``--hold-out N`` (0 to 3) excludes every fourth person and measures the model on these
people. The same photographs give the same bytes.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import click
import cv2

from kogao_core.base.threads import one_blas_thread

from .examples import examples
from .faces import (
    Photographed,
    once_each,
    people_in,
    photographed,
)
from .labels import labeller
from .learn import Plan, learn, with_threshold
from .report import (
    Truth,
    area_under_curve,
    hand_labelled,
    results,
    table,
    truths,
)
from .writing import write

FOLDS: Final = 4
COMPOSITES: Final = "composites"
_PATH: Final = click.Path(path_type=Path)


@click.command()
@click.argument("data", type=_PATH)
@click.argument("out", type=_PATH)
@click.option("--leave-out", type=_PATH, metavar="LABELS")
@click.option("--hold-out", type=click.IntRange(0, FOLDS - 1))
def main(data: Path, out: Path, leave_out: Path | None, hold_out: int | None) -> None:
    """Train, write the model and report on held-out faces, if any."""
    cv2.setNumThreads(1)
    with one_blas_thread():
        train(data, out, leave_out, hold_out)


def train(data: Path, out: Path, leave_out: Path | None, hold_out: int | None) -> None:
    """Train on a folder of photographs, write the model, and measure it; see the module."""
    begin = time.perf_counter()

    def say(line: str) -> None:
        print(f"{time.perf_counter() - begin:5.0f} s  {line}", flush=True)

    everybody = photographed(data)
    away = _kept_away(everybody, leave_out, hold_out)
    faces = once_each(everybody)
    known = [face for face in faces if face.person not in away]
    say(f"{len(known)} faces to learn from, {len(faces) - len(known)} left out")
    plan, labels = Plan(), labeller(known)
    learning = examples(known, labels, plan.turns, plan.seed)
    write(with_threshold(learn(learning, plan, say), learning, plan), out)
    say(f"{out}: {out.stat().st_size / 1e6:.2f} MB")
    unseen = [face for face in faces if face.person in away and face.folder != COMPOSITES]
    by_hand = hand_labelled(leave_out, data) if leave_out else ()
    _measure(out, [*truths(unseen, labeller(faces)), *by_hand])


def _kept_away(
    faces: Sequence[Photographed], leave_out: Path | None, hold_out: int | None
) -> set[str]:
    away = people_in(leave_out, faces) if leave_out else set()
    if hold_out is not None:
        away |= set(list(dict.fromkeys(face.person for face in faces))[hold_out::FOLDS])
        # Composites are averages that may include held-out people.
        away |= {face.person for face in faces if face.folder == COMPOSITES}
    return away


def _measure(model: Path, known: Sequence[Truth]) -> None:
    if known:
        found = results(model, known)
        print("\n".join(table(found)))
        for percent in (5.0, 8.0):
            print(f"AUC of the score, error > {percent} %: {area_under_curve(found, percent):.2f}")


if __name__ == "__main__":
    main()
