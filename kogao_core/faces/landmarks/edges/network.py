"""A very small convolutional network over strips, in numpy."""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]
Layer = tuple[int, int, int, int, int]

OUTPUTS: Final = 2  # how likely the edge is here; how likely it can't be seen at all
# Per layer: channels in and out, reach along the outline, taps across it and their distance.
# All is symmetric along the outline, so a mirrored face gets the mirrored answer.
LAYERS: Final[tuple[Layer, ...]] = (
    (5, 12, 1, 5, 1),
    (12, 12, 2, 5, 2),
    (12, 12, 4, 5, 2),
    (12, 12, 1, 3, 1),
    (12, OUTPUTS, 1, 1, 1),
)
LAST: Final = len(LAYERS) - 1  # its output stays as it is, the others' is cut off at zero


def shapes() -> list[tuple[int, ...]]:
    """Return the shapes of all parameters: weights and biases in turn."""
    result: list[tuple[int, ...]] = []
    for inputs, outputs, _, taps, _ in LAYERS:
        result += [(outputs, 2 * inputs * taps), (outputs, 1)]
    return result


def forward(parameters: list[Floats], strips: Floats) -> Floats:
    """Run the network. `strips` (B, 5, along, across). Result (B, 2, along, across)."""
    here = strips
    for index in range(len(LAYERS)):
        _, here = through(parameters, index, here)
    return here


def through(parameters: list[Floats], index: int, here: Floats) -> tuple[Floats, Floats]:
    """Return what one layer gathers from its input (B, C, along, across), and its output.

    `columns` (B, 2 C taps, along * across): each place's taps across and the sums of its
    neighbours' along; `output` (B, outputs, along, across).
    """
    columns = _columns(here, LAYERS[index])
    output = np.matmul(parameters[2 * index], columns) + parameters[2 * index + 1]
    if index < LAST:
        np.maximum(output, 0.0, out=output)
    return columns, output.reshape(len(here), -1, *here.shape[2:])


def _columns(here: Floats, layer: Layer) -> Floats:
    _, _, reach, taps, step = layer
    both = np.concatenate([here, neighbours(here, reach)], axis=1)
    middle = taps // 2
    parts = [shifted(both, (tap - middle) * step, axis=3) for tap in range(taps)]
    return np.concatenate(parts, axis=1).reshape(len(here), -1, here[0, 0].size)


def neighbours(here: Floats, reach: int) -> Floats:
    """Return the sums of the places `reach` before and after each along the outline (axis 2)."""
    return shifted(here, reach, axis=2) + shifted(here, -reach, axis=2)


def shifted(here: Floats, by: int, axis: int) -> Floats:
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
