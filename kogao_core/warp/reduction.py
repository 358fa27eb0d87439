"""A smaller picture of the result in one resampling: warped and reduced at once.

Each pixel is the mean of places spread evenly over it, as many as there are px of the photo, each
read where the field says. Nothing is rounded to pixels in between.
"""

from __future__ import annotations

from itertools import product
from math import ceil
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.threads import default_threads, share_out
from kogao_core.warp.field import Field

_TILE_PX: Final = 512  # of the photo, about: a tile and its maps fit into the processor's cache
_KERNEL_REACH_PX: Final = 8


def size_of(image: Box, longest_px: int) -> tuple[int, int]:
    """Return width and height of a picture reduced to a longer side; its own if that is enough."""
    share = min(1.0, longest_px / max(image.width, image.height)) if longest_px else 1.0
    return max(1, round(image.width * share)), max(1, round(image.height * share))


def reduced(
    source: Image, field: Field, moving: Box, size: tuple[int, int], flag: int, threads: int | None
) -> Image:
    """Return the warped photo as a picture of a size (width, height).

    `moving` is where the field moves anything; `flag` is OpenCV's interpolation.
    """
    image, (width, height) = Box.of(source), size
    result = np.empty((height, width, *source.shape[2:]), source.dtype)
    fine = ceil(max(image.width / width, image.height / height))
    step = max(1, _TILE_PX // fine)
    tiles = [
        Box(left, top, min(left + step, width), min(top + step, height))
        for top, left in product(range(0, height, step), range(0, width, step))
    ]

    def draw(tile: Box) -> None:
        xs = _places(tile.left, tile.right, fine, image.width / width)
        ys = _places(tile.top, tile.bottom, fine, image.height / height)
        reach = Box(int(xs[0]), int(ys[0]), int(xs[-1]) + 1, int(ys[-1]) + 1)
        there = np.array(np.broadcast_arrays(xs, ys[:, None]))
        if reach.clipped(moving).area:
            there += field.on_grid(xs, ys)
        low = np.clip(there.min(axis=(1, 2)) - _KERNEL_REACH_PX, 0, None).astype(int)
        high = (there.max(axis=(1, 2)) + _KERNEL_REACH_PX + 1).astype(int)
        # At the photo's edge at least one pixel is left to be repeated.
        low = np.minimum(low, (image.width - 1, image.height - 1))
        seen = source[low[1] : max(high[1], 1), low[0] : max(high[0], 1)].astype(np.float32)
        at = (there - low[:, None, None]).astype(np.float32)
        read = cv2.remap(seen, at[0], at[1], flag, borderMode=cv2.BORDER_REPLICATE)
        mean = cv2.resize(read, (tile.width, tile.height), interpolation=cv2.INTER_AREA)
        if source.dtype != np.float32:
            mean = np.clip(np.rint(mean), 0, np.iinfo(source.dtype).max)
        result[tile.slices] = mean.reshape(result[tile.slices].shape)

    share_out(tiles, lambda: draw, threads or default_threads())
    return result


def _places(first: int, end: int, fine: int, scale: float) -> Array:
    """Return where the parts of some pixels lie in the photo, px; their centres."""
    parts = np.arange(first * fine, end * fine) + 0.5
    return np.asarray(parts / fine * scale - 0.5)
