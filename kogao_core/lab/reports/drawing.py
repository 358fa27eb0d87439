"""A picture with dots, lines and words, saved as PNG or SVG."""

from __future__ import annotations

import html
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from kogao_core.base.display import data_uri, png
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

    name: str  # title, and part of the file name
    pixels: Image  # (H, W, 3): RGB, uint8
    marks: tuple[Mark, ...] = ()  # in px of the picture
    exact: bool = False  # SVG contains the picture as PNG (lossless) instead of JPEG

    def painted(self) -> Image:
        """Return the pixels of the picture with all shapes."""
        canvas = np.ascontiguousarray(self.pixels).copy()
        for mark in self.marks:
            _paint(canvas, mark)
        return canvas

    def png(self) -> bytes:
        """Return the drawing as a PNG file."""
        return png(self.painted())

    def svg(self) -> bytes:
        """Return the drawing as an SVG file without external references."""
        height, width = self.pixels.shape[:2]
        source = data_uri(self.pixels, exact=self.exact)
        # Pixel centres are at integers here, pixel corners in SVG: shift by half a pixel.
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'viewBox="-0.5 -0.5 {width} {height}">',
            f"<title>{html.escape(self.name)}</title>",
            f'<image x="-0.5" y="-0.5" width="{width}" height="{height}" href="{source}"/>',
            *(_tag(mark) for mark in self.marks),
            "</svg>",
        ]
        return "\n".join(parts).encode() + b"\n"


def _tag(mark: Mark) -> str:
    if isinstance(mark, Strokes):
        path = "".join(
            f"M{a[0]:.2f} {a[1]:.2f}L{b[0]:.2f} {b[1]:.2f}" for a, b in mark.segments.tolist()
        )
        return f'<path d="{path}" stroke="{mark.colour}" stroke-width="{mark.width_px:g}"/>'
    if isinstance(mark, Word):
        x, y = mark.at
        return (
            f'<text x="{x:.2f}" y="{y:.2f}" fill="{mark.colour}" stroke="{_HALO}" '
            f'stroke-width="3" paint-order="stroke" font-size="{1.4 * mark.height_px:.1f}" '
            f'font-family="sans-serif">{html.escape(mark.text)}</text>'
        )
    inside = mark.colour if mark.filled else "none"
    edge = _HALO if mark.filled else mark.colour
    circles = "".join(
        f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{mark.radius_px:g}"/>'
        for x, y in mark.points.tolist()
    )
    return f'<g fill="{inside}" stroke="{edge}" stroke-width="{_HALO_PX}">{circles}</g>'


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
