"""The head as one body: the point about which it shrinks, and the Amount that the photo allows.

All of the head shrinks by the same share about one fixed point, the pivot. The pivot lies on the
head's own axis. A free place above and below the head decides its height: with space above, the
pivot lies at the eyes; with none, at the crown, and the chin comes up. Lengths are in units of
`HeadFrame.height_px`, the distance from the eyes to the chin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across

# The distance from the eyes to the chin, in distances from the eyes to the mouth. This measure of
# size depends on no landmark of the outline: a dragged landmark has an effect near it alone.
_HEIGHT: Final = 1.9
# The top of the hair lies this far above the eyes. Larger values lower the pivot and the chin less.
_CROWN: Final = 1.05
# Space above the hair counts up to about this much. Smaller values move the pivot up to the crown.
_ABOVE: Final = 0.6
# It counts so many times: a stretched wall is seen less than a stretched neck. Larger values lower
# the pivot.
_WALL: Final = 1.4
# The pivot comes down from the crown by less than this times the free space, so that a head doesn't
# jump when a photo is cropped or shaken. Larger: it does, and with little space chins rise less.
_FOLLOWS: Final = 1.3
# Space below the chin counts up to about this much. Larger values raise the chin more.
_BELOW: Final = 0.5
# A neck that the photo's edge cuts counts as this much space below the chin.
_NECK: Final = 0.1
# Behind an outline point the photo must go on for this share of the point's distance to the pivot.
# Otherwise the pivot moves towards that edge, for all of the head. Smaller values stretch the strip
# along the edge more, and the pivot follows the edge faster.
_ROOM: Final = 0.4
_ROUND: Final = 0.05  # width over which that limit sets in
# Near the photo's edge a displacement grows at most by this times the Amount per px.
EDGE_SLOPE: Final = 2.6
# The Amount is lowered so that the photo's edge makes the skull taller by little more than this
# share. It stays exactly as requested for up to half of that, and never falls as more is requested.
_TALLER: Final = 0.04
_MORE: Final = 0.75  # at most this much is added to that half, in `_TALLER`
_SHARP: Final = 4.0  # exponent of the transition; larger: the full Amount for longer, then a corner


@dataclass(frozen=True, slots=True)
class HeadFrame:
    """A head's own coordinates."""

    eyes_px: Array  # (2,): the middle of the eyes
    down: Array  # (2,): unit vector from the eyes to the mouth
    height_px: float  # from the eyes to the chin

    @classmethod
    def of(cls, face: Face) -> HeadFrame:
        """Return the coordinates of a face's head."""
        right = across(face)
        height = _HEIGHT * float(np.linalg.norm(face.mouth_center - face.eye_center))
        return cls(face.eye_center, np.array([-right[1], right[0]]), max(1e-3, height))


def pivot_and_share(face: Face, percent: float, photo: Box | None = None) -> tuple[Array, float]:
    """Return the point about which a head shrinks, (2,) px, and by which share.

    `percent`: the Amount. Without `photo` there is space on all sides. The share is the Amount's,
    or less where hair and chin are both near the photo's edge.
    """
    frame, share = HeadFrame.of(face), percent / 100.0
    size, eyes, down = frame.height_px, frame.eyes_px, frame.down
    if photo is None or not photo.area:
        photo = Box(-(2**30), -(2**30), 2**30, 2**30)
    # Where the outermost pixels end, so that a resized photo has the same pivot.
    low, high = np.array([(photo.left, photo.top), (photo.right, photo.bottom)]) - 0.5
    above = _ray_px(eyes, -down, low, high) / size
    below = _ray_px(eyes + size * down, down, low, high) / size
    crown = min(_CROWN, above)
    free = _WALL * _saturated(above - crown, _ABOVE)
    neck = _NECK + _saturated(below, _BELOW)
    # The photo is stretched above the head more than below.
    from_crown = float(limited((crown + 1.0) * free / (free + neck), _FOLLOWS * (above - crown)))
    pivot = eyes - (crown - from_crown) * size * down
    for axis in (0, 1):
        at = np.clip(face.outline[:, axis], low[axis], high[axis])
        least = float((at - (high[axis] - at) / _ROOM).max())
        most = float((at + (at - low[axis]) / _ROOM).min())
        over, under = (_positive(d / size) for d in (least - pivot[axis], pivot[axis] - most))
        pivot[axis] += size * (over - under)
    # How far the crown comes down, per share, and how much of that the photo's edge prevents.
    descent = crown - float((eyes - pivot) @ down) / size
    prevented = descent - float(limited(descent, EDGE_SLOPE * max(0.0, above - crown)))
    taller = prevented / max(crown, 0.1)
    wanted = abs(share * taller) / _TALLER
    excess = max(0.0, wanted - 0.5)
    more = excess / (1.0 + (excess / _MORE) ** _SHARP) ** (1.0 / _SHARP)
    return pivot, share * (1.0 if excess == 0.0 else (0.5 + more) / wanted)


def limited(move: npt.ArrayLike, most: npt.ArrayLike) -> Array:
    """Return displacements that stay below lengths `most` and hardly change far below these."""
    move, most = np.asarray(move, np.float64), np.asarray(most, np.float64)
    return np.asarray(move * most / np.maximum(np.cbrt(most**3 + np.abs(move) ** 3), 1e-9))


def _ray_px(point: Array, way: Array, low: Array, high: Array) -> float:
    """Return the distance from a point along a unit vector to the photo's edge, below 0 outside."""
    way = np.where(np.abs(way) < 1e-9, 1e-9, way)
    return float((np.where(way > 0.0, high - point, low - point) / way).min())


def _saturated(length: float, most: float) -> float:
    return most * float(np.tanh(max(0.0, length) / most))


def _positive(value: float) -> float:
    """Return 0 far below 0 and the value itself far above, rounded in between."""
    return 0.5 * (value + float(np.hypot(value, _ROUND)))
