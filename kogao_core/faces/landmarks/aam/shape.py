"""Shape modes: a mean face and the ways in which faces differ from it (section 3.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.landmarks.aam.points import similarity

PLACING: Final = 4  # the first modes place the face: scale, turn, two shifts
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
