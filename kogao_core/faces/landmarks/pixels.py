"""What the networks look through: 8-bit RGB, halved again and again, sampled without aliasing."""

from __future__ import annotations

import math
import threading
from functools import cached_property
from typing import Any, Final
from weakref import WeakValueDictionary

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.display import Rgb8, rgb8
from kogao_core.base.geometry import Affine, Box, Image
from kogao_core.base.threads import default_threads, share_out

_ROWS: Final = 64  # halved at a time: what they are made of stays within the processor's cache


class Pyramid:
    """An image and its halvings, made when first needed; threads may share it."""

    def __init__(self, image: Image) -> None:
        rgb8(image[:1] if image.ndim else image)  # says so where it isn't an image
        self._image = image
        self._halved: list[Rgb8] = []
        self._lock = threading.Lock()

    @staticmethod
    def of(image: Image) -> Pyramid:
        """Return the one that somebody holds of the same array, or another."""
        held = _HELD.get(id(image))
        if held is None:
            held = _HELD[id(image)] = Pyramid(image)  # it keeps the array, and so its id
        return held

    @cached_property
    def _whole(self) -> Rgb8:
        return rgb8(self._image)

    @property
    def width(self) -> int:
        """Columns of the full image, px."""
        return int(self._image.shape[1])

    @property
    def height(self) -> int:
        """Rows of the full image, px."""
        return int(self._image.shape[0])

    def _level(self, wanted: int) -> tuple[int, Rgb8]:
        with self._lock:
            while len(self._halved) < wanted:
                last = self._halved[-1] if self._halved else self._image
                if max(last.shape[:2]) < 2:
                    break
                self._halved.append(_half(last))
            wanted = min(wanted, len(self._halved))
            return wanted, self._halved[wanted - 1] if wanted else self._whole

    def at_most(self, longer_px: int) -> tuple[Rgb8, int]:
        """Return the largest level whose longer side is no longer, and how often it is halved."""
        longer, index = max(self.width, self.height), 0
        while longer >> index > longer_px:
            index += 1
        index, level = self._level(index)
        return level, index

    def sample(self, to_image: Affine, size_px: int, border: int = cv2.BORDER_CONSTANT) -> Rgb8:
        """Resample a square of the image. Result uint8 (size_px, size_px, 3)."""
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


_HELD: Final = WeakValueDictionary[int, Pyramid]()


def planes(picture: Rgb8) -> npt.NDArray[np.float32]:
    """Return a picture of shape (H, W, 3) as a network takes it, (1, 3, H, W); 0 to 255."""
    return np.stack(cv2.split(picture)).astype(np.float32)[None]


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

    share_out(range(0, rows, _ROWS), lambda: fill, default_threads())
    return half


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
