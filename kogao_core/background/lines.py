"""Find straight lines of a photo, and measure how far a warp turns each.

A person cuts a line in two. Each piece may stay straight and still lean, so that both make a roof.
Pieces on one line are therefore joined across a person before their movement is compared.
"""

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
from kogao_core.field.field import Field, shown_at

HoldingName = Literal["held", "gave way", "let go", ""]
SEEN_DEGREES: Final = 3.0  # an eye begins to see that a line beside a head leans
# Least root of the sum of squares of the clear lengths of turned lines that an eye sees, in the
# photo's longer side. Shorter lines are leaves, letters, curls and cloth.
SEEN_LENGTH: Final = 0.16
_SHORTEST: Final = 0.04  # in the photo's longer side; shorter lines are texture
_MEASURED: Final = 0.08  # in the longer side; shorter parts turn unseen
_ALIGNED: Final = np.sin(np.radians(2.0))  # pieces of one line differ by a smaller angle
_ASIDE: Final = 0.004  # and lie within this distance of one line, in the longer side
_ASIDE_PX: Final = 1.5  # at least
_SAMPLES: Final = 48  # places along a piece whose movement is measured
_LEAST_PX: Final = 10  # shortest line of the detector, which fails on images of 5 rows
_DETECTOR_PX: Final = 1600  # longer side of the detector's image; larger: more noise, slower
# Distances from a line at which its sides are compared, px of a longer side of 400.
_BESIDE: Final = np.array([1.5, 2.5, 3.5])
_FAINT: Final = 2.0 / 255.0  # a line of this contrast is half clear
_MEAN: Final = np.full((1, 3), 1.0 / 3.0)  # weights of red, green and blue
_PLAIN: Final = np.uint8(128)  # grey level painted over people


@dataclass(frozen=True, slots=True)
class BackgroundLine:
    """A straight piece of a line of the photo, and its movement."""

    # Ends (x, y) in the photo.
    start_px: tuple[float, float]
    end_px: tuple[float, float]
    number: int  # pieces of one line, left and right of a person, have one number
    length: float  # in the photo's longer side
    # 0 to 1: |mean d| / (mean |d| + 2/255), d: brightness on one side less that on the other. Near
    # 0 for lines in texture, whose brighter side changes.
    clearness: float
    # Largest angle between a part of the piece after and before the warp. Parts are chords of 8 %
    # of the photo's longer side, so that a bow turns at its ends.
    turn_degrees: float
    # Largest less least movement across the line, over all its pieces, thousandths of the width of
    # the face: the step at a person.
    rise_permille: float
    unheld_turn_degrees: float = 0.0  # `turn_degrees` of a warp that holds no line
    # "held": turns by less than `SEEN_DEGREES`. "gave way": turns by more. "let go": released by
    # the user. Empty: the recipe holds no line.
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


def long_enough(lines: Array, photo: Image) -> Array:
    """Return the lines (N, 2, 2) of at least 8 % of the photo's longer side, (K, 2, 2)."""
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    return np.asarray(lines[lengths >= _MEASURED * max(photo.shape[:2])])


def off_faces(lines: Array, outlines: Sequence[Array]) -> Array:
    """Return the lines (N, 2, 2) whose middle lies outside all faces, (K, 2, 2)."""
    hulls = [cv2.convexHull(outline.astype(np.float32)) for outline in outlines]
    apart = [
        all(cv2.pointPolygonTest(hull, middle, measureDist=False) < 0 for hull in hulls)
        for middle in lines.mean(axis=1).tolist()
    ]
    return np.asarray(lines[np.array(apart, bool)])


