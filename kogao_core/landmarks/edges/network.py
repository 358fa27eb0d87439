"""A very small convolutional network over strips, in numpy, forwards and backwards."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]

# Per layer: channels in and out, reach along the outline, taps across it and their distance.
# All is symmetric along the outline, so a mirrored face gets the mirrored answer.
LAYERS: Final = ((5, 12, 1, 5, 1), (12, 12, 2, 5, 2), (12, 12, 4, 5, 2), (12, 12, 1, 3, 1))
OUTPUTS: Final = 2  # how likely the edge is here; how likely it can't be seen at all


@dataclass(frozen=True, slots=True)
class Step:
    """What one layer needs to run backwards: its columns and its output."""

    columns: Floats
    output: Floats


def shapes() -> list[tuple[int, ...]]:
    """Return the shapes of all parameters: weights and biases in turn."""
    result: list[tuple[int, ...]] = []
    for inputs, outputs, _, taps, _ in (*LAYERS, _last()):
        result += [(outputs, 2 * inputs * taps), (outputs, 1)]
    return result


def _last() -> tuple[int, int, int, int, int]:
    return (LAYERS[-1][1], OUTPUTS, 1, 1, 1)


def forward(parameters: list[Floats], strips: Floats) -> tuple[Floats, list[Step]]:
    """Run the network.

    Parameters
    ----------
    parameters : list of array
        See `shapes`.
    strips : array of shape (B, 5, along, across)
        Strips and their places.

    Returns
    -------
    outputs : array of shape (B, 2, along, across)
    steps : list of Step
        For `backward`.
    """
    here, steps = strips, []
    for index, layer in enumerate((*LAYERS, _last())):
        columns = _columns(here, layer)
        weights, bias = parameters[2 * index], parameters[2 * index + 1]
        here = np.matmul(weights, columns) + bias
        if index < len(LAYERS):
            np.maximum(here, 0.0, out=here)
        here = here.reshape(len(strips), -1, *strips.shape[2:])
        steps.append(Step(columns, here))
    return here, steps


def backward(parameters: list[Floats], steps: list[Step], slope: Floats) -> list[Floats]:
    """Return the gradients of all parameters, given that of the outputs."""
    gradients: list[Floats] = []
    for index in reversed(range(len(steps))):
        step = steps[index]
        if index < len(LAYERS):
            slope = slope * (step.output > 0.0)
        flat = slope.reshape(len(slope), slope.shape[1], -1)
        weights = np.einsum("bop,bcp->oc", flat, step.columns, optimize=True)
        gradients = [weights, flat.sum(axis=(0, 2))[:, None], *gradients]
        if index:
            layer = (*LAYERS, _last())[index]
            slope = _gathered(np.matmul(parameters[2 * index].T, flat), layer, slope.shape)
    return gradients


def _columns(here: Floats, layer: tuple[int, int, int, int, int]) -> Floats:
    _, _, reach, taps, step = layer
    both = np.concatenate([here, _neighbours(here, reach)], axis=1)
    middle = taps // 2
    shifted = [_shifted(both, (tap - middle) * step, axis=3) for tap in range(taps)]
    return np.concatenate(shifted, axis=1).reshape(len(here), -1, here[0, 0].size)


def _gathered(
    columns: Floats, layer: tuple[int, int, int, int, int], shape: tuple[int, ...]
) -> Floats:
    inputs, _, reach, taps, step = layer
    parts = columns.reshape(shape[0], taps, 2 * inputs, *shape[2:])
    middle = taps // 2
    both = np.zeros_like(parts[:, 0])
    for tap in range(taps):
        both += _shifted(parts[:, tap], (middle - tap) * step, axis=3)
    return np.asarray(both[:, :inputs] + _neighbours(both[:, inputs:], reach))


def _neighbours(here: Floats, reach: int) -> Floats:
    return _shifted(here, reach, axis=2) + _shifted(here, -reach, axis=2)


def _shifted(here: Floats, by: int, axis: int) -> Floats:
    """Return `here` read `by` places further on; zero where there is nothing."""
    if by == 0:
        return here
    result = np.zeros_like(here)
    source = [slice(None)] * here.ndim
    target = list(source)
    source[axis] = slice(max(0, by), min(here.shape[axis], here.shape[axis] + by))
    target[axis] = slice(max(0, -by), min(here.shape[axis], here.shape[axis] - by))
    result[tuple(target)] = here[tuple(source)]
    return result
