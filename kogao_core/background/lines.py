"""Door frames and shelves near a face: how far does the warp bend straight lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.background.people import PersonMask
from kogao_core.base.geometry import Affine, Array, Image
from kogao_core.faces.landmarks.pixels import Pyramid
from kogao_core.warp.field import Field, shown_at

HoldingName = Literal["held", "gave way", "let go", ""]
# Half a pixel is where a bend in a straight edge begins to be seen.
SEEN_PX: Final = 0.5
_SHORTEST: Final = 0.04  # of the photo's longer side; shorter lines are texture
_SAMPLES: Final = 64
_LEAST_PX: Final = 10  # of a line the detector is asked for; pictures of 5 rows break it
_DETECTOR_PX: Final = 1600  # longer side of what the detector sees: finer is noise, and slow
_ASIDE_PX: Final = 3  # an edge is sought so far on both sides of its line, px of what it sees
_STEPS: Final = 4  # a px, there
_SMOOTH: Final = 7  # samples along the line over which noise is averaged away
_MEAN: Final = np.full((1, 3), 1.0 / 3.0)  # of red, green and blue
_PLAIN: Final = np.uint8(128)


@dataclass(frozen=True, slots=True)
class BentLine:
    """A straight line of the photo."""

    # Where it runs in the photo (x, y).
    start_px: tuple[float, float]
    end_px: tuple[float, float]
    bend_px: float  # how far the warp makes a straight line there depart from straight, px
    # How far its own edge, as it is found in the photo, departs from straight before and after the
    # warp, px.
    before_px: float | None = None
    after_px: float | None = None
    unheld_px: float = 0.0  # `bend_px` if no line were held
    # Whether it was held straight; was to be, but bends by `SEEN_PX` or more for the face's sake;
    # or was let go by the user.
    holding: HoldingName = ""


def straight_lines(photo: Image | Pyramid, people: PersonMask | None = None) -> Array:
    """Find straight lines of the photo. Result (N, 2, 2): ends (x, y) of each line, px."""
    pyramid = Pyramid.of(photo)
    return _lines(pyramid, people, _SHARP)


def rough_lines(photo: Image | Pyramid, sharp: Array, people: PersonMask | None = None) -> Array:
    """Return lines (N, 2, 2), px, that a person would see bend and `straight_lines` doesn't find.

    Mortar, fences, blinds and edges of little contrast: noise decides which of them are found, so
    they are told of and not held. `sharp` are those that it finds.
    """
    pyramid = Pyramid.of(photo)
    rough = _lines(pyramid, people, _ROUGH)
    return rough[~_covered(rough, sharp, _SAME * max(pyramid.image.shape[:2]))]


@dataclass(frozen=True, slots=True)
class _Look:
    """How a photo is looked at for lines: size and blur, thresholds of edges, a line's width."""

    longest_px: int
    blur_px: float
    weak: float
    strong: float
    width_px: float


# What OpenCV's detector asks for by itself; and what sees mortar, fences and blinds as lines, and
# edges of little contrast.
_SHARP: Final = _Look(_DETECTOR_PX, 0.0, 50.0, 50.0, 1.414)
_ROUGH: Final = _Look(_DETECTOR_PX // 2, 1.5, 15.0, 30.0, 2.0)
_SAME: Final = 0.008  # of the longer side: so near to another a line is the same one
_PARALLEL: Final = 0.985  # cosine of 10 degrees
_COVERED: Final = 0.9  # of a rough line, then it isn't needed


def _lines(photo: Pyramid, people: PersonMask | None, look: _Look) -> Array:
    """Return the lines that one look finds, (N, 2, 2), px of the photo."""
    small, halved = photo.at_most(look.longest_px)
    if min(small.shape[:2]) < _LEAST_PX:
        return np.zeros((0, 2, 2))
    shortest = max(_LEAST_PX, int(shortest_px(photo.image) / 2**halved))
    detector = cv2.ximgproc.createFastLineDetector(
        shortest, look.width_px, look.weak, look.strong, do_merge=True
    )
    grey, to_small = cv2.transform(small, _MEAN), Affine.resize(0.5**halved, 0.5**halved)
    if look.blur_px:
        grey = cv2.GaussianBlur(grey, (0, 0), look.blur_px)
    if people is not None:
        free = people.mapped(to_small).free(*grey.shape[::-1])
        # The edge of what is painted over lies beyond a look's, where no line counts.
        shown = cv2.dilate(free, np.ones((3, 3), np.uint8))
        grey = cv2.copyTo(grey, shown, np.full_like(grey, _PLAIN))
    found: Any = detector.detect(grey)  # None when there is no line
    return np.zeros((0, 2, 2)) if found is None else to_small.inverse(found.reshape(-1, 2, 2))


def _covered(lines: Array, others: Array, reach_px: float) -> npt.NDArray[np.bool_]:
    """Return which of some lines lie on others, nearly all along."""
    t = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    along = others[:, 1] - others[:, 0]
    lengths = np.hypot(along[:, 0], along[:, 1])
    units = along / np.maximum(lengths, 1e-12)[:, None]
    found = np.zeros(len(lines), bool)
    for number, (start, end) in enumerate(lines):
        way = (end - start) / max(1e-12, float(np.hypot(*(end - start))))
        offsets = (start + t * (end - start))[:, None] - others[:, 0]
        forth = (offsets * units).sum(axis=2)
        aside = np.abs(offsets[..., 0] * units[:, 1] - offsets[..., 1] * units[:, 0])
        on = (forth > -reach_px) & (forth < lengths + reach_px) & (aside < reach_px)
        on &= np.abs(units @ way) > _PARALLEL
        found[number] = on.any(axis=1).mean() >= _COVERED
    return found


def shortest_px(photo: Image) -> float:
    """Return how long a line must be to count; what is shorter is texture, px of the photo."""
    return float(_SHORTEST * max(photo.shape[:2]))


def off_faces(lines: Array, outlines: Sequence[Array]) -> Array:
    """Drop lines of shape (N, 2, 2) whose middle lies on a face: brows and lips are meant to move.

    Result (K, 2, 2): the lines that are left.
    """
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
    shown = _shown(field, along)
    free = shown if unheld is None or unheld is field else _shown(unheld, along)
    before: list[float | None] = [None] * len(lines)
    after = before
    if photo is not None:
        edges = _edges(photo, along)
        before = [_departure(edge) for edge in edges]
        after = [_departure(edge) for edge in _shown(field, edges)]
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
    """Return where the edge itself runs beside samples of lines, shape (N, S, 2).

    At each sample it is where the light changes most across the line, to a part of a step.
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
    if light.dtype == np.float32:  # may be any numbers, and none; seen as `rgb8` shows them
        light = np.clip(np.nan_to_num(light), 0.0, 1.0)
    light = light.reshape(*shape, -1)[..., :3].mean(axis=-1, dtype=np.float32)
    change = np.abs(light[:, :, 2:] - light[:, :, :-2])
    change = np.stack([cv2.blur(one, (_STEPS, _SMOOTH)) for one in change])
    return along + _peaks(change, asides[1:-1])[..., None] * across


def _peaks(change: Array, asides: Array) -> Array:
    """Return where rows of changes are largest, by the parabola through the three about it."""
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
