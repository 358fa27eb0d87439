"""The learnt model: shape modes, first guess, and for each scale the appearance and updates.

The features are edge directions, independent of the light. The file contains plain arrays in .npz
format and no executable content.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.landmarks import locked
from kogao_core.faces.landmarks.aam.points import similarity
from kogao_core.faces.landmarks.blazeface import Detection

Floats = npt.NDArray[np.float32]

# The model is learnt with these values; others need a new model.
DIRECTIONS: Final = 8  # directions of the gradient over a full turn
_SMOOTH_PX: Final = 1.0  # blur before the gradient (standard deviation); larger: less noise
_POOL_PX: Final = 1.5  # blur of each direction; larger: edges may lie farther off
_CONTRAST_PX: Final = 4.0  # blur of the contrast that edge strengths are divided by
_MARGIN: Final = 0.3  # of the outer inter-ocular distance; faces differ from the mean by less
# Radius round a landmark whose residual counts for its confidence, in the same unit.
_NEAR: Final = 0.12
PLACING: Final = 4  # the first modes of a shape place the face: scale, turn, two shifts
_MOST_DEVIATIONS: Final = 3.0  # limit of each mode, in its standard deviations


def directions(grey: npt.NDArray[np.uint8]) -> Floats:
    """Return edge strength by direction, normalised by the local contrast.

    Result float32 (H, W, 8): square roots of the share of each of eight directions of the gradient,
    0 to about 1.
    """
    smooth = cv2.GaussianBlur(grey.astype(np.float32), (0, 0), _SMOOTH_PX)
    across = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, scale=1.0 / 8.0)
    down = cv2.Sobel(smooth, cv2.CV_32F, 0, 1, scale=1.0 / 8.0)
    strength, angle = cv2.cartToPolar(across, down)
    turn = angle[..., None] * np.float32(DIRECTIONS / (2.0 * np.pi)) - _BINS
    turn -= DIRECTIONS * np.rint(turn / DIRECTIONS)
    bins = np.maximum(0.0, 1.0 - np.abs(turn)) * strength[..., None]
    pooled = cv2.GaussianBlur(bins, (0, 0), _POOL_PX)
    energy = cv2.GaussianBlur(np.einsum("ijk,ijk->ij", pooled, pooled), (0, 0), _CONTRAST_PX)
    return np.asarray(np.sqrt(pooled / np.sqrt(energy + 1.0)[..., None]), np.float32)


_BINS: Final = np.arange(DIRECTIONS, dtype=np.float32)  # number of each direction


def sampled(features: Floats, places: Floats) -> Floats:
    """Interpolate features (P, 8) at positions (P, 2), limited to the picture."""
    rows, columns, depth = features.shape
    x = np.clip(places[:, 0], 0.0, columns - 1.001)
    y = np.clip(places[:, 1], 0.0, rows - 1.001)
    left, top = x.astype(np.intp), y.astype(np.intp)
    u, v = (x - left)[:, None], (y - top)[:, None]
    flat, at = features.reshape(-1, depth), top * columns + left
    upper = flat[at] * (1.0 - u) + flat[at + 1] * u
    lower = flat[at + columns] * (1.0 - u) + flat[at + columns + 1] * u
    return np.asarray(upper * (1.0 - v) + lower * v, np.float32)


@dataclass(frozen=True, eq=False)
class ShapeModel:
    """Shapes as mean plus modes; lengths in outer inter-ocular distances, origin at the mean."""

    mean: Array  # (V, 2): the mean face
    # (2 V, 4 + K): orthonormal columns; the first four are scale, turn and shift of the mean.
    modes: Array
    deviations: Array  # (K,): standard deviation of each mode after the first four

    def points(self, parameters: Array) -> Array:
        """Return the shape (V, 2) of parameters (4 + K,)."""
        return self.mean + (self.modes @ parameters).reshape(-1, 2)

    def parameters(self, points: Array) -> Array:
        """Return the nearest parameters (4 + K,) of a shape (V, 2), within 3 deviations."""
        return self.clipped(self.modes.T @ (points - self.mean).ravel())

    def clipped(self, parameters: Array) -> Array:
        """Return parameters (4 + K,) with the last K limited to 3 standard deviations."""
        most = _MOST_DEVIATIONS * self.deviations
        own = np.clip(parameters[PLACING:], -most, most)
        return np.concatenate([parameters[:PLACING], own])

    def placed(self, points: Array) -> Affine:
        """Return the similarity from the mean to a shape in any frame."""
        return similarity(self.mean, points)


@dataclass(frozen=True, eq=False)
class Packed:
    """A matrix stored as bytes, with one scale per column."""

    values: np.ndarray  # int8 (D, K)
    scales: Floats  # float32 (K,)

    @cached_property
    def matrix(self) -> Floats:
        """The matrix, float32 (D, K)."""
        return np.asarray(self.values * self.scales, np.float32)


@dataclass(frozen=True, eq=False)
class Update:
    """One learnt step: parameters change by ``features @ matrix + constant``."""

    matrix: Packed
    constant: Floats


@dataclass(frozen=True, eq=False)
class Scale:
    """Appearance of the face at one size, with the learnt steps."""

    unit_px: float  # outer inter-ocular distance of the mean face, px
    places: Floats  # float32 (P, 2): sampling positions on the mean face, in shape model units
    average: Floats  # float32 (8 P,): mean features at these positions
    appearance: Packed  # appearance modes (8 P, K), orthonormal columns except for rounding
    updates: tuple[Update, ...]  # steps from coarse to fine

    @property
    def corner(self) -> Array:
        """Centre of the first pixel of a picture of this scale, in units of the shape model."""
        return np.asarray(self.places.min(axis=0) - _MARGIN, np.float64)

    @property
    def size_px(self) -> tuple[int, int]:
        """Columns and rows of a picture of this scale."""
        far = (self.places.max(axis=0) + _MARGIN - self.corner) * self.unit_px
        return int(np.ceil(far[0])) + 1, int(np.ceil(far[1])) + 1

    @property
    def to_units(self) -> Affine:
        """Map from pixel centres of a picture of this scale to units of the shape model."""
        return Affine(np.eye(2) / self.unit_px, self.corner)

    def unexplained(self, features: Floats) -> Floats:
        """Subtract the appearance modes from features (8 P,) or (N, 8 P); return the residual."""
        rest = features - self.average
        modes = self.appearance.matrix
        return np.asarray(rest - (rest @ modes) @ modes.T)


@dataclass(frozen=True, eq=False)
class Start:
    """First guess of the landmarks from the detector alone; lengths in sides of the box."""

    keypoints: Array  # (12,): mean of the six keypoints
    shape: Array  # (2 V,): mean of the landmarks
    slopes: Array  # (12, 2 V): linear dependence of the landmarks on the keypoints

    def points(self, box: Detection) -> Array:
        """Return the landmarks (V, 2) in px of the image of a box."""
        to_image = box_frame(box)
        shape = self.shape
        if box.keypoints_px is not None:
            seen = to_image.inverse(box.keypoints_px).ravel()
            shape = shape + (seen - self.keypoints) @ self.slopes
        return to_image(shape.reshape(-1, 2))


def box_frame(box: Detection) -> Affine:
    """Return the map from a box's frame (unit: one side, rotated with the box) to px."""
    return Affine.similarity(box.side_px, box.degrees, box.center_px)


