"""A picture and its halvings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Final

import cv2
import numpy as np

from kogao_core.base.display import Rgb8
from kogao_core.base.geometry import Affine, Box

# Converts each first picture to the screen's colours and writes the result to the second.
Show = Callable[[Sequence[tuple[Rgb8, Rgb8]]], None]
_SMALLEST_PX: Final = 256
# A level up to a third too small still looks sharp and has a fraction of the pixels.
_ENOUGH: Final = 0.75
_COLOURS: Final = 3
_LEAST_ALPHA: Final = 1e-6


class PicturePyramid:
    """Levels of a picture; a pixel of level k is the mean of 2^k x 2^k pixels.

    `levels` have the photo's own colours, for processing; `shown` has the screen's colours.
    """

    def __init__(self, pixels: Rgb8, show: Show | None = None) -> None:
        self.levels = [pixels]
        self.show = show
        while min(self.levels[-1].shape[:2]) >= 2 * _SMALLEST_PX:
            height, width = (side // 2 for side in self.levels[-1].shape[:2])
            self.levels.append(np.empty((height, width, pixels.shape[2]), np.uint8))
        self.shown = self.levels if show is None else [np.empty_like(one) for one in self.levels]
        self.refresh([Box.of(pixels)])

    def part(self, level: int, box: Box) -> PicturePyramid:
        """Return part of a level as a pyramid of one level; no pixels are copied."""
        levels = [self.levels[level][box.slices]]
        return self._with(levels, levels if self.show is None else [self.shown[level][box.slices]])

    def whole_of(self, level: int, part: Box) -> Box:
        """Return the rectangle of a level, in px of a part of the level."""
        all_of_it = Box.of(self.levels[level])
        return Box(-part.left, -part.top, all_of_it.right - part.left, all_of_it.bottom - part.top)

    def over(self, pixels: Rgb8) -> PicturePyramid:
        """Return a pyramid over a buffer with a copy of level 0."""
        levels = [pixels, *(one.copy() for one in self.levels[1:])]
        return self._with(levels, levels if self.show is None else [it.copy() for it in self.shown])

    def _with(self, levels: list[Rgb8], shown: list[Rgb8]) -> PicturePyramid:
        other = PicturePyramid.__new__(PicturePyramid)
        other.levels, other.show, other.shown = levels, self.show, shown
        return other

    def refresh(self, boxes: Iterable[Box]) -> None:
        """Recompute the coarser levels and screen colours under `boxes` of level 0."""
        changed = []
        for box in boxes:
            part = box
            changed.append((0, box))
            for level, (finer, coarser) in enumerate(
                zip(self.levels, self.levels[1:], strict=False), 1
            ):
                part = _halved(part).clipped(Box.of(coarser))
                if not part.area:
                    break
                changed.append((level, part))
                rows, columns = part.slices
                source = finer[2 * part.top : 2 * part.bottom, 2 * part.left : 2 * part.right]
                _reduce(source, coarser[rows, columns])
        if self.show is not None:
            self.show(
                [(self.levels[at][box.slices], self.shown[at][box.slices]) for at, box in changed]
            )

    def level_for(self, zoom: float) -> int:
        """Return the coarsest level that is sharp at `zoom` screen px per picture px."""
        level = 0
        while level + 1 < len(self.levels) and 0.5 ** (level + 1) >= _ENOUGH * zoom:
            level += 1
        return level


def to_photo(level: int, corner: tuple[int, int] = (0, 0)) -> Affine:
    """Return the map from px of a level, relative to `corner`, to px of the photo."""
    scale = float(2**level)
    return Affine.resize(scale, scale).after(Affine(np.eye(2), np.array(corner, np.float64)))


def _reduce(source: Rgb8, target: Rgb8) -> None:
    """Downscale to half the size; transparent pixels have little weight in the colours."""
    size = target.shape[1::-1]
    if source.shape[2] == _COLOURS:
        cv2.resize(source, size, dst=target, interpolation=cv2.INTER_AREA)
        return
    alpha = source[..., _COLOURS:].astype(np.float32)
    sums = cv2.resize(source[..., :_COLOURS] * alpha, size, interpolation=cv2.INTER_AREA)
    mean = cv2.resize(alpha, size, interpolation=cv2.INTER_AREA)[..., None]
    plain = cv2.resize(source, size, interpolation=cv2.INTER_AREA)
    seen = np.rint(sums.reshape(plain[..., :_COLOURS].shape) / np.maximum(mean, _LEAST_ALPHA))
    target[...] = plain
    np.copyto(target[..., :_COLOURS], seen.astype(np.uint8), where=mean > 0.0)


def _halved(box: Box) -> Box:
    return Box(box.left // 2, box.top // 2, -(-box.right // 2), -(-box.bottom // 2))
