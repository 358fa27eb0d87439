"""BlazeFace's "back" network: detects faces of any size, number and angle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Affine, Array, degrees_of
from kogao_core.base.threads import ObjectPool
from kogao_core.faces.doubt import ON_ITS_HEAD
from kogao_core.faces.landmarks.pixels import Pyramid, planes, read_network, sharpened

INPUT_PX: Final = 256  # side of the input of detector, mesh and segmentation
SAME_FACE_IOU: Final = 0.3  # boxes with a larger overlap (intersection over union) are one face
# Width of the wide and the close view, in sides of the face. In the wide view upright faces score
# 0.90 to 0.97, upside-down and false faces less. The close view rejects other false faces.
WIDE: Final = 4.0
CLOSE: Final = 1.5
SURE: Final = 0.9  # a higher probability needs no further view
# Widths of view, in sides of the face, within which a nearly upright proposal needs no wide view.
_ABOUT_WIDE: Final = (2.0, 6.0)
_ABOUT_UPRIGHT: Final = 15.0  # degrees; largest roll of such a proposal in the view
_LEAST_CLOSER: Final = 0.1  # least probability in a closer view
# A view with a smaller spread of levels is empty. A face of 2 % of a bare wall still spreads by 1.
_FLAT: Final = 1.0
_GRIDS: Final = ((16, 2), (8, 6))  # cells per side, anchors per cell


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """A face's box, rotated with the face."""

    center_px: Array  # (2,): middle of the box
    side_px: float  # longer side of the box
    degrees: float  # roll of the line between the eyes, from +x towards +y
    score: float  # the network's probability, 0 to 1
    # (6, 2): left and right eye, tip of the nose, middle of the mouth, left and right ear; None for
    # a box that does not come from the network.
    keypoints_px: Array | None = None
    # True if the view shows the face upright and about `WIDE` sides wide.
    seen_wide: bool = False

    def is_like(self, other: Detection) -> bool:
        """Return True if two boxes frame the same face: similar in position and size."""
        apart = float(np.linalg.norm(self.center_px - other.center_px))
        return apart < 0.5 * other.side_px and 0.5 < self.side_px / other.side_px < 2.0

    def overlaps(self, other: Detection) -> bool:
        """Return True if two boxes can't be two faces: large overlap, or one inside the other."""
        reach = (self.side_px + other.side_px) / 2.0 - np.abs(self.center_px - other.center_px)
        common = float(np.clip(reach, 0.0, min(self.side_px, other.side_px)).prod())
        small, large = sorted((self.side_px**2, other.side_px**2))
        return common > 0.6 * small or common > SAME_FACE_IOU * (small + large - common)


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Detections in one view."""

    boxes: list[Detection]  # the faces, best first, without duplicates
    most: float  # the highest probability of any anchor, with or without a face


@dataclass(frozen=True, slots=True, eq=False)
class Square:
    """A square of the image: one input of the network."""

    center_px: Array  # (2,): centre, px of the image
    side_px: float  # side, px of the image
    degrees: float = 0.0  # rotation, from +x towards +y

    @property
    def to_image(self) -> Affine:
        """Map from pixel centres of the network's input to the image."""
        scale = self.side_px / INPUT_PX
        turn = Affine.similarity(scale, self.degrees, (0.0, 0.0))
        middle = (INPUT_PX - 1) / 2.0
        return Affine(turn.matrix, self.center_px - turn((middle, middle)))


