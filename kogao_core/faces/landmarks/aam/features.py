"""What the model sees of a picture: the directions of its edges, whatever the light."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]

DIRECTIONS: Final = 8
_SMOOTH_PX: Final = 1.0
_POOL_PX: Final = 1.5
_CONTRAST_PX: Final = 4.0


def directions(grey: npt.NDArray[np.uint8]) -> Floats:
    """Return edge strength by direction, normalised by the contrast round about.

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


_BINS: Final = np.arange(DIRECTIONS, dtype=np.float32)


def sampled(features: Floats, places: Floats) -> Floats:
    """Return features of shape (P, 8) between pixels at places (P, 2); held at the border."""
    rows, columns, depth = features.shape
    x = np.clip(places[:, 0], 0.0, columns - 1.001)
    y = np.clip(places[:, 1], 0.0, rows - 1.001)
    left, top = x.astype(np.intp), y.astype(np.intp)
    u, v = (x - left)[:, None], (y - top)[:, None]
    flat, at = features.reshape(-1, depth), top * columns + left
    upper = flat[at] * (1.0 - u) + flat[at + 1] * u
    lower = flat[at + columns] * (1.0 - u) + flat[at + columns + 1] * u
    return np.asarray(upper * (1.0 - v) + lower * v, np.float32)
