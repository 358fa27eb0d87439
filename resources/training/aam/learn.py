"""Learn the model: first the modes, then a sequence of linear updates.

Each update is a linear map from the residual of the appearance modes to a change of the parameters,
as in the first Active Appearance Model of Cootes, Edwards and Taylor. Each update is learnt from
the errors of the previous update.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.landmarks.aam.fitting import Observation, fit, moved, observe
from kogao_core.faces.landmarks.aam.model import (
    DIRECTIONS,
    Floats,
    Model,
    Packed,
    Scale,
    Start,
    Update,
)

from .examples import Example, jittered, lit
from .labels import interocular
from .modes import appearance, places, shape_model, start_model
from .writing import packed

_LIT: Final = 0.6  # share of the pictures with changed light
_THREADS: Final = 2
_MOST_RESIDUALS: Final = 1500


@dataclass(frozen=True)
class ScalePlan:
    """One scale: its size, the step of its grid and its number of updates."""

    unit_px: float
    step_px: float
    updates: int


@dataclass(frozen=True)
class Plan:
    """Parameters of the training."""

    # From coarse to fine.
    scales: tuple[ScalePlan, ...] = (
        ScalePlan(14.0, 1.4, 3),
        ScalePlan(28.0, 2.4, 2),
        ScalePlan(52.0, 3.8, 2),
    )
    turns: int = 1  # turned views of each face, see `turned`
    starts: int = 4  # scattered starts of an example of weight 1
    # Share of the variance explained by the modes, for shape and for appearance.
    shape_share: float = 0.99
    appearance_share: float = 0.6
    most_appearance: int = 60  # largest number of appearance modes of a scale
    ridge: float = 1.0  # penalty of large updates, in mean variances of a feature
    # The residual of this share of the examples is accepted as a good fit.
    trusted_share: float = 0.995
    seed: int = 1  # of the random generator


Report = Callable[[str], None]


def learn(examples: Sequence[Example], plan: Plan, report: Report) -> Model:
    """Return the model learnt from examples; the same examples and plan give the same model."""
    shape = shape_model([one.shape for one in examples], plan.shape_share)
    model = Model(shape, start_model(examples), _blank_scales(shape.mean, plan), np.inf)
    report(f"{len(examples)} examples, {len(shape.deviations)} shape modes")
    for index in range(len(plan.scales)):
        model = _with_appearance(model, index, examples, plan)
        kept = len(model.scales[index].appearance.scales)
        report(f"scale {index}: {len(model.scales[index].places)} places, {kept} appearance modes")
    tasks, points = _starts(model.start, examples, plan)
    report(f"start: {_mean_error(tasks, points):.2f} % of the outer inter-ocular distance")
    for index, scale in enumerate(plan.scales):
        for _ in range(scale.updates):
            model, points = _with_update(model, index, tasks, points, plan)
            report(f"scale {index}: {_mean_error(tasks, points):.2f} %")
    return model


def _blank_scales(mean: Array, plan: Plan) -> tuple[Scale, ...]:
    nothing = np.zeros((0, 0), np.float32)
    return tuple(
        Scale(
            scale.unit_px,
            places(mean, scale.step_px / scale.unit_px),
            nothing[0:0].ravel(),
            Packed(nothing.astype(np.int8), nothing.ravel()),
            (),
        )
        for scale in plan.scales
    )


def _changed(model: Model, index: int, **changes: Any) -> Model:
    scales = list(model.scales)
    scales[index] = replace(scales[index], **changes)
    return replace(model, scales=tuple(scales))


def _with_appearance(model: Model, index: int, examples: Sequence[Example], plan: Plan) -> Model:
    def features(one: Example) -> Floats:
        return observe(model, index, one.crop, one.shape).features

    seen = _stacked(features, examples, model.scales[index])
    average, modes = appearance(seen, plan.appearance_share, plan.most_appearance)
    return _changed(model, index, average=average, appearance=modes)


def _stacked(one: Callable[[Any], Floats], over: Sequence[Any], scale: Scale) -> Floats:
    rows = np.empty((len(over), DIRECTIONS * len(scale.places)), np.float32)
    with ThreadPoolExecutor(_THREADS) as pool:
        for row, features in zip(rows, pool.map(one, over), strict=True):
            row[:] = features
    return rows


def _starts(
    start: Start, examples: Sequence[Example], plan: Plan
) -> tuple[list[Example], list[Array]]:
    tasks, points = [], []
    for number, example in enumerate(examples):
        for attempt in range(round(example.weight * plan.starts)):
            rng = np.random.default_rng((plan.seed, 1, number, attempt))
            tasks.append(example)
            points.append(_scattered(start, example, attempt, rng))
    return tasks, points


def _scattered(start: Start, example: Example, attempt: int, rng: np.random.Generator) -> Array:
    box = example.box
    if attempt % 4 == 1:  # simulates a box without keypoints
        return jittered(start.points(replace(box, keypoints_px=None)), rng, 1.0)
    assert box.keypoints_px is not None
    shaken = box.keypoints_px + 0.02 * box.side_px * rng.normal(size=box.keypoints_px.shape)
    first = start.points(replace(box, keypoints_px=shaken))
    return jittered(first, rng, 0.8 if attempt % 4 == 2 else 0.3)


def _with_update(
    model: Model, index: int, tasks: Sequence[Example], points: Sequence[Array], plan: Plan
) -> tuple[Model, list[Array]]:
    scale = model.scales[index]
    step = sum(len(one.updates) for one in model.scales)
    observations: list[Observation] = [None] * len(tasks)  # type: ignore[list-item]

    def features(number: int) -> Floats:
        rng = np.random.default_rng((plan.seed, 2, step, number))
        light = partial(lit, rng=rng) if rng.random() < _LIT else None
        at = observe(model, index, tasks[number].crop, points[number], light)
        observations[number] = replace(at, features=at.features[:0])
        return at.features

    rest = _stacked(features, range(len(tasks)), scale)
    _leave_unexplained(rest, scale)
    goals = np.array(
        [_goal(model, at, one.shape) for at, one in zip(observations, tasks, strict=True)]
    )
    update = _regressed(rest, goals, plan.ridge)
    model = _changed(model, index, updates=(*scale.updates, update))
    changes = rest @ update.matrix.matrix + update.constant
    return model, [
        moved(model, at, change) for at, change in zip(observations, changes, strict=True)
    ]


def _leave_unexplained(features: Floats, scale: Scale) -> None:
    # In place and in parts: the complete matrix has some hundred megabytes.
    for part in np.array_split(features, max(1, len(features) // 1000)):
        part[:] = scale.unexplained(part)


def _goal(model: Model, at: Observation, truth: Array) -> Array:
    target = model.shape.modes.T @ (at.placement.inverse(truth) - model.shape.mean).ravel()
    return np.asarray(target - at.parameters)


def _regressed(features: Floats, goals: Array, ridge: float) -> Update:
    """Return the ridge regression of goals (N, K) on features (N, D)."""
    middle, goal = features.mean(axis=0), goals.mean(axis=0)
    features -= middle
    gram = features.T @ features
    gram[np.diag_indices_from(gram)] += ridge * np.trace(gram) / len(gram)
    matrix = np.linalg.solve(gram, features.T @ (goals - goal).astype(np.float32))
    features += middle
    rounded = packed(matrix.astype(np.float32))
    return Update(rounded, (goal - middle @ rounded.matrix).astype(np.float32))


def _mean_error(tasks: Sequence[Example], points: Sequence[Array]) -> float:
    return float(np.mean([error_percent(one, at) for one, at in zip(tasks, points, strict=True)]))


def error_percent(example: Example, points: Array) -> float:
    """Return the mean distance of landmarks (80, 2), in % of the outer inter-ocular distance."""
    apart = np.linalg.norm(points - example.shape, axis=1).mean()
    return float(apart / interocular(example.shape) * 100.0)


def with_threshold(model: Model, examples: Sequence[Example], plan: Plan) -> Model:
    """Set the residual threshold so that `plan.trusted_share` of the examples stay below."""
    some = examples[:: max(1, len(examples) // _MOST_RESIDUALS)]
    residuals = [fit(model, one.crop, model.start.points(one.box)).residual for one in some]
    return replace(model, most_residual=float(np.quantile(residuals, plan.trusted_share)))
