"""Measure the edge network on faces left out of training: errors and confidence."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.faces.landmarks import edges
from kogao_core.faces.landmarks.edges import Floats, planes
from kogao_core.faces.landmarks.outline import resampled

from ..evaluate import Labels, area_under_curve, distance_to_line
from .learn import LabelledCut

_OUTLINE: Final = 21
_NEAR_PERCENT: Final = 3.0  # limit of a near point, as in `EdgeNetwork.refined`
_STEPS: Final = (0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Unseen:
    """A labelled face left out of training."""

    tags: tuple[str, ...]  # rows of the table
    # Mean distance of the visible labels from silhouette and from refined outline, %.
    before: float
    after: float
    apart: Array  # (N,): distance of each label from the refined outline, %
    confidence: Array  # (N,): confidence of the outline's nearest point
    seen: npt.NDArray[np.bool_]  # bool (N,): False where the edge is covered


def unseen(parameters: list[Floats], one: LabelledCut, labels: Labels) -> Unseen:
    """Run the network on a face and compare with the labels."""
    outputs = edges.forward(parameters, planes(one.cut.strip(one.lines))[None])
    moves, confidence = edges.settle(*edges.split(outputs[0]))
    seen = np.ones(len(labels.jaw), bool) if labels.seen is None else labels.seen[6:]
    still, _ = _outline(one, np.zeros(len(moves)), confidence)
    outline, confidence = _outline(one, moves, confidence)
    apart = distance_to_line(labels.jaw, outline) / labels.unit_px
    nearest = np.linalg.norm(labels.jaw[:, None] - outline, axis=-1).argmin(axis=1)
    before = distance_to_line(labels.jaw[seen], still).mean() / labels.unit_px
    after = float(apart[seen].mean())
    return Unseen(one.tags, float(before), after, apart, confidence[nearest], seen)


def _outline(one: LabelledCut, moves: Array, confidence: Array) -> tuple[Array, Array]:
    even = resampled(np.column_stack([one.lines.moved(moves), confidence]), _OUTLINE)
    return one.cut.to_image(even[:, :2]), even[:, 2]


def errors(faces: Sequence[Unseen]) -> Iterator[str]:
    """Yield a line for each tag: silhouette and refined outline."""
    for tag in sorted({tag for one in faces for tag in one.tags}):
        group = [one for one in faces if tag in one.tags]
        before = np.mean([one.before for one in group])
        after = np.array([one.after for one in group])
        p95 = np.percentile(after, 95)
        yield f"{tag:12}{len(group):4} {before:6.2f} ->{after.mean():6.2f} % (p95 {p95:.2f})"


def reliability(faces: Sequence[Unseen], tag: str) -> Iterator[str]:
    """Yield a line for each range of confidence: mean, share of visible and near points."""
    group = [one for one in faces if tag in one.tags]
    said = np.concatenate([one.confidence for one in group])
    held = np.concatenate([one.seen & (one.apart <= _NEAR_PERCENT) for one in group])
    off = 0.0
    for low, high in pairwise(_STEPS):
        within = (said >= low) & (said < high + (high == 1.0))
        if within.any():
            sure, right = said[within].mean(), held[within].mean()
            off += within.mean() * abs(sure - right)
            yield f"{tag} {low:.1f} to {high:.1f}: {within.sum()} say {sure:.2f}, {right:.2f} are"
    hidden = ~np.concatenate([one.seen for one in group])
    area = area_under_curve(said[hidden], said[~hidden])
    yield f"{tag}: off by {off:.3f} on average; area under the curve {area:.2f} for hidden"
