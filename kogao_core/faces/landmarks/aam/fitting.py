"""Fit the model to a face: sample, compare with the appearance, update, repeat."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.landmarks.aam.model import (
    DIRECTIONS,
    Floats,
    Model,
    Update,
    directions,
    sampled,
)
from kogao_core.faces.landmarks.aam.points import MIRROR
from kogao_core.faces.landmarks.pixels import Pyramid

UNIT_PX: Final = 64.0  # outer inter-ocular distance in a crop; the finest scale needs 52
HALF_UNITS: Final = 2.4  # half side of a crop, in outer inter-ocular distances

Grey = npt.NDArray[np.uint8]
Light = Callable[[Grey], Grey]


class Crop:
    """The surroundings of one face in grey, with repeatedly halved copies."""

    def __init__(self, grey: Grey) -> None:
        self.levels = [grey]
        while len(self.levels) < 3:
            rows, columns = (length // 2 for length in self.levels[-1].shape)
            even = self.levels[-1][: 2 * rows, : 2 * columns]
            half = cv2.resize(even, (columns, rows), interpolation=cv2.INTER_AREA)
            self.levels.append(np.asarray(half, np.uint8))

    def seen(self, to_crop: Affine, size_px: tuple[int, int]) -> Grey:
        """Resample a part of the crop; `to_crop` maps pixel centres of the result to it."""
        level = min(2, max(0, int(np.log2(to_crop.scale * 1.25))))
        to_level = Affine.resize(0.5**level, 0.5**level).after(to_crop)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        seen = cv2.warpAffine(
            self.levels[level],
            to_level.opencv,
            size_px,
            flags=flags,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return np.asarray(seen, np.uint8)

    @property
    def mirrored(self) -> Crop:
        return Crop(np.ascontiguousarray(self.levels[0][:, ::-1]))

    def mirrored_points(self, points: Array) -> Array:
        """Mirror points (N, 2); keep the model's order."""
        return np.asarray(points * (-1.0, 1.0) + (self.levels[0].shape[1] - 1.0, 0.0))


@dataclass(frozen=True, eq=False)
class Fit:
    """The result of a fit."""

    points: Array  # (80, 2): landmarks, px of the picture it was fitted to
    residual: float  # mean square of the features not explained by the model
    residuals: Array  # (80,): mean square near each landmark


@dataclass(frozen=True, eq=False)
class Observation:
    """Features at the landmarks, and the landmarks' parameters in the placement's frame."""

    features: Floats
    parameters: Array
    placement: Affine


def observe(
    model: Model, index: int, crop: Crop, points: Array, light: Light | None = None
) -> Observation:
    """Sample the crop under landmarks (80, 2) at one of the model's scales.

    `light` changes the picture first; training varies brightness and noise with this function.
    """
    scale = model.scales[index]
    placement = model.shape.placed(points)
    grey = crop.seen(placement.after(scale.to_units), scale.size_px)
    parameters = model.shape.parameters(placement.inverse(points))
    moved = scale.places + model.motions[index] @ parameters.astype(np.float32)
    pixels = (moved - scale.corner.astype(np.float32)) * np.float32(scale.unit_px)
    features = sampled(directions(light(grey) if light else grey), pixels)
    return Observation(features.ravel(), parameters, placement)


def moved(model: Model, at: Observation, change: npt.NDArray[Any]) -> Array:
    """Return the landmarks (80, 2) after a change of parameters, limited to likely shapes."""
    return at.placement(model.shape.points(model.shape.clipped(at.parameters + change)))


def fit(model: Model, crop: Crop, points: Array) -> Fit:
    """Fit the model in a crop, starting from landmarks (80, 2), px of the crop."""
    for index, scale in enumerate(model.scales):
        for update in scale.updates:
            at = observe(model, index, crop, points)
            points = moved(model, at, _change(scale.unexplained(at.features), update))
    last = len(model.scales) - 1
    rest = model.scales[last].unexplained(observe(model, last, crop, points).features)
    unexplained = (rest * rest).reshape(-1, DIRECTIONS).mean(axis=1)
    return Fit(points, float(unexplained.mean()), model.nearness @ unexplained)


def _change(rest: Floats, update: Update) -> Floats:
    return np.asarray(rest @ update.matrix.matrix + update.constant)


def fit_both_ways(model: Model, picture: Pyramid, points: Array) -> Fit:
    """Fit the model to a picture and to its mirror image, and return the mean.

    A little more accurate than one fit, and the fit of a mirrored photo is the mirrored fit.
    `points` (80, 2) px.
    """
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    side_px = 2 * round(HALF_UNITS * UNIT_PX) + 1
    turn = model.shape.placed(points).matrix / UNIT_PX
    to_image = Affine(turn, middle - turn @ np.full(2, (side_px - 1) / 2.0))
    rgb = picture.sample(to_image, side_px, cv2.BORDER_REPLICATE)
    crop = Crop(np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.uint8))
    first = to_image.inverse(points)
    one = fit(model, crop, first)
    other = fit(model, crop.mirrored, crop.mirrored_points(first)[MIRROR])
    both = (one.points + crop.mirrored_points(other.points)[MIRROR]) / 2.0
    return Fit(
        to_image(both),
        (one.residual + other.residual) / 2.0,
        (one.residuals + other.residuals[MIRROR]) / 2.0,
    )