@dataclass(frozen=True, eq=False)
class Model:
    """An Active Appearance Model with learnt updates (section 3.1)."""

    shape: ShapeModel  # mean and modes of the landmarks
    start: Start  # first guess
    scales: tuple[Scale, ...]  # from coarse to fine
    most_residual: float  # fits with a larger residual have little trust

    @cached_property
    def motions(self) -> tuple[Floats, ...]:
        """For each scale, the derivative of the positions by the parameters, (P, 2, 4 + K)."""
        modes = self.shape.modes.reshape(len(self.shape.mean), 2, -1)
        weights = (
            carried(self.shape.mean, scale.places.astype(np.float64)) for scale in self.scales
        )
        return tuple(np.einsum("pv,vdk->pdk", one, modes).astype(np.float32) for one in weights)

    @cached_property
    def nearness(self) -> Floats:
        """Weight of each position of the finest scale for each landmark; rows (V, P) sum to 1."""
        apart = self.shape.mean[:, None] - self.scales[-1].places
        weights = np.exp(-((np.linalg.norm(apart, axis=-1) / _NEAR) ** 2))
        return np.asarray(weights / weights.sum(axis=1, keepdims=True), np.float32)


def carried(mean: Array, positions: Array) -> Array:
    """Return weights (P, V) with which positions follow the landmarks.

    Uses a biharmonic spline through the landmarks, which extrapolates without waves.
    """

    def kernel(one: Array) -> Array:
        return np.asarray(np.linalg.norm(one[:, None] - mean, axis=-1))

    def plane(one: Array) -> Array:
        return np.column_stack([np.ones(len(one)), one])

    count = len(mean)
    system = np.zeros((count + 3, count + 3))
    system[:count, :count] = kernel(mean)
    system[:count, count:] = plane(mean)
    system[count:, :count] = plane(mean).T
    inverse = np.linalg.inv(system)[:, :count]
    return np.asarray(np.column_stack([kernel(positions), plane(positions)]) @ inverse)


def read(path: Path) -> Model:
    """Read a model file. Raises ModelRefused."""
    arrays = locked.arrays(path)

    def floats(name: str) -> Array:
        return arrays[name].astype(np.float64)

    def packed(name: str) -> Packed:
        return Packed(arrays[name], arrays[f"{name}_scales"])

    units, updates = (arrays[name].tolist() for name in ("units_px", "updates"))
    scales = (
        Scale(
            unit,
            arrays[f"places_{k}"],
            arrays[f"average_{k}"],
            packed(f"appearance_{k}"),
            tuple(
                Update(packed(f"update_{k}_{step}"), arrays[f"constant_{k}_{step}"])
                for step in range(steps)
            ),
        )
        for k, (unit, steps) in enumerate(zip(units, updates, strict=True))
    )
    return Model(
        ShapeModel(floats("mean"), floats("modes"), floats("deviations")),
        Start(floats("start_keypoints"), floats("start_shape"), floats("start_slopes")),
        tuple(scales),
        float(arrays["most_residual"][0]),
    )
