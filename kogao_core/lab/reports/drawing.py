"""A picture with dots, lines and words painted on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array, Image

_HALO: Final = "#ffffff"
_HALO_PX: Final = 1.2
_FRACTION_BITS: Final = 4  # OpenCV draws at sixteenths of a px
_FONT: Final = cv2.FONT_HERSHEY_SIMPLEX
_FONT_PX: Final = 22.0  # height of capitals at scale 1


@dataclass(frozen=True, slots=True, eq=False)
class Dots:
    """Circles at points (N, 2) with a light halo; hollow ones are rings."""

    points: Array
    radius_px: float
    colour: str
    filled: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Strokes:
    """Straight lines between pairs of points (N, 2, 2)."""

    segments: Array
    width_px: float
    colour: str


@dataclass(frozen=True, slots=True)
class Word:
    """A short ASCII text; `at` is the left end of the baseline."""

    at: tuple[float, float]
    text: str
    height_px: float
    colour: str


Mark = Dots | Strokes | Word


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """A picture and shapes painted over the picture, in order."""

    name: str  # part of the file name
    pixels: Image  # (H, W, 3): RGB, uint8
    marks: tuple[Mark, ...] = ()  # in px of the picture

    def painted(self) -> Image:
        """Return the pixels of the picture with all shapes."""
        canvas = np.ascontiguousarray(self.pixels).copy()
        for mark in self.marks:
            _paint(canvas, mark)
        return canvas


def _paint(canvas: Image, mark: Mark) -> None:
    colour = _rgb(mark.colour)
    if isinstance(mark, Strokes):
        for a, b in mark.segments:
            width = max(1, round(mark.width_px))
            cv2.line(canvas, _fixed(a), _fixed(b), colour, width, cv2.LINE_AA, _FRACTION_BITS)
    elif isinstance(mark, Word):
        x, y = round(mark.at[0]), round(mark.at[1])
        scale = mark.height_px / _FONT_PX
        for shade, width in ((_rgb(_HALO), 5), (colour, 2)):
            cv2.putText(canvas, mark.text, (x, y), _FONT, scale, shade, width, cv2.LINE_AA)
    else:
        for point in mark.points:
            _paint_dot(canvas, point, mark)


def _paint_dot(canvas: Image, point: Array, mark: Dots) -> None:
    at, colour, halo = _fixed(point), _rgb(mark.colour), _rgb(_HALO)
    radius = round(mark.radius_px * 2**_FRACTION_BITS)
    more = round(_HALO_PX * 2**_FRACTION_BITS)
    if mark.filled:
        cv2.circle(canvas, at, radius + more, halo, -1, cv2.LINE_AA, _FRACTION_BITS)
        cv2.circle(canvas, at, radius, colour, -1, cv2.LINE_AA, _FRACTION_BITS)
    else:
        cv2.circle(canvas, at, radius, colour, 2, cv2.LINE_AA, _FRACTION_BITS)


def _fixed(point: Array) -> tuple[int, int]:
    x, y = np.round(point * 2**_FRACTION_BITS).astype(int).tolist()
    return x, y


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red, green, blue
