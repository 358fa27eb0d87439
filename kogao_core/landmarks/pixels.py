"""What the networks look through: 8-bit RGB, halved again and again, sampled without aliasing."""

from __future__ import annotations

import math
import threading
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.display import Rgb8, rgb8
from kogao_core.geometry import Affine, Box, Image


class Pyramid:
    """An image and its halvings, made when first needed; threads may share it.

    Parameters
    ----------
    image : array of shape (H, W) or (H, W, C)
        See `rgb8`.
    """

    def __init__(self, image: Image) -> None:
        self._levels = [rgb8(image)]
        self._lock = threading.Lock()

    @property
    def width(self) -> int:
        """Columns of the full image, px."""
        return int(self._levels[0].shape[1])

    @property
    def height(self) -> int:
        """Rows of the full image, px."""
        return int(self._levels[0].shape[0])

    def _level(self, wanted: int) -> tuple[int, Rgb8]:
        with self._lock:
            while len(self._levels) <= wanted and max(self._levels[-1].shape[:2]) >= 2:
                last = self._levels[-1]
                rows, columns = (max(1, side // 2) for side in last.shape[:2])
                # Exact halves take OpenCV's fast path: far quicker than one large INTER_AREA step.
                even = last[: 2 * rows, : 2 * columns]
                half = cv2.resize(even, (columns, rows), interpolation=cv2.INTER_AREA)
                self._levels.append(np.asarray(half, np.uint8))
        wanted = min(wanted, len(self._levels) - 1)
        return wanted, self._levels[wanted]

    def at_most(self, longer_px: int) -> tuple[Rgb8, int]:
        """Return the largest level whose longer side is no longer, and how often it is halved."""
        index, level = 0, self._levels[0]
        while max(level.shape[:2]) > longer_px:
            index, level = self._level(index + 1)
        return level, index

    def sample(self, to_image: Affine, size_px: int, border: int = cv2.BORDER_CONSTANT) -> Rgb8:
        """Resample a square of the image.

        Parameters
        ----------
        to_image : Affine
            Maps pixel centres of the result to the full image.
        size_px : int
            Side of the result.
        border : int
            OpenCV border mode outside the image; black by default.

        Returns
        -------
        uint8 array of shape (size_px, size_px, 3)
        """
        # Bilinear sampling aliases when it shrinks: go down the pyramid as far as no detail is
        # lost, then sample twice as dense and average 2 x 2.
        shrink = max(1.0, to_image.scale)
        index, level = self._level(int(math.log2(shrink)))
        dense = 2 if shrink / 2**index > 1.0 else 1
        to_level = Affine.resize(0.5**index, 0.5**index).after(to_image)
        to_level = to_level.after(Affine.resize(dense, dense).inverse)
        picture = _warped(level, to_level, dense * size_px, border)
        if dense == 2:
            picture = cv2.resize(picture, (size_px, size_px), interpolation=cv2.INTER_AREA)
        return np.asarray(picture, np.uint8)


def planes(values: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return a picture of shape (H, W, 3) as a network takes it, (1, 3, H, W)."""
    return np.ascontiguousarray(values.transpose(2, 0, 1)[None])


def _warped(level: Rgb8, to_level: Affine, side_px: int, border: int) -> Any:
    # Only the part that is looked at: OpenCV's warps refuse sources beyond 32766 px.
    last = side_px - 1
    corners = to_level([(0, 0), (last, 0), (0, last), (last, last)])
    left, top = np.floor(corners.min(axis=0)).astype(int) - 2
    right, bottom = np.ceil(corners.max(axis=0)).astype(int) + 3
    box = Box(left, top, right, bottom).clipped(Box.of(level))
    if box.area == 0:
        return np.zeros((side_px, side_px, 3), np.uint8)
    to_box = Affine(to_level.matrix, to_level.shift - (box.left, box.top))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    part = level[box.slices]
    return cv2.warpAffine(part, to_box.opencv, (side_px, side_px), flags=flags, borderMode=border)