def turns(
    field: Field, lines: Array, photo: Image, face_px: float, unheld: Field | None = None
) -> list[BackgroundLine]:
    """Measure how far the warp turns lines (N, 2, 2), px. Result: the most turned first.

    `photo` tells how clear a line is; `face_px`: width of the face, the unit of the rise.
    """
    side = max(photo.shape[:2])
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) / side
    if len(lines) == 0:
        return []
    numbers = joined(lines, max(_ASIDE_PX, _ASIDE * side))
    along = lines[:, :1] + np.linspace(0.0, 1.0, _SAMPLES)[:, None] * np.diff(lines, axis=1)
    shown = _shown(field, along)
    free = shown if unheld is None or unheld is field else _shown(unheld, along)
    rises = np.zeros(len(lines))
    for number in range(int(numbers.max()) + 1):
        on = numbers == number
        u, v = np.diff(lines[on][lengths[on].argmax()], axis=0)[0]
        moved = (shown - along)[on] @ np.array([-v, u]) / np.hypot(u, v)
        rises[on] = 1000.0 / face_px * np.ptp(moved)
    measured = zip(
        lines.tolist(), numbers.tolist(), lengths.tolist(), _clearness(photo, along).tolist(),
        _turned(along, shown, lengths), rises.tolist(), _turned(along, free, lengths), strict=True,
    )  # fmt: skip
    found = [BackgroundLine(tuple(start), tuple(end), *more) for (start, end), *more in measured]
    return sorted(found, key=lambda line: -line.turn_degrees)


def joined(lines: Array, aside_px: float) -> npt.NDArray[np.int64]:
    """Return a number for each piece (N, 2, 2); pieces of one straight line have one number.

    From the longest piece to the shortest, a piece joins a line that differs in direction by less
    than 2 degrees, if all ends lie within `aside_px` of one straight line; of several lines, that
    where the ends lie nearest.
    """
    chords = lines[:, 1] - lines[:, 0]
    lengths = np.hypot(*chords.T)
    (x, y), numbers = (chords / lengths[:, None]).T, np.full(len(lines), -1)
    for piece in np.argsort(-lengths, kind="stable"):
        nearest, numbers[piece] = aside_px, numbers.max() + 1
        for number in range(numbers[piece]):
            on = np.flatnonzero(numbers == number)
            first = on[lengths[on].argmax()]
            if abs(x[first] * y[piece] - y[first] * x[piece]) < _ALIGNED:
                off = _off_line(lines[[*on, piece]].reshape(-1, 2))
                if off <= nearest:
                    nearest, numbers[piece] = off, number
    return numbers


def _shown(field: Field, points: Array) -> Array:
    return shown_at(field, points.reshape(-1, 2)).reshape(points.shape)


def _off_line(points: Array) -> float:
    """Return the distance of the farthest point from the least-squares line through all (N, 2)."""
    offsets = points - points.mean(axis=0)
    return float(np.abs(offsets @ np.linalg.svd(offsets, full_matrices=False)[2][1]).max())


def _turned(before: Array, after: Array, lengths: Array) -> list[float]:
    """Return `BackgroundLine.turn_degrees` of pieces by samples along them (N, S, 2)."""
    steps = np.ceil((_SAMPLES - 1) * np.minimum(1.0, _MEASURED / lengths)).astype(int)
    found = []
    for was, now, step in zip(before, after, steps, strict=True):
        (x, y), (u, v) = (was[step:] - was[:-step]).T, (now[step:] - now[:-step]).T
        found.append(float(np.degrees(np.abs(np.arctan2(x * v - y * u, x * u + y * v)).max())))
    return found


def _clearness(photo: Image, along: Array) -> Array:
    """Return `BackgroundLine.clearness` of lines by samples along them (N, S, 2)."""
    chord = along[:, -1] - along[:, 0]
    across = np.stack([-chord[:, 1], chord[:, 0]], axis=-1)
    across /= np.linalg.norm(chord, axis=1, keepdims=True)
    beside = max(1.0, max(photo.shape[:2]) / 400.0) * np.concatenate([_BESIDE, -_BESIDE])
    places = along[:, :, None] + beside[:, None] * across[:, None, None]
    x, y = np.moveaxis(places.reshape(len(along), -1, 2).astype(np.float32), -1, 0)
    light = cv2.remap(photo, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    most = 1.0 if light.dtype == np.float32 else float(np.iinfo(light.dtype.name).max)
    # Photos of floats may hold NaN and values outside 0 to 1.
    light = np.clip(np.nan_to_num(light) / most, 0.0, 1.0)
    light = light.reshape(*places.shape[:2], 2, len(_BESIDE), -1)[..., :3].mean(axis=(-1, -2))
    change = light[..., 0] - light[..., 1]
    return np.asarray(np.abs(change.mean(axis=1)) / (np.abs(change).mean(axis=1) + _FAINT))
