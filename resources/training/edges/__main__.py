"""Train the edge network: `python -m resources.training.edges DATA LABELS EDGES MODEL`."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import cv2
import numpy as np

from kogao_core.base.atomic import atomic_write
from kogao_core.base.threads import one_blas_thread

from ..evaluate import Labels
from .examples import beards, studio, wild
from .learn import LabelledCut, learn
from .report import Unseen, errors, reliability, unseen

Pair = tuple[LabelledCut, Labels]


@click.command()
@click.argument("data", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("labels", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("edges", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("model", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--folds", default=0, help="Measure on people left out, in that many rounds.")
def main(data: Path, labels: Path, edges: Path, model: Path, folds: int) -> None:
    """Learn from the photographs in DATA and the hand labels LABELS and EDGES; write MODEL."""
    cv2.setNumThreads(1)
    with one_blas_thread():
        pairs = [*studio(data), *wild(data, labels)]
        more = list(beards(data, edges))
        click.echo(f"{len(pairs)} labelled outlines, {len(more)} edges of beards")
        if folds:
            _cross_validate(pairs, more, folds)
        parameters = learn([*(one for one, _ in pairs), *more])
    named: dict[str, Any] = {f"{index:02}": one for index, one in enumerate(parameters)}
    with io.BytesIO() as stream:
        np.savez(stream, **named)
        atomic_write(stream.getvalue(), model)


def _cross_validate(pairs: Sequence[Pair], more: Sequence[LabelledCut], folds: int) -> None:
    names = sorted({one.name for one, _ in pairs})
    order = np.random.default_rng(1).permutation(len(names))
    fold_of = {names[at]: place % folds for place, at in enumerate(order)}
    faces: list[Unseen] = []
    for fold in range(folds):
        known = [one for one, _ in pairs if fold_of[one.name] != fold]
        parameters = learn([*known, *more])
        faces += [unseen(parameters, *pair) for pair in pairs if fold_of[pair[0].name] == fold]
    for line in (*errors(faces), *reliability(faces, "studio"), *reliability(faces, "wild")):
        click.echo(line)


if __name__ == "__main__":
    main()
