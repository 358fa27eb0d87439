"""Pixel rectangles and plane transforms; pixel centres are at whole numbers, y points down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.language import BadValue

Array = npt.NDArray[np.float64]
# Ends (x, y) of a straight line.
Line = tuple[tuple[float, float], tuple[float, float]]
# Pixels of shape (H, W) or (H, W, C); depth and channels are checked where they matter.
Image = npt.NDArray[Any]
_MAX_CHANNELS: Final = 4


def degrees_of(across: npt.ArrayLike) -> float:
    """Return the angle of a vector (x, y) from +x towards +y, -180 to 180 degrees."""
    x, y = np.asarray(across, np.float64)
    return float(np.degrees(np.arctan2(y, x)))


def smoothstep(share: Array) -> Array:
    """Return the cubic smoothstep: 0 up to 0, 1 from 1 on, with slope 0 at both ends."""
    t = np.clip(share, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


def arc_lengths(line: Array) -> Array:
    """Return the arc length of each point of a polyline (N, 2); the first is 0. Result: (N,)."""
    return np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))


def curve(points: Array, per_step: int = 8) -> Array:
    """Sample the Catmull-Rom curve through points of shape (N, dimensions)."""
    before = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    a, b, c, d = before[:-3], before[1:-2], before[2:-1], before[3:]
    t = (np.arange(per_step) / per_step)[:, None, None]
    curve = 0.5 * (
        2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3
    )
    return np.asarray(curve.transpose(1, 0, 2).reshape(-1, points.shape[1]))


_ROUND: Final = 0.3  # fraction of `ramp` that is rounded at each end


def ramp(share: Array) -> Array:
    """Return a linear ramp with rounded ends: 0 up to 0, 1 from 1 on.

    The largest slope is 1.43; a cubic smoothstep has 1.5, a quintic one 1.88.
    """
    t = np.clip(share, 0.0, 1.0)
    slope = 1.0 / (1.0 - _ROUND)
    low, high = slope * t**2 / (2.0 * _ROUND), 1.0 - slope * (1.0 - t) ** 2 / (2.0 * _ROUND)
    middle = slope * (t - _ROUND / 2.0)
    return np.asarray(np.where(t < _ROUND, low, np.where(t > 1.0 - _ROUND, high, middle)))


@dataclass(frozen=True, slots=True)
class Box:
    """A half-open rectangle of whole pixels: ``left <= x < right`` and ``top <= y < bottom``."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def width(self) -> int:
        """Columns, px."""
        return max(0, self.right - self.left)

    @property
    def height(self) -> int:
        """Rows, px."""
        return max(0, self.bottom - self.top)

    @property
    def area(self) -> int:
        return self.width * self.height

    @property
    def slices(self) -> tuple[slice, slice]:
        """Row and column slices that cut this box out of an image."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    def grown(self, margin_px: int) -> Box:
        """Return the box with `margin_px` added on every side."""
        return Box(
            self.left - margin_px,
            self.top - margin_px,
            self.right + margin_px,
            self.bottom + margin_px,
        )

    def clipped(self, other: Box) -> Box:
        """Return the part of this box inside `other`.

        Result: empty, of no area, where they don't meet.
        """
        return Box(
            max(self.left, other.left),
            max(self.top, other.top),
            min(self.right, other.right),
            min(self.bottom, other.bottom),
        )

    @staticmethod
    def of(image: Image) -> Box:
        """Return the box of a whole image of shape (H, W) or (H, W, C)."""
        return Box(0, 0, image.shape[1], image.shape[0])


def check_type(value: object, kind: type, source: str) -> None:
    """Raise TypeError if a value has another type; `source` tells where to get the right one."""
    if not isinstance(value, kind):
        raise TypeError(f"expected a {kind.__name__} {source}, got {type(value).__name__}")


def check_image(image: object) -> None:
    """Raise TypeError or ValueError if a value is not an array of pixels that can be warped."""
    if not isinstance(image, np.ndarray):
        kind = type(image).__name__
        raise TypeError(
            f"an image must be a numpy array, got {kind}; pass photo.pixels of a Photo, or "
            "numpy.asarray(image) of a PIL image"
        )
    if image.dtype not in (np.uint8, np.uint16, np.float32):
        convert = "; convert with .astype(numpy.float32)" if image.dtype == np.float64 else ""
        raise ValueError(f"pixels must be uint8, uint16 or float32, got {image.dtype}{convert}")
    channels = image.shape[2] if image.ndim == 3 else 1
    if image.ndim not in (2, 3) or not 1 <= channels <= _MAX_CHANNELS or 0 in image.shape:
        raise ValueError(
            "an image must have shape (H, W) or (H, W, 1..4) with at least one pixel, "
            f"got {image.shape}"
        )


def points_of(points_px: npt.ArrayLike) -> Array:
    """Return points as a float64 array of shape (N, 2). Raises ValueError."""
    points = np.asarray(points_px, np.float64)
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"points must have shape (N, 2), got {points.shape}")
    return points


def frozen(
    points: npt.ArrayLike, shape: tuple[int | None, ...] | None = None, *, gaps: bool = False
) -> Array:
    """Copy `points` to a read-only float64 array; `shape` is checked where given (None = any)."""
    array = np.array(points, dtype=np.float64)
    if shape is not None and (
        array.ndim != len(shape)
        or any(
            want is not None and want != got for want, got in zip(shape, array.shape, strict=True)
        )
    ):
        raise BadValue(
            "expected points of shape {shape}, got {got}",
            shape=str(shape).replace("None", "N"),
            got=array.shape,
        )
    if np.isinf(array).any() or (not gaps and np.isnan(array).any()):
        raise BadValue("coordinates must be finite numbers")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, slots=True, eq=False)
class Affine:
    """A plane map ``p -> matrix @ p + shift``, in px."""

    matrix: Array
    shift: Array

    def __call__(self, points: npt.ArrayLike) -> Array:
        """Map points of shape (..., 2)."""
        return np.asarray(np.asarray(points, np.float64) @ self.matrix.T + self.shift)

    @property
    def scale(self) -> float:
        """Linear magnification, sqrt(abs(det))."""
        return float(np.sqrt(abs(np.linalg.det(self.matrix))))

    @property
    def inverse(self) -> Affine:
        back = np.asarray(np.linalg.inv(self.matrix), np.float64)
        return Affine(back, -back @ self.shift)

    @property
    def opencv(self) -> Array:
        """The 2x3 matrix of OpenCV's warpAffine."""
        return np.column_stack([self.matrix, self.shift])

    def after(self, first: Affine) -> Affine:
        """Return the map that applies `first`, then this one."""
        return Affine(self.matrix @ first.matrix, self(first.shift))

    @staticmethod
    def similarity(scale: float, degrees: float, shift: npt.ArrayLike) -> Affine:
        """Return a turn by `degrees` (from +x towards +y), a scaling and a shift.

        `shift` (2,) px.
        """
        angle = np.deg2rad(degrees)
        cos, sin = np.cos(angle) * scale, np.sin(angle) * scale
        return Affine(np.array([[cos, -sin], [sin, cos]]), np.asarray(shift, np.float64))

    @staticmethod
    def resize(scale_x: float, scale_y: float) -> Affine:
        """Return the map of an image resize, which keeps pixel edges, not centres, in place.

        Result: from px of the old image to px of the new one.
        """
        scale = np.array([scale_x, scale_y])
        return Affine(np.diag(scale), (scale - 1.0) / 2.0)
