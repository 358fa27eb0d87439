"""Input of the networks: 8-bit RGB, repeatedly halved, sampled without aliasing."""

from __future__ import annotations

import copy
import math
import threading
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.display import Rgb8, rgb8
from kogao_core.base.geometry import Affine, Array, Box, Image, check_image
from kogao_core.base.threads import default_threads, parallel_for

_ROWS: Final = 64  # rows per step of a halving, so that the source stays in the processor's cache
# Detail (standard deviation) of a sharp face in each octave, finest first, relative to the fifth
# octave, in a crop with 80 to 100 px between the eyes. 95 of 100 portraits have more detail.
_SHARP: Final = np.array([0.20, 0.30, 0.43, 0.67], np.float32)
# Exponent of the gain of an octave. Soft faces lack most at the fine end of each octave, so the
# gain is larger than the missing detail.
_RAISED: Final = 2.0
_MOST_RAISED: Final = 10.0  # largest gain of an octave; larger values amplify noise
# Below this many source px per result px, sample with a cubic, which is smooth between large px.
_ENLARGED: Final = 0.5


class Pyramid:
    """An image and repeatedly halved copies, created on demand. Thread-safe."""

    def __init__(self, image: Image) -> None:
        check_image(image)
        self.image = image
        self._mirrored = False
        self._covered: Sequence[Array] = ()
        self._halved: list[Rgb8] = []
        self._lock = threading.Lock()

    @staticmethod
    def of(image: Image | Pyramid) -> Pyramid:
        """Return `image` if it is a pyramid, else a new pyramid of the image."""
        return image if isinstance(image, Pyramid) else Pyramid(image)

    def mirrored(self) -> Pyramid:
        """Return the image with mirrored pixels beyond its edges."""
        result = copy.copy(self)
        result._mirrored = True
        return result

    def covered(self, parts: Sequence[Array]) -> Pyramid:
        """Return the image with flat colour inside convex polygons, each (N, 2) px."""
        result = copy.copy(self)
        result._covered = parts
        return result

    @cached_property
    def _whole(self) -> Rgb8:
        return rgb8(self.image)

    @property
    def width(self) -> int:
        """Columns of the full image, px."""
        return int(self.image.shape[1])

    @property
    def height(self) -> int:
        """Rows of the full image, px."""
        return int(self.image.shape[0])

    def _level(self, wanted: int) -> tuple[int, Rgb8]:
        with self._lock:
            while len(self._halved) < wanted:
                last = self._halved[-1] if self._halved else self.image
                if max(last.shape[:2]) < 2:
                    break
                self._halved.append(_half(last))
            wanted = min(wanted, len(self._halved))
            return wanted, self._halved[wanted - 1] if wanted else self._whole

    def at_most(self, longer_px: int) -> tuple[Rgb8, int]:
        """Return the largest level with a longer side of at most `longer_px`, and its index."""
        longer, index = max(self.width, self.height), 0
        while longer >> index > longer_px:
            index += 1
        index, level = self._level(index)
        return level, index

    def sample(self, to_image: Affine, size_px: int, border: int = cv2.BORDER_CONSTANT) -> Rgb8:
        """Resample a square of the image. Result uint8 (size_px, size_px, 3)."""
        # Bilinear sampling aliases when it shrinks. Use the coarsest level without loss of detail,
        # sample at twice the density and average 2 x 2 px.
        shrink = max(1.0, to_image.scale)
        index, level = self._level(int(math.log2(shrink)))
        dense = 2 if shrink / 2**index > 1.0 else 1
        to_level = Affine.resize(0.5**index, 0.5**index).after(to_image)
        to_level = to_level.after(Affine.resize(dense, dense).inverse)
        border = cv2.BORDER_REFLECT if self._mirrored else border
        picture = _warped(level, to_level, dense * size_px, border)
        if dense == 2:
            picture = cv2.resize(picture, (size_px, size_px), interpolation=cv2.INTER_AREA)
        picture = np.asarray(picture, np.uint8)
        for part in self._covered:
            inside = np.zeros(picture.shape[:2], np.uint8)
            cv2.fillConvexPoly(inside, np.round(to_image.inverse(part)).astype(np.int32), 1)
            picture[inside > 0] = np.round(cv2.mean(picture, inside)[:3])
        return picture