class BlazeFace:
    """The detector network. Thread-safe."""

    def __init__(self, weights: Path) -> None:
        self._nets = ObjectPool(lambda: read_network(weights))
        self._anchors = _anchors()

    def look(self, image: Pyramid, view: Square, least_score: float, *, soft: bool = False) -> Look:
        """Return the likely faces in one view; `soft` sharpens soft pictures first."""
        sampled = image.sample(view.to_image, INPUT_PX)
        sampled = sharpened(sampled) if soft else sampled
        spread = cv2.meanStdDev(np.ascontiguousarray(sampled[::2, ::2]))[1]
        if float(spread.max()) < _FLAT:
            return Look([], 0.0)
        with self._nets.one() as net:
            net.setInput(planes(sampled) / 127.5 - 1.0)
            regressors, logits = net.forward(["regressors", "classificators"])
        scores = 1.0 / (1.0 + np.exp(-np.clip(logits.reshape(-1), -80.0, 80.0)))
        likely = scores > least_score
        # 16 numbers per anchor: centre, size, then six points; the eyes come first.
        values = regressors.reshape(-1, 16)[likely].astype(np.float64)
        values[:, [0, 1]] += self._anchors[likely]
        values[:, 4:] += np.tile(self._anchors[likely], 6)
        boxes = [_detection(row, view, score) for row, score in _blended(values, scores[likely])]
        return Look(boxes, float(scores.max()))

    def look_closer(
        self, image: Pyramid, box: Detection
    ) -> tuple[list[Detection], list[Detection] | None]:
        """Detect a proposal again at a better size and upright, and list the boxes beside it.

        The likeliest box comes first, then less likely boxes with other rotations. No boxes: the
        proposal was not confirmed. None instead of boxes beside it: no second look was needed.
        """
        if box.seen_wide and box.score > SURE:
            return [box], None
        view = Square(box.center_px, WIDE * box.side_px, box.degrees)
        boxes = self.look(image, view, _LEAST_CLOSER).boxes
        seen = _like(box, boxes)
        beside = [one for one in boxes if one is not seen]
        if seen is not None and seen.score > SURE:
            return [seen], beside
        # Lying and upside-down heads are also detected, but with lower scores and misplaced eyes.
        turned = (replace(box, degrees=box.degrees + turn) for turn in (90.0, 180.0, 270.0))
        found = filter(None, [seen, *(self._best(image, one, WIDE) for one in turned)])
        return sorted(found, key=lambda one: -one.score), beside

    def sight(self, image: Pyramid, box: Detection, sides: float, *, soft: bool = False) -> float:
        """Return the probability that a box contains an upright face, in a view of `sides`."""
        seen = self._best(image, box, sides, soft=soft)
        return 0.0 if seen is None else seen.score

    def _best(
        self, image: Pyramid, box: Detection, sides: float, *, soft: bool = False
    ) -> Detection | None:
        view = Square(box.center_px, sides * box.side_px, box.degrees)
        return _like(box, self.look(image, view, _LEAST_CLOSER, soft=soft).boxes)


def are_opposite(one: Detection, other: Detection) -> bool:
    """Return True if one box is upside down relative to the other."""
    return abs((one.degrees - other.degrees + 180.0) % 360.0 - 180.0) > ON_ITS_HEAD


def _like(box: Detection, boxes: list[Detection]) -> Detection | None:
    return next((one for one in boxes if one.is_like(box)), None)


def _anchors() -> Array:
    rows = [
        np.stack(np.meshgrid(centers, centers), axis=-1).reshape(-1, 2).repeat(count, axis=0)
        for cells, count in _GRIDS
        for centers in [(np.arange(cells) + 0.5) * INPUT_PX / cells]
    ]
    return np.vstack(rows)


def _blended(values: Array, scores: Array) -> Iterator[tuple[Array, float]]:
    # Average the anchors of one face, weighted by score: steadier than the best (BlazeFace, 3.4).
    low, high = values[:, :2] - values[:, 2:4] / 2.0, values[:, :2] + values[:, 2:4] / 2.0
    open_ = np.ones(len(scores), bool)
    for best in np.argsort(-scores):
        if open_[best]:
            group = open_ & (_iou(low, high, best) > SAME_FACE_IOU)
            group[best] = True
            open_ &= ~group
            yield np.average(values[group], axis=0, weights=scores[group]), float(scores[best])


def _iou(low: Array, high: Array, one: int) -> Array:
    overlap = np.clip(np.minimum(high, high[one]) - np.maximum(low, low[one]), 0.0, None).prod(
        axis=1
    )
    area = (high - low).prod(axis=1)
    return np.asarray(overlap / np.maximum(area + area[one] - overlap, 1e-9))


def _detection(row: Array, view: Square, score: float) -> Detection:
    # The network's coordinates start at the edge of the first pixel; ours start at its centre.
    to_image = view.to_image
    center, *keypoints = to_image(row[[0, 1, *range(4, 16)]].reshape(7, 2) - 0.5)
    across = keypoints[1] - keypoints[0]
    degrees = degrees_of(across)
    side_px = float(row[2:4].max()) * to_image.scale
    tilt = abs((degrees - view.degrees + 180.0) % 360.0 - 180.0)
    wide = _ABOUT_WIDE[0] < view.side_px / side_px < _ABOUT_WIDE[1] and tilt < _ABOUT_UPRIGHT
    return Detection(center, side_px, degrees, score, np.array(keypoints), wide)
