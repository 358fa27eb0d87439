"""Write the model's file, as `kogao_core.faces.landmarks.aam.model` reads it."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kogao_core.base.atomic import atomic_write
from kogao_core.faces.landmarks.aam.model import Floats, Model, Packed


def packed(matrix: Floats) -> Packed:
    """Quantise a matrix (D, K) to bytes."""
    scales = np.maximum(np.abs(matrix).max(axis=0), 1e-12).astype(np.float32) / np.float32(127)
    return Packed(np.rint(matrix / scales).astype(np.int8), scales)


def write(model: Model, path: Path) -> None:
    """Write the model; the same model gives the same bytes."""
    arrays: dict[str, Any] = dict(_arrays(model))
    # Stored, not compressed: zlib's output differs between versions, and saves little here.
    with io.BytesIO() as stream:
        np.savez(stream, **arrays)
        atomic_write(stream.getvalue(), path)


def _arrays(model: Model) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    yield "format", np.array([1], np.int32)
    yield "mean", model.shape.mean.astype(np.float32)
    yield "modes", model.shape.modes.astype(np.float32)
    yield "deviations", model.shape.deviations.astype(np.float32)
    yield "start_keypoints", model.start.keypoints.astype(np.float32)
    yield "start_shape", model.start.shape.astype(np.float32)
    yield "start_slopes", model.start.slopes.astype(np.float32)
    yield "most_residual", np.array([model.most_residual], np.float32)
    yield "units_px", np.array([scale.unit_px for scale in model.scales], np.float32)
    yield "updates", np.array([len(scale.updates) for scale in model.scales], np.int32)
    for index, scale in enumerate(model.scales):
        yield f"places_{index}", scale.places
        yield f"average_{index}", scale.average
        yield from _named(f"appearance_{index}", scale.appearance)
        for step, update in enumerate(scale.updates):
            yield from _named(f"update_{index}_{step}", update.matrix)
            yield f"constant_{index}_{step}", update.constant


def _named(name: str, packed: Packed) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    yield name, packed.values
    yield f"{name}_scales", packed.scales
