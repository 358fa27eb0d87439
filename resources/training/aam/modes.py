"""Shape, first guess and appearance from examples: Procrustes, least squares, principal modes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.landmarks.aam.model import Floats, Packed, ShapeModel, Start, box_frame
from kogao_core.faces.landmarks.aam.points import EYES, MIRROR, MOUTH, OUTLINE, similarity

from .examples import Example
from .labels import MIRRORED_X, interocular
from .writing import packed

_ROUNDS: Final = 5
_START_RIDGE: Final = 0.02
_OUTWARD: Final = 0.22  # margin of the picture beyond the outline
# Corners of the forehead's region, relative to the middle of the eyes.
_FOREHEAD: Final = ((-1.0, -0.45), (-0.6, -0.75), (0.6, -0.75), (1.0, -0.45))


def shape_model(shapes: Sequence[Array], explained: float) -> ShapeModel:
    """Return the mean and the modes that explain a share of the variance. `shapes` (V, 2)."""
    mean = _normal(shapes[0])
    for _ in range(_ROUNDS):
        mean = _normal(np.mean([similarity(shape, mean)(shape) for shape in shapes], axis=0))
    laid = np.array([similarity(shape, mean)(shape) for shape in shapes])
    placing = _placing(mean)
    own = (laid - mean).reshape(len(laid), -1)
    own -= own @ placing @ placing.T
    modes, variances = _principal(own.T @ own / len(own), explained)
    return ShapeModel(mean, np.column_stack([placing, modes]), np.sqrt(variances))


def _normal(shape: Array) -> Array:
    shape = shape - shape.mean(axis=0)
    shape = (shape + shape[MIRROR] * MIRRORED_X) / 2.0
    return np.asarray(shape / interocular(shape))


def _placing(mean: Array) -> Array:
    turn = np.column_stack([-mean[:, 1], mean[:, 0]])
    shift_x, shift_y = np.zeros_like(mean), np.zeros_like(mean)
    shift_x[:, 0], shift_y[:, 1] = 1.0, 1.0
    # The mean is centred, so the four are orthogonal already.
    columns = np.column_stack([one.ravel() for one in (mean, turn, shift_x, shift_y)])
    return np.asarray(columns / np.linalg.norm(columns, axis=0))


def _principal(gram: Array, explained: float) -> tuple[Array, Array]:
    variances, modes = np.linalg.eigh(gram)
    variances, modes = variances[::-1], modes[:, ::-1]
    share = np.cumsum(variances) / variances.sum()
    kept = int(np.searchsorted(share, explained)) + 1
    return modes[:, :kept], variances[:kept]


def start_model(examples: Sequence[Example]) -> Start:
    """Learn the position of landmarks from the detector's box and keypoints."""
    frames = [box_frame(example.box).inverse for example in examples]
    pairs = list(zip(frames, examples, strict=True))
    seen = np.array([frame(_keypoints(one)).ravel() for frame, one in pairs])
    shapes = np.array([frame(one.shape).ravel() for frame, one in pairs])
    keypoints, shape = seen.mean(axis=0), shapes.mean(axis=0)
    seen -= keypoints
    gram = seen.T @ seen
    gram += _START_RIDGE * np.trace(gram) / len(gram) * np.eye(len(gram))
    return Start(keypoints, shape, np.linalg.solve(gram, seen.T @ (shapes - shape)))


def _keypoints(example: Example) -> Array:
    assert example.box.keypoints_px is not None
    return example.box.keypoints_px


def places(mean: Array, step: float) -> Floats:
    """Return a grid over the mean face, a margin and the forehead, (P, 2)."""
    eyes, middle = mean[EYES].mean(axis=0), mean[EYES + MOUTH].mean(axis=0)
    around = mean[OUTLINE] + _OUTWARD * (mean[OUTLINE] - middle)
    hull = cv2.convexHull(np.vstack([around, eyes + _FOREHEAD]).astype(np.float32))
    low, high = hull.min(axis=(0, 1)), hull.max(axis=(0, 1))
    half = int(high[0] / step)
    across = step * np.arange(-half, half + 1)
    grid = np.stack(np.meshgrid(across, np.arange(low[1], high[1], step)), axis=-1).reshape(-1, 2)
    inside = [cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0.0 for x, y in grid]
    return np.asarray(grid[inside], np.float32)


def appearance(features: Floats, explained: float, most: int) -> tuple[Floats, Packed]:
    """Return mean and modes of features (N, D) sampled at the true landmarks."""
    average = features.mean(axis=0)
    rest = features - average
    modes, _ = _principal((rest.T @ rest).astype(np.float64), explained)
    return average, packed(modes[:, :most].astype(np.float32))
