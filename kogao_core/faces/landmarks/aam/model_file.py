"""Read the model's file: plain arrays in an .npz, nothing that could run."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.language import Text
from kogao_core.faces.landmarks.aam.features import DIRECTIONS
from kogao_core.faces.landmarks.aam.model import (
    KEYPOINTS,
    PLACING,
    Model,
    Packed,
    Scale,
    ShapeModel,
    Start,
    Update,
)
from kogao_core.faces.landmarks.aam.points import COUNT
from kogao_core.faces.landmarks.locked import ModelRefused

FORMAT: Final = 1
MOST_BYTES: Final = 4_000_000
_MOST_SCALES, _MOST_UPDATES, _MOST_MODES, _MOST_PLACES = 8, 16, 200, 4000

# What zipfile and numpy raise on files that are none of ours.
_UNREADABLE: Final = (
    *(OSError, EOFError, KeyError, ValueError, RuntimeError, MemoryError),
    *(zipfile.BadZipFile, struct.error, zlib.error),
)

Arrays = Mapping[str, npt.NDArray[Any]]


def read(path: Path) -> Model:
    """Read a model. Raises ModelRefused."""
    try:
        return _model(_read_arrays(path))
    except _UNREADABLE as error:
        reason = Text("{name} can't be read as a Kogao face model", name=path.name)
        detail = " ".join(str(error).split()).rstrip(".")
        raise ModelRefused(
            Text(
                "{reason} ({detail}); reinstall Kogao or train the model again",
                reason=reason,
                detail=detail,
            )
        ) from error


def _read_arrays(path: Path) -> Arrays:
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(Text("it is larger than {most_bytes} bytes", most_bytes=MOST_BYTES))
    with zipfile.ZipFile(path) as archive:
        # A stored entry can't unpack to more than the file holds.
        if any(entry.compress_type != zipfile.ZIP_STORED for entry in archive.infolist()):
            raise ValueError(Text("its arrays are compressed"))
        if archive.testzip() is not None:
            raise ValueError(Text("it is damaged"))
    with np.load(path, allow_pickle=False) as stored:
        version = _checked(stored, "format", np.int32, (1,))
        if version[0] != FORMAT:
            raise ValueError(
                Text(
                    "it has format {version}, this program reads {format}",
                    version=version[0],
                    format=FORMAT,
                )
            )
        return {name: stored[name] for name in stored.files}


def _checked(
    arrays: Arrays, name: str, kind: npt.DTypeLike, shape: tuple[int, ...]
) -> npt.NDArray[Any]:
    if name not in arrays:
        raise ValueError(Text("{name} is missing", name=name))
    array = arrays[name]
    if array.dtype != kind or array.shape != shape:
        raise ValueError(
            Text(
                "{name} has type {dtype} and shape {shape}, not {expected}",
                name=name,
                dtype=array.dtype,
                shape=array.shape,
                expected=shape,
            )
        )
    if not np.isfinite(array).all():
        raise ValueError(Text("{name} isn't finite", name=name))
    return array


def _length(arrays: Arrays, name: str, axis: int, most: int) -> int:
    shape = np.shape(arrays.get(name, 0))
    length = shape[axis] if len(shape) > axis else 0
    if not 1 <= length <= most:
        raise ValueError(Text("{name} has shape {shape}", name=name, shape=shape))
    return int(length)


def _model(arrays: Arrays) -> Model:
    modes = _length(arrays, "modes", 1, PLACING + _MOST_MODES)
    flat = 2 * COUNT

    def floats(name: str, *shape: int) -> npt.NDArray[np.float64]:
        return np.asarray(_checked(arrays, name, np.float32, shape), np.float64)

    shape = ShapeModel(
        floats("mean", COUNT, 2),
        floats("modes", flat, modes),
        floats("deviations", modes - PLACING),
    )
    start = Start(
        floats("start_keypoints", 2 * KEYPOINTS),
        floats("start_shape", flat),
        floats("start_slopes", 2 * KEYPOINTS, flat),
    )
    scales = _scales(arrays, modes)
    return Model(shape, start, scales, float(floats("most_residual", 1)[0]))


def _scales(arrays: Arrays, modes: int) -> tuple[Scale, ...]:
    count = _length(arrays, "units_px", 0, _MOST_SCALES)
    units = _checked(arrays, "units_px", np.float32, (count,))
    updates = _checked(arrays, "updates", np.int32, (count,))
    if (
        units.min() < 4.0
        or units.max() > 200.0
        or updates.min() < 1
        or updates.max() > _MOST_UPDATES
    ):
        raise ValueError(Text("its scales make no sense"))
    return tuple(
        _scale(arrays, index, float(units[index]), int(updates[index]), modes)
        for index in range(count)
    )


def _scale(arrays: Arrays, index: int, unit_px: float, updates: int, modes: int) -> Scale:
    places = _length(arrays, f"places_{index}", 0, _MOST_PLACES)
    depth = DIRECTIONS * places
    kept = _length(arrays, f"appearance_{index}", 1, _MOST_MODES)

    def packed(name: str, columns: int) -> Packed:
        values = _checked(arrays, name, np.int8, (depth, columns))
        return Packed(values, _checked(arrays, f"{name}_scales", np.float32, (columns,)))

    positions = _checked(arrays, f"places_{index}", np.float32, (places, 2))
    if np.abs(positions).max() > 4.0:
        raise ValueError(Text("places_{index} lie far from any face", index=index))
    return Scale(
        unit_px,
        positions,
        _checked(arrays, f"average_{index}", np.float32, (depth,)),
        packed(f"appearance_{index}", kept),
        tuple(
            Update(
                packed(f"update_{index}_{step}", modes),
                _checked(arrays, f"constant_{index}_{step}", np.float32, (modes,)),
            )
            for step in range(updates)
        ),
    )