def read_network(weights: Path) -> cv2.dnn.Net:
    """Load a TFLite network with OpenCV's classic engine; the new engine can't run the file."""
    engine: dict[str, Any] = {}
    if hasattr(cv2.dnn, "ENGINE_CLASSIC"):  # OpenCV 4 has one engine
        engine["engine"] = cv2.dnn.ENGINE_CLASSIC
    return cv2.dnn.readNetFromTFLite(str(weights), **engine)


def planes(picture: Rgb8) -> npt.NDArray[np.float32]:
    """Convert a picture (H, W, 3) to a network input (1, 3, H, W), 0 to 255."""
    return np.stack(cv2.split(picture)).astype(np.float32)[None]


def sharpened(picture: Rgb8) -> Rgb8:
    """Amplify the octaves of detail that a soft face lacks; leave a sharp face unchanged.

    Scales the levels of a Laplacian pyramid to the detail of sharp faces. Shape (H, W, 3).
    """
    octaves = len(_SHARP)
    grey = _octaves(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), octaves + 1)
    spread = np.array([float(level.std()) for level, _ in grey]) + 1e-6
    gains = np.clip((_SHARP * spread[octaves] / spread[:octaves]) ** _RAISED, 1.0, _MOST_RAISED)
    if gains.max() == 1.0:
        return picture
    levels = _octaves(picture, octaves)
    result = levels[-1][1]
    for (level, _), gain in zip(reversed(levels), reversed(gains), strict=True):
        result = cv2.pyrUp(result, dstsize=level.shape[1::-1]) + np.float32(gain) * level
    return np.asarray(np.clip(result, 0.0, 255.0), np.uint8)


def _octaves(picture: Any, octaves: int) -> list[tuple[Any, Any]]:
    """Return (detail of this octave, coarser rest) for each octave, the finest first."""
    levels: list[tuple[Any, Any]] = []
    finer: Any = np.asarray(picture, np.float32)
    for _ in range(octaves):
        coarser = cv2.pyrDown(finer)
        levels.append((finer - cv2.pyrUp(coarser, dstsize=finer.shape[1::-1]), coarser))
        finer = coarser
    return levels


def _half(image: Image) -> Rgb8:
    """Return the means of 2 x 2 pixels of an image, as 8-bit RGB."""
    rows, columns = (max(1, side // 2) for side in image.shape[:2])
    half = np.empty((rows, columns, 3), np.uint8)

    def fill(top: int) -> None:
        bottom = min(rows, top + _ROWS)
        # Exact halves take OpenCV's fast path: far quicker than one large INTER_AREA step.
        even = rgb8(image[2 * top : 2 * bottom, : 2 * columns])
        part = half[top:bottom]
        cv2.resize(even, part.shape[1::-1], dst=part, interpolation=cv2.INTER_AREA)

    parallel_for(range(0, rows, _ROWS), lambda: fill, default_threads())
    return half


def _warped(level: Rgb8, to_level: Affine, side_px: int, border: int) -> Any:
    # Crop to the sampled part: OpenCV's warps refuse sources beyond 32766 px.
    last = side_px - 1
    corners = to_level([(0, 0), (last, 0), (0, last), (last, last)])
    low = np.floor(corners.min(axis=0)).astype(int) - 3
    high = np.ceil(corners.max(axis=0)).astype(int) + 4
    if border == cv2.BORDER_REFLECT:  # include the pixels that are mirrored
        size = np.array(level.shape[1::-1])
        low, high = np.minimum(low, 2 * size - high), np.maximum(high, -low)
    box = Box(*low, *high).clipped(Box.of(level))
    if box.area == 0:
        return np.zeros((side_px, side_px, 3), np.uint8)
    to_box = Affine(to_level.matrix, to_level.shift - (box.left, box.top))
    how = cv2.INTER_CUBIC if to_level.scale < _ENLARGED else cv2.INTER_LINEAR
    flags = how | cv2.WARP_INVERSE_MAP
    part = level[box.slices]
    return cv2.warpAffine(part, to_box.opencv, (side_px, side_px), flags=flags, borderMode=border)
