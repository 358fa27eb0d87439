"""Learn the outline's edge again: `python -m resources.training.edges DATA LABELS MODEL`."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import click
import cv2
import numpy as np

from kogao_core.atomic import put
from kogao_core.geometry import Array
from kogao_core.landmarks.edges import network, refine
from kogao_core.landmarks.edges.network import Floats
from kogao_core.landmarks.edges.strips import planes
from kogao_core.landmarks.outline import resampled
from kogao_core.threads import one_blas_thread

from ..evaluate import Labels, distance_to_line
from .examples import studio, wild
from .learn import LabelledCut, learn

Pair = tuple[LabelledCut, Labels]


@click.command()
@click.argument("data", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("labels", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("model", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--folds", default=0, help="Measure on people left out, in that many rounds.")
def main(data: Path, labels: Path, model: Path, folds: int) -> None:
    """Learn from the photographs in DATA and the hand labels LABELS; write the file MODEL."""
    cv2.setNumThreads(1)
    with one_blas_thread():
        pairs = [*studio(data), *wild(data, labels)]
        click.echo(f"{len(pairs)} labelled outlines")
        if folds:
            _cross_validate(pairs, folds, data)
        parameters = learn([one for one, _ in pairs])
    names = [f"{index:02}" for index in range(len(parameters))]
    with io.BytesIO() as stream:
        np.savez(stream, allow_pickle=False, **dict(zip(names, parameters, strict=True)))
        put(stream.getvalue(), model)


def _cross_validate(pairs: Sequence[Pair], folds: int, data: Path) -> None:
    names = sorted({one.name for one, _ in pairs})
    order = np.random.default_rng(1).permutation(len(names))
    fold_of = {names[at]: place % folds for place, at in enumerate(order)}
    before: dict[str, list[float]] = {}
    after: dict[str, list[float]] = {}
    for fold in range(folds):
        parameters = learn([one for one, _ in pairs if fold_of[one.name] != fold])
        for one, labels in pairs:
            if fold_of[one.name] == fold:
                group = Path(one.name).relative_to(data).parts[0]
                still = np.zeros(len(one.moves))
                before.setdefault(group, []).append(_error(one, labels, still))
                after.setdefault(group, []).append(_error(one, labels, _moves(parameters, one)))
    for group, errors in before.items():
        click.echo(f"{group:12}{np.mean(errors):6.2f} ->{np.mean(after[group]):6.2f} %")


def _moves(parameters: list[Floats], one: LabelledCut) -> Array:
    outputs = network.forward(parameters, planes(one.cut.strip(one.lines))[None])
    return refine.settle(*refine.split(outputs[0]))[0]


def _error(one: LabelledCut, labels: Labels, moves: Array) -> float:
    outline = one.cut.to_image(resampled(one.lines.moved(moves), 21))
    seen = np.ones(6 + len(labels.jaw), bool) if labels.seen is None else labels.seen
    apart = distance_to_line(labels.jaw[seen[6:]], outline)
    return float(apart.mean() / labels.unit_px)


if __name__ == "__main__":
    main()
