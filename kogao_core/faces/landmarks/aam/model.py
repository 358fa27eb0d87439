"""The learnt model: shape modes, where to start, per scale the appearance and its updates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.landmarks.aam.features import Floats
from kogao_core.faces.landmarks.aam.points import similarity
from kogao_core.faces.landmarks.blazeface import Detection

KEYPOINTS: Final = 6
_MARGIN: Final = 0.3  # of the outer inter-ocular distance; faces differ from the mean by less
_NEAR: Final = 0.12
PLACING: Final = 4  # the first modes of a shape place the face: scale, turn, two shifts
_MOST_DEVIATIONS: Final = 3.0


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
        """Return parameters (4 + K,) whose last K are held within 3 standard deviations."""
        most = _MOST_DEVIATIONS * self.deviations
        own = np.clip(parameters[PLACING:], -most, most)
        return np.concatenate([parameters[:PLACING], own])

    def placed(self, points: Array) -> Affine:
        """Return the similarity that lays the mean on a shape of any frame."""
        return similarity(self.mean, points)


@dataclass(frozen=True, eq=False)
class Packed:
    """A matrix kept in bytes, with one scale per column."""

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
    """What the face looks like at one size, and the steps taken there."""

    unit_px: float  # outer inter-ocular distance of the mean face, px
    places: Floats  # float32 (P, 2): where the mean face is sampled, in units of the shape model
    average: Floats  # float32 (8 P,): mean features there
    appearance: Packed  # appearance modes (8 P, K), orthonormal columns but for rounding
    updates: tuple[Update, ...]  # steps from coarse to fine

    @property
    def corner(self) -> Array:
        """Middle of the first pixel of a picture of this scale, in units of the shape model."""
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
        """Return what the appearance modes leave of features (8 P,) or (N, 8 P)."""
        rest = features - self.average
        modes = self.appearance.matrix
        return np.asarray(rest - (rest @ modes) @ modes.T)


@dataclass(frozen=True, eq=False)
class Start:
    """Where the landmarks lie, judged by the detector alone; lengths in sides of its box."""

    keypoints: Array  # (12,): mean of the six keypoints
    shape: Array  # (2 V,): mean of the landmarks
    slopes: Array  # (12, 2 V): how the landmarks follow the keypoints

    def points(self, box: Detection) -> Array:
        """Return the landmarks (V, 2) in px of the image of a box."""
        to_image = box_frame(box)
        shape = self.shape
        if box.keypoints_px is not None:
            seen = to_image.inverse(box.keypoints_px).ravel()
            shape = shape + (seen - self.keypoints) @ self.slopes
        return to_image(shape.reshape(-1, 2))


def box_frame(box: Detection) -> Affine:
    """Return the map from sides of a box, turned with it, to px."""
    return Affine.similarity(box.side_px, box.degrees, box.center_px)


@dataclass(frozen=True, eq=False)
class Model:
    """An Active Appearance Model with learnt updates (section 3.1)."""

    shape: ShapeModel  # mean and modes of the landmarks
    start: Start  # first guess
    scales: tuple[Scale, ...]  # from coarse to fine
    most_residual: float  # fits with a larger residual deserve little trust

    @cached_property
    def motions(self) -> tuple[Floats, ...]:
        """Per scale: how its places move with the parameters, (P, 2, 4 + K)."""
        modes = self.shape.modes.reshape(len(self.shape.mean), 2, -1)
        weights = (
            carried(self.shape.mean, scale.places.astype(np.float64)) for scale in self.scales
        )
        return tuple(np.einsum("pv,vdk->pdk", one, modes).astype(np.float32) for one in weights)

    @cached_property
    def nearness(self) -> Floats:
        """Weight of each place of the finest scale for each landmark; rows (V, P) sum to 1."""
        apart = self.shape.mean[:, None] - self.scales[-1].places
        weights = np.exp(-((np.linalg.norm(apart, axis=-1) / _NEAR) ** 2))
        return np.asarray(weights / weights.sum(axis=1, keepdims=True), np.float32)


def carried(mean: Array, positions: Array) -> Array:
    """Return how places between the landmarks follow them: weights of shape (P, V).

    A biharmonic spline through the landmarks; beyond them it goes on without waves.
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
