"""Find straight lines of a photo, and measure how far a warp bends each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import cv2
import numpy as np

from kogao_core.background.people import PersonMask
from kogao_core.base.geometry import Affine, Array, Image
from kogao_core.faces.landmarks.pixels import Pyramid
from kogao_core.field.field import Field, shown_at

HoldingName = Literal["held", "gave way", "let go", ""]
# Half a pixel is where a bend in a straight edge begins to be seen.
SEEN_PX: Final = 0.5
_SHORTEST: Final = 0.04  # in the photo's longer side; shorter lines are texture
_SAMPLES: Final = 64  # places along a line where its bend is measured
_LEAST_PX: Final = 10  # shortest line of the detector, which fails on images of 5 rows
_DETECTOR_PX: Final = 1600  # longer side of the detector's image; larger: more noise, slower
_ASIDE_PX: Final = 3  # an edge is searched this far on both sides of a line, detector px
_STEPS: Final = 4  # samples per px of that search
_SMOOTH: Final = 7  # length of the moving average along a line, samples
_MEAN: Final = np.full((1, 3), 1.0 / 3.0)  # weights of red, green and blue
_PLAIN: Final = np.uint8(128)  # grey level painted over people


@dataclass(frozen=True, slots=True)
class BentLine:
    """A straight line of the photo."""

    # Ends (x, y) in the photo.
    start_px: tuple[float, float]
    end_px: tuple[float, float]
    bend_px: float  # largest distance of the warped line from a straight line, px
    # The same of the edge that the photo has beside the line, before and after the warp, px.
    before_px: float | None = None
    after_px: float | None = None
    unheld_px: float = 0.0  # `bend_px` of a warp that holds no line
    # "held": bends by less than `SEEN_PX`. "gave way": bends by more. "let go": released by the
    # user. Empty: the recipe holds no line.
    holding: HoldingName = ""


def straight_lines(photo: Image | Pyramid, people: PersonMask | None = None) -> Array:
    """Find straight lines of a photo outside people.

    Result (N, 2, 2): ends (x, y) of each line, px.
    """
    pyramid = Pyramid.of(photo)
    small, halved = pyramid.at_most(_DETECTOR_PX)
    if min(small.shape[:2]) < _LEAST_PX:
        return np.zeros((0, 2, 2))
    shortest = max(_LEAST_PX, int(shortest_px(pyramid.image) / 2**halved))
    detector = cv2.ximgproc.createFastLineDetector(shortest, do_merge=True)
    grey, to_small = cv2.transform(small, _MEAN), Affine.resize(0.5**halved, 0.5**halved)
    if people is not None:
        free = people.mapped(to_small).free(*grey.shape[::-1])
        # The edge of the painted area must lie beyond the edge of the mask, where no line counts.
        shown = cv2.dilate(free, np.ones((3, 3), np.uint8))
        grey = cv2.copyTo(grey, shown, np.full_like(grey, _PLAIN))
    found: Any = detector.detect(grey)  # None when there is no line
    return np.zeros((0, 2, 2)) if found is None else to_small.inverse(found.reshape(-1, 2, 2))


def shortest_px(photo: Image) -> float:
    """Return the length of the shortest line that counts, px of the photo."""
    return float(_SHORTEST * max(photo.shape[:2]))


def off_faces(lines: Array, outlines: Sequence[Array]) -> Array:
    """Return the lines (N, 2, 2) whose middle lies outside all faces, (K, 2, 2)."""
    hulls = [cv2.convexHull(outline.astype(np.float32)) for outline in outlines]
    apart = [
        all(cv2.pointPolygonTest(hull, middle, measureDist=False) < 0 for hull in hulls)
        for middle in lines.mean(axis=1).tolist()
    ]
    return np.asarray(lines[np.array(apart, bool)])


def bends(
    field: Field, lines: Array, photo: Image | None = None, unheld: Field | None = None
) -> list[BentLine]:
    """Measure how far the warp bends lines. `lines` (N, 2, 2) px. Result: the most bent first."""
    if len(lines) == 0:
        return []
    t = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    along = lines[:, :1] + t * (lines[:, 1:] - lines[:, :1])
    edges = along[:0] if photo is None else _edges(photo, along)
    shown, moved = np.split(_shown(field, np.concatenate([along, edges])), [len(along)])
    free = shown if unheld is None or unheld is field else _shown(unheld, along)
    none: list[float | None] = [None] * len(lines)
    before, after = ([_departure(edge) for edge in some] or none for some in (edges, moved))
    measured = [
        BentLine(
            (float(start[0]), float(start[1])), (float(end[0]), float(end[1])), _departure(one),
            was, now, _departure(other),
        )
        for (start, end), one, was, now, other in zip(
            lines, shown, before, after, free, strict=True
        )
    ]  # fmt: skip
    return sorted(measured, key=lambda line: -line.bend_px)


def _shown(field: Field, points: Array) -> Array:
    return shown_at(field, points.reshape(-1, 2)).reshape(points.shape)


def _edges(photo: Image, along: Array) -> Array:
    """Return the positions of the edges beside samples of lines, shape (N, S, 2).

    An edge lies at the largest change of brightness across the line, with subpixel accuracy.
    """
    unit = max(1.0, max(photo.shape[:2]) / _DETECTOR_PX)
    chord = along[:, -1] - along[:, 0]
    chord /= np.linalg.norm(chord, axis=1, keepdims=True)
    across = np.stack([-chord[:, 1], chord[:, 0]], axis=-1)[:, None]
    asides = unit * np.arange(-_ASIDE_PX, _ASIDE_PX + 1.0 / _STEPS, 1.0 / _STEPS)
    places = (along[:, :, None] + asides[:, None] * across[:, None]).astype(np.float32)
    shape = places.shape[:3]
    x, y = (places[..., axis].reshape(len(along), -1) for axis in (0, 1))
    light = cv2.remap(photo, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    if light.dtype == np.float32:  # may hold NaN and values outside 0 to 1
        light = np.clip(np.nan_to_num(light), 0.0, 1.0)
    light = light.reshape(*shape, -1)[..., :3].mean(axis=-1, dtype=np.float32)
    change = np.abs(light[:, :, 2:] - light[:, :, :-2])
    change = np.stack([cv2.blur(one, (_STEPS, _SMOOTH)) for one in change])
    return along + _peaks(change, asides[1:-1])[..., None] * across


def _peaks(change: Array, asides: Array) -> Array:
    """Return the positions of the maxima of rows, by a parabola through three samples."""
    best = np.clip(change.argmax(axis=-1), 1, change.shape[-1] - 2)[..., None]
    low, top, high = (np.take_along_axis(change, best + k, -1)[..., 0] for k in (-1, 0, 1))
    curve = np.minimum(low - 2.0 * top + high, -1e-6)
    shift = np.clip(0.5 * (low - high) / curve, -0.5, 0.5)
    return np.asarray(asides[best[..., 0]] + shift * (asides[1] - asides[0]))


def _departure(points: Array) -> float:
    """Return the distance of the farthest point from the least-squares line through them."""
    offsets = points - points.mean(axis=0)
    _, _, directions = np.linalg.svd(offsets, full_matrices=False)
    return float(np.abs(offsets @ directions[1]).max())
