"""The learnt model: shape, where to start, and per scale the appearance and its updates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.landmarks.aam.features import Floats
from kogao_core.faces.landmarks.aam.shape import ShapeModel, carried
from kogao_core.faces.landmarks.blazeface import Detection

KEYPOINTS: Final = 6
_MARGIN: Final = 0.3  # of the outer inter-ocular distance; faces differ from the mean by less
_NEAR: Final = 0.12


@dataclass(frozen=True, eq=False)
class Packed:
    """A matrix kept in bytes, with one scale per column.

    Parameters
    ----------
    values : int8 array of shape (D, K)
    scales : float32 array of shape (K,)
    """

    values: np.ndarray
    scales: Floats

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
    """What the face looks like at one size, and the steps taken there.

    Parameters
    ----------
    unit_px : float
        Outer inter-ocular distance of the mean face, px.
    places : float32 array of shape (P, 2)
        Where the mean face is sampled, in units of the shape model.
    average : float32 array of shape (8 P,)
        Mean features there.
    appearance : Packed
        Appearance modes (8 P, K), orthonormal columns but for rounding.
    updates : tuple of Update
        Steps from coarse to fine.
    """

    unit_px: float
    places: Floats
    average: Floats
    appearance: Packed
    updates: tuple[Update, ...]

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
    """Where the landmarks lie, judged by the detector alone; lengths in sides of its box.

    Parameters
    ----------
    keypoints : array of shape (12,)
        Mean of the six keypoints.
    shape : array of shape (2 V,)
        Mean of the landmarks.
    slopes : array of shape (12, 2 V)
        How the landmarks follow the keypoints.
    """

    keypoints: Array
    shape: Array
    slopes: Array

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
    """An Active Appearance Model with learnt updates (section 3.1).

    Parameters
    ----------
    shape : ShapeModel
        Mean and modes of the landmarks.
    start : Start
        First guess.
    scales : tuple of Scale
        From coarse to fine.
    most_residual : float
        Fits with a larger residual deserve little trust.
    """

    shape: ShapeModel
    start: Start
    scales: tuple[Scale, ...]
    most_residual: float

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
