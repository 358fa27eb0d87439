"""The network of `kogao_core.faces.landmarks.edges.network` backwards: gradients to learn from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kogao_core.faces.landmarks.edges import network
from kogao_core.faces.landmarks.edges.network import (
    LAST,
    LAYERS,
    Floats,
    Layer,
    neighbours,
    shifted,
)


@dataclass(frozen=True, slots=True)
class LayerPass:
    """What one layer needs to run backwards: its columns and its output."""

    columns: Floats
    output: Floats


def forward(parameters: list[Floats], strips: Floats) -> list[LayerPass]:
    """Run the network as `network.forward` does; the last layer's output is its."""
    here, passes = strips, []
    for index in range(len(LAYERS)):
        columns, here = network.through(parameters, index, here)
        passes.append(LayerPass(columns, here))
    return passes


def backward(parameters: list[Floats], passes: list[LayerPass], slope: Floats) -> list[Floats]:
    """Return the gradients of all parameters, given that of the outputs."""
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
