"""Masks: grey pictures of a photo's size whose white pixels must not move.

Grey values count in `STEPS` steps: step k protects the set of pixels with at least k / STEPS of
white. A displacement is multiplied by the mean of the fades of all sets, so each bound that holds
for one set holds for the mask.
"""

from __future__ import annotations

import dataclasses
import hashlib
import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array, Image
from kogao_core.base.language import BadValue
from kogao_core.photo.reading import read

STEPS: Final = 4
MOST_RUNS: Final = 2**19  # of equal pixels, in a project
_WIDE: Final = 1024  # positions in a row of a call of OpenCV, which allows 32,766
# Bilinear interpolation of exact distances changes by at most this, px per px.
_STEEPEST: Final = np.sqrt(2.0)
_NOWHERE_PX: Final = 1e6


@dataclass(frozen=True, eq=False)
class Mask:
    """Protected pixels of a photo, from a grey picture."""

    steps: npt.NDArray[np.uint8]  # (h, w): 0 moves freely to `STEPS`, which stays
    to_mask: Affine  # from px of the photo to px of the mask

    @staticmethod
    def of(steps: npt.NDArray[np.uint8], width: int, height: int) -> Mask:
        """Return the mask of a whole photo of `width` x `height` px."""
        rows, columns = steps.shape
        return Mask(steps, Affine.resize(columns / width, rows / height))

    @cached_property
    def key(self) -> bytes:
        """Bytes that differ between masks with different effect."""
        return hashlib.blake2b(self.steps.tobytes()).digest() + self.to_mask.opencv.tobytes()

    @cached_property
    def sets(self) -> tuple[int, ...]:
        """The steps in use: one for a mask without soft edges."""
        is_soft = ((self.steps > 0) & (self.steps < STEPS)).any()
        return tuple(range(1, STEPS + 1)) if is_soft else (STEPS,)

    @cached_property
    def _maps(self) -> dict[int, npt.NDArray[np.float32]]:
        """Distance to the pixels of each set, px of the mask. Copies in other sizes share it."""
        return {}

    def _map(self, step: int) -> npt.NDArray[np.float32]:
        step = min(one for one in self.sets if one >= step)
        if step not in self._maps:
            free = np.asarray(self.steps < step, np.uint8)
            found = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
            # Without a pixel in the set, OpenCV's distances have no meaning.
            self._maps[step] = np.asarray(found) if not free.all() else found * 0 + _NOWHERE_PX
        return self._maps[step]

    def distance(self, x: Array, y: Array, step: int) -> Array:
        """Return a lower bound of the distance to a set, px of the photo; 0 on its pixels.

        `x`, `y`: of points, (N,), or the columns and rows of a grid. It changes by at most 1 px
        per px, so that the bounds for strokes hold.
        """
        x, y = np.broadcast_arrays(x, y)
        places = self.to_mask(np.stack([x, y], axis=-1)).reshape(-1, 2)
        if not len(places):
            return np.zeros(x.shape)
        picture = self._map(step)
        places = np.clip(places, 0.0, np.array(picture.shape[::-1]) - 1.0)
        low, high = places.min(axis=0).astype(int), places.max(axis=0).astype(int) + 2
        part = np.ascontiguousarray(picture[low[1] : high[1], low[0] : high[0]])
        wide = np.resize(places - low, (-(-len(places) // _WIDE), _WIDE, 2)).astype(np.float32)
        border = cv2.BORDER_REPLICATE
        found = cv2.remap(part, wide, None, cv2.INTER_LINEAR, borderMode=border)  # type: ignore[call-overload]
        scale = _STEEPEST * self.to_mask.scale
        return np.asarray(found.reshape(-1)[: len(places)].reshape(x.shape) / scale, np.float64)

    def slope(self, x: Array, y: Array, step: int) -> tuple[Array, Array]:
        """Return the slope of `distance` along x and along y, over two px of the mask."""
        h = 1.0 / self.to_mask.scale
        return (
            (self.distance(x + h, y, step) - self.distance(x - h, y, step)) / (2.0 * h),
            (self.distance(x, y + h, step) - self.distance(x, y - h, step)) / (2.0 * h),
        )

    @cached_property
    def outlines_px(self) -> list[Array]:
        """Closed lines (N, 2) around pixels that are at least half protected, px of the photo."""
        half = np.asarray(2 * self.steps >= STEPS, np.uint8)
        found, _ = cv2.findContours(half, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
        back = self.to_mask.inverse
        lines = (cv2.approxPolyDP(one, 0.6, closed=True).reshape(-1, 2) for one in found)
        return [back(np.vstack([line, line[:1]])) for line in lines]

    def mapped(self, transform: Affine) -> Mask:
        """Return the mask for a transformed photo (a similarity)."""
        found = dataclasses.replace(self, to_mask=self.to_mask.after(transform.inverse))
        found.__dict__.update({name: getattr(self, name) for name in ("_maps", "sets")})
        return found

    def erased(self, points_px: Array, radius_px: float) -> Mask | None:
        """Return the mask without the pixels under a line of a width; None if none remains."""
        # A dot needs two ends.
        line = np.rint(self.to_mask([*points_px, points_px[-1]])).astype(np.int32)
        steps = self.steps.copy()
        width = max(1, round(2.0 * radius_px * self.to_mask.scale))
        cv2.polylines(steps, [line[:, None]], False, 0, width)
        return Mask(steps, self.to_mask) if steps.any() else None

    def runs(self) -> str:
        """Return the run lengths in rows from the top: ``12a3e`` is 12 pixels of step 0, 3 of 4."""
        flat = self.steps.ravel()
        starts = np.append(0, np.flatnonzero(np.diff(flat)) + 1)
        lengths = np.diff(np.append(starts, flat.size))
        pairs = zip(lengths.tolist(), flat[starts].tolist(), strict=True)
        return "".join(f"{length}{'abcde'[step]}" for length, step in pairs)


def steps_of(pixels: Image) -> npt.NDArray[np.uint8]:
    """Return the steps of a picture, from the brightest of its colours, without alpha."""
    if pixels.ndim == 3:
        colours = pixels[..., : 3 if pixels.shape[2] > 2 else 1]
        pixels = colours.max(axis=2)
    white: Any = 1.0 if pixels.dtype == np.float32 else np.iinfo(pixels.dtype).max
    shares = np.clip(pixels / np.float32(white), 0.0, 1.0)
    return np.asarray(np.rint(STEPS * np.nan_to_num(shares)), np.uint8)


def read_mask(path: str | os.PathLike[str], width: int, height: int) -> Mask:
    """Read a mask for a photo of `width` x `height` px, upright.

    Raises UnreadablePhoto, or ValueError if the size differs or the mask is too detailed.
    """
    path = Path(path)
    pixels = read(path).pixels
    if pixels.shape[:2] != (height, width):
        raise BadValue(
            "the mask {path} has {columns} x {rows} px, the photo {width} x {height} px; "
            "export the mask in the size of the photo",
            path=path, columns=pixels.shape[1], rows=pixels.shape[0], width=width, height=height,
        )  # fmt: skip
    steps = steps_of(pixels)
    if np.count_nonzero(np.diff(steps.ravel())) >= MOST_RUNS:
        raise BadValue("the mask {path} is too detailed; blur it a little", path=path)
    return Mask.of(steps, width, height)
