"""Train the edge network on labelled faces, in numpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array, Image
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import edges
from kogao_core.faces.landmarks.edges import (
    ACROSS,
    LAST,
    LAYERS,
    MOVES,
    Cut,
    Floats,
    Layer,
    Lines,
    lines_of,
    neighbours,
    planes,
    shifted,
)
from kogao_core.faces.landmarks.pixels import Pyramid

_REACH: Final = 38.0  # steps; farther labels belong to another part of the outline
_SOFT: Final = 1.2
_SPREADS: Final = 1.6 * np.array([1.0, 0.8, 0.8, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1])
_STEPS: Final = 1100
_BATCH: Final = 16
_RATE: Final = 4e-3
_DECAY: Final = 1e-3
_COVERED: Final = 0.6  # share of the examples with something in front of the face
# Share of examples with a stretched or shortened beard or neck, and the largest factor.
_STRETCHED: Final = 0.5
_LONGER: Final = 1.8


@dataclass(frozen=True, slots=True)
class LayerPass:
    """Columns and output of one layer, needed for backpropagation."""

    columns: Floats
    output: Floats


@dataclass(frozen=True, slots=True, eq=False)
class LabelledCut:
    """A labelled face as a crop."""

    name: str  # of the face
    cut: Cut  # the crop
    lines: Lines  # lines across the mesh's silhouette
    moves: Array  # (41,): steps to the label along each line; NaN without a label
    unseen: np.ndarray  # bool (41,): True where the edge is covered and the label is a guess
    weight: float  # relative frequency in the training
    tags: tuple[str, ...] = ()  # rows of the report


def labelled_cut(
    name: str,
    image: Pyramid,
    face: Face,
    label: Array,
    hidden: Sequence[int],
    weight: float,
    tags: tuple[str, ...] = (),
) -> LabelledCut:
    """Return the crop of a face with its labelled outline."""
    cut = Cut.of(image, face.eyes, face.outline)
    lines = lines_of(cut.to_image.inverse(face.outline))
    line = cut.to_image.inverse(label)
    moves = _moves(lines, line)
    reached = lines.moved(np.nan_to_num(moves))
    nearest = np.linalg.norm(reached[:, None] - line, axis=-1).argmin(axis=1)
    unseen = np.isin(nearest, list(hidden)) & np.isfinite(moves)
    return LabelledCut(name, cut, lines, moves, unseen, weight, tags)


def _moves(lines: Lines, label: Array) -> Array:
    """Return the steps along each normal to the labelled line; NaN without an intersection."""
    steps = np.diff(label, axis=0)
    towards = label[:-1] - lines.points[:, None]
    normals = lines.normals[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        area = normals[..., 0] * -steps[:, 1] + normals[..., 1] * steps[:, 0]
        far = (towards[..., 0] * -steps[:, 1] + towards[..., 1] * steps[:, 0]) / area
        part = (normals[..., 0] * towards[..., 1] - normals[..., 1] * towards[..., 0]) / area
    far[~((part >= 0.0) & (part <= 1.0) & (np.abs(far) < _REACH))] = np.nan
    nearest = np.nan_to_num(np.abs(far), nan=np.inf).argmin(axis=1)
    return np.asarray(far[np.arange(len(far)), nearest])


def learn(examples: Sequence[LabelledCut], seed: int = 0) -> list[Floats]:
    """Train the network on the labels (Adam, soft cross-entropy); return the parameters."""
    rng = np.random.default_rng(seed)
    parameters = [_start(shape, rng) for shape in edges.shapes()]
    mean = [np.zeros_like(one) for one in parameters]
    square = [np.zeros_like(one) for one in parameters]
    weights = np.array([one.weight for one in examples])
    for step in range(_STEPS):
        chosen = rng.choice(len(examples), _BATCH, p=weights / weights.sum())
        drawn = [_drawn(examples[index], examples, rng) for index in chosen]
        strips, moves, unseen = (np.stack(part) for part in zip(*drawn, strict=True))
        steps = forward(parameters, strips)
        slope = _slope(steps[-1].output, moves, unseen)
        gradients = backward(parameters, steps, slope)
        rate = _RATE * min(1.0, (step + 1) / (0.2 * _STEPS)) * (1.0 - step / _STEPS)
        for index, gradient in enumerate(gradients):
            mean[index] += 0.1 * (gradient - mean[index])
            square[index] += 0.01 * (gradient**2 - square[index])
            fresh = 1.0 - 0.9 ** (step + 1), 1.0 - 0.99 ** (step + 1)
            change = mean[index] / fresh[0] / (np.sqrt(square[index] / fresh[1]) + 1e-8)
            parameters[index] -= np.float32(rate) * (change + _DECAY * parameters[index])
    return parameters


def _start(shape: tuple[int, ...], rng: np.random.Generator) -> Floats:
    if shape[1] == 1:
        return np.zeros(shape, np.float32)
    return rng.normal(0.0, np.sqrt(1.5 / shape[1]), shape).astype(np.float32)


def _slope(outputs: Floats, moves: Array, unseen: np.ndarray) -> Floats:
    """Return the derivative of the mean loss over all labelled lines by the outputs."""
    seen, hidden = edges.split(outputs)
    known = np.isfinite(moves)
    clear = known & ~unseen
    goal = np.exp(-0.5 * ((MOVES - np.nan_to_num(moves)[..., None]) / _SOFT) ** 2)
    goal /= np.maximum(goal.sum(axis=-1, keepdims=True), 1e-9)
    share = np.exp(seen - seen.max(axis=-1, keepdims=True))
    share /= share.sum(axis=-1, keepdims=True)
    slope = np.zeros_like(outputs)
    window_seen, window_hidden = slope[:, 0], slope[:, 1]
    first = edges.INSIDE
    window_seen[..., first : first + len(MOVES)] = (share - goal) * clear[..., None]
    guess = 1.0 / (1.0 + np.exp(-np.clip(hidden, -30.0, 30.0)))
    window_hidden[..., first : first + len(MOVES)] = ((guess - unseen) * known / len(MOVES))[
        ..., None
    ]
    return np.asarray(slope / max(1, int(known.sum())), np.float32)


def _drawn(
    one: LabelledCut, others: Sequence[LabelledCut], rng: np.random.Generator
) -> tuple[Floats, Array, np.ndarray]:
    """Return a random variant: silhouette shifted, covered, stretched, mirrored, relit."""
    waves = np.cos(np.outer(np.linspace(0.0, np.pi, len(one.moves)), np.arange(len(_SPREADS))))
    off = waves @ rng.normal(0.0, _SPREADS)
    picture: Image = one.cut.picture
    unseen = one.unseen
    if rng.random() < _COVERED:
        source = others[int(rng.integers(len(others)))].cut.picture
        picture, covered = _covered(picture, one.lines, source, rng)
        edge = np.round(one.lines.moved(np.nan_to_num(one.moves))).astype(int)
        x, y = np.clip(edge, 0, len(picture) - 1).T
        unseen = unseen | covered[y, x]
    longer = _LONGER ** rng.uniform(-1.0, 1.0) if rng.random() < _STRETCHED else 1.0
    steps = off[:, None] + ACROSS
    steps = np.where(steps > 0.0, steps / longer, steps)
    moves = np.where(one.moves > 0.0, one.moves * longer, one.moves) - off
    moves[moves > MOVES[-1] + 1] = np.nan
    strip = Cut(picture, one.cut.to_image).strip(one.lines, steps)
    side = slice(None, None, -1 if rng.random() < 0.5 else 1)
    return planes(_relit(strip, rng)[side]), moves[side], unseen[side]


def _covered(
    picture: Image, lines: Lines, source: Image, rng: np.random.Generator
) -> tuple[Image, np.ndarray]:
    """Cover part of the outline by a blob or a strand from another picture."""
    middle = lines.points[int(rng.integers(len(lines.points)))] + rng.normal(0.0, 8.0, 2)
    axes = (rng.uniform(4.0, 12.0), rng.uniform(30.0, 90.0))
    if rng.random() < 0.5:
        axes = (rng.uniform(12.0, 45.0), rng.uniform(12.0, 45.0))
    mask = np.zeros(picture.shape[:2], np.float32)
    box = (tuple(middle), tuple(2.0 * np.array(axes)), float(rng.uniform(0.0, 180.0)))
    cv2.ellipse(mask, box, 1.0, -1)
    soft = cv2.GaussianBlur(mask, (0, 0), float(rng.uniform(0.5, 2.5)))[..., None]
    moved = np.roll(source, tuple(rng.integers(0, len(source), 2)), axis=(0, 1))
    return (picture + soft * (moved.astype(np.float32) - picture)).astype(np.uint8), mask > 0.5


def _relit(strip: Image, rng: np.random.Generator) -> Image:
    light: Array = np.asarray(strip, np.float64) / 255.0
    light = light ** rng.uniform(0.6, 1.6)
    light = light * rng.uniform(0.5, 1.15) * rng.uniform(0.92, 1.08, 3)
    if rng.random() < 0.15:
        light = np.repeat(light.mean(axis=2, keepdims=True), 3, axis=2)
    if rng.random() < 0.4:
        light = np.asarray(cv2.GaussianBlur(light, (0, 0), float(rng.uniform(0.5, 1.6))))
    light = light + rng.normal(0.0, rng.uniform(0.0, 0.03), light.shape)
    return np.asarray(np.clip(light, 0.0, 1.0) * 255.0, np.uint8)


def forward(parameters: list[Floats], strips: Floats) -> list[LayerPass]:
    """Run the network like `edges.forward`; the last layer's output is the network's output."""
    here, passes = strips, []
    for index in range(len(LAYERS)):
        columns, here = edges.through(parameters, index, here)
        passes.append(LayerPass(columns, here))
    return passes


def backward(parameters: list[Floats], passes: list[LayerPass], slope: Floats) -> list[Floats]:
    """Return the gradients of all parameters from the gradient of the outputs."""
    gradients: list[Floats] = []
    for index in reversed(range(len(passes))):
        passed = passes[index]
        if index < LAST:
            slope = slope * (passed.output > 0.0)
        flat = slope.reshape(len(slope), slope.shape[1], -1)
        weights = np.einsum("bop,bcp->oc", flat, passed.columns, optimize=True)
        gradients = [weights, flat.sum(axis=(0, 2))[:, None], *gradients]
        if index:
            columns = np.matmul(parameters[2 * index].T, flat)
            slope = _gathered(columns, LAYERS[index], slope.shape)
    return gradients


def _gathered(columns: Floats, layer: Layer, shape: tuple[int, ...]) -> Floats:
    inputs, _, reach, taps, step = layer
    parts = columns.reshape(shape[0], taps, 2 * inputs, *shape[2:])
    middle = taps // 2
    both = np.zeros_like(parts[:, 0])
    for tap in range(taps):
        both += shifted(parts[:, tap], (middle - tap) * step, axis=3)
    return np.asarray(both[:, :inputs] + neighbours(both[:, inputs:], reach))
