"""Align an edited copy with its original and measure the displacement between the two."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np

from kogao_core.base.display import Rgb8
from kogao_core.base.geometry import Affine, Array, Image
from kogao_core.base.language import TextError
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks.pixels import Pyramid

# Window of the local contrast, px, and the contrast that counts as none, grey levels.
_WINDOW_PX: Final = 8.0
_NOISE: Final = 3.0
# Side of the square in which whole pictures are aligned, and its margin, px.
_SIDE_PX: Final = 800
_MARGIN_PX: Final = 6
_ENDS: Final = np.array([(0, 0), (_SIDE_PX, 0), (0, _SIDE_PX), (_SIDE_PX, _SIDE_PX)])
# A point aligns the pictures if both directions of the flow agree and it has some contrast.
_AGREE_PX: Final = 0.5
_TEXTURE: Final = 3e-4
_LEAST_POINTS: Final = 15
_MEDIAN: Final = 1.177  # median length of a normal vector in a plane, standard deviations
_NEAR_PX: Final = 0.7
# Two pictures show one scene if so large a share of the corners lies within so many px: a smooth
# warp moves the background, too.
_LEAST_SHARE: Final = 0.5
_SCENE_PX: Final = 5.0
# The frame of the original is left for a map that leaves at most so large a share of its misfits.
_CLEARLY: Final = 0.5
# A smaller correction at all corners is noise of the measurement: the copy has the same frame.
_SAME_FRAME_PX: Final = 0.3
_ROUNDED_PX: Final = 1.5
_MOST_STEPS: Final = 5
_LEAST_MATCHES: Final = 12
_MATCH_PX: Final = 3.0
_DISTINCT: Final = 0.75
# The head may have moved: it lies within so many widths of the outline from its middle.
_HEAD: Final = 1.5


class NotRead(TextError, ValueError):
    """The second picture can't be read as a retouch of the first; the message is a sentence."""


def flow(first: Rgb8, second: Rgb8) -> Array:
    """Return float32 (H, W, 2): how far each pixel of `first` has moved in `second`.

    Only local contrast counts, so edits of tone and skin change little.
    """
    finder: Any = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    finder.setFinestScale(1)
    return np.asarray(finder.calc(contrast(first), contrast(second), None))


def contrast(rgb: Rgb8) -> Rgb8:
    """Return the local contrast of a picture, uint8 (H, W), 128 on average."""
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    away = grey - cv2.GaussianBlur(grey, (0, 0), _WINDOW_PX)
    spread = cv2.sqrt(cv2.GaussianBlur(away * away, (0, 0), _WINDOW_PX) + _NOISE**2)
    return np.asarray(cv2.convertScaleAbs(away / spread * 32.0 + 128.0), np.uint8)


def at(picture: Image, points: Array) -> Array:
    """Return the values of a picture or flow at points (N, 2), shape (N, channels)."""
    x, y = np.asarray(points, np.float32).T
    values = cv2.remap(picture, x[None], y[None], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(values.reshape(len(points), -1), np.float64)


@dataclass(frozen=True, eq=False)
class Alignment:
    """A map from px of the original to px of the copy, and how far corners lie off the map."""

    to_after: Affine
    errors: Array  # (N,): of corners beside the heads, px of the square in which they are found
    scale: float  # px of the original per px of the square

    @property
    def doubt_px(self) -> float:
        """Standard deviation of a coordinate of the corners, px of the original; 0 without corners.

        From the median, as for normal errors, so that few corners that move alone don't count.
        """
        return self.scale * float(np.median(self.errors)) / _MEDIAN if len(self.errors) else 0.0

    def share(self, near_px: float) -> float:
        """Return the share of corners within a distance of the map, px of the square.

        1 where there are too few corners to tell.
        """
        few = len(self.errors) < _LEAST_POINTS
        return 1.0 if few else float(np.mean(self.errors < near_px))

    @property
    def is_scene(self) -> bool:
        """Whether both pictures show one scene."""
        return self.share(_SCENE_PX) > _LEAST_SHARE


def aligned(before: Pyramid, after: Pyramid, faces: Sequence[Face]) -> Alignment:
    """Return the map from px of `before` to px of `after`, measured beside the heads.

    The frame of `before` is kept unless another map fits clearly better. Raises NotRead.
    """
    for start in _starts(before, after):
        tried = list(_tried(before, after, start, faces))
        first, best = tried[0], max(tried, key=lambda one: one.share(_NEAR_PX))
        misfits = [1.0 - one.share(_NEAR_PX) for one in (first, best)]
        is_first = first.is_scene and misfits[1] > _CLEARLY * misfits[0]
        found = first if is_first else best
        if found.is_scene:
            return found
    raise NotRead("the two pictures don't show the same scene")


def _starts(before: Pyramid, after: Pyramid) -> Iterator[Affine]:
    wide, high = after.width / before.width, after.height / before.height
    if abs(wide * before.height - after.height) <= _ROUNDED_PX:
        yield Affine.resize(wide, high)
    matched = _matched(before, after)
    if matched is not None:
        yield matched


def _tried(
    before: Pyramid, after: Pyramid, start: Affine, faces: Sequence[Face]
) -> Iterator[Alignment]:
    """Yield a start and better and better maps."""
    here, view = start, _square(before)
    for _ in range(_MOST_STEPS):
        points, moved = _corners(before, after, here, faces)
        yield Alignment(here, np.linalg.norm(moved - points, axis=1), view.scale)
        if len(points) < _LEAST_POINTS:
            break
        step, _ = _similarity(points, moved, _NEAR_PX)
        if step is None or np.abs(step(_ENDS) - _ENDS).max() < _SAME_FRAME_PX:
            break
        here = here.after(view).after(step).after(view.inverse)


def _square(picture: Pyramid) -> Affine:
    """Return the map from the square in which a picture is aligned to the picture."""
    scale = max(picture.width, picture.height) / _SIDE_PX
    return Affine.resize(scale, scale)


def _corners(
    before: Pyramid, after: Pyramid, to_after: Affine, faces: Sequence[Face]
) -> tuple[Array, Array]:
    """Return corners of `before` beside the heads and their places in `after`, px of the square."""
    view = _square(before)
    one, other = before.sample(view, _SIDE_PX), after.sample(to_after.after(view), _SIDE_PX)
    mask = np.zeros(one.shape[:2], np.uint8)
    right, bottom = view.inverse((before.width - 1.0, before.height - 1.0)).astype(int) - _MARGIN_PX
    mask[_MARGIN_PX:bottom, _MARGIN_PX:right] = 255
    for face in faces:
        x, y = view.inverse(face.middle)
        reach = _HEAD * np.ptp(face.outline, axis=0).max() / view.scale
        cv2.circle(mask, (round(x), round(y)), round(reach), 0, -1)
    grey = cv2.cvtColor(one, cv2.COLOR_RGB2GRAY)
    mask[cv2.cornerMinEigenVal(grey, 5) < _TEXTURE] = 0
    found: Any = cv2.goodFeaturesToTrack(grey, 600, 0.001, 7, mask=mask)
    if found is None:
        return np.empty((0, 2)), np.empty((0, 2))
    points = found[:, 0].astype(np.float64)
    moved = points + at(flow(one, other), points)
    agree = np.linalg.norm(moved - points + at(flow(other, one), moved), axis=1) < _AGREE_PX
    inside = to_after(view(moved))
    agree &= ((inside > 0.0) & (inside < (after.width - 1.0, after.height - 1.0))).all(axis=1)
    return points[agree], moved[agree]


def _matched(before: Pyramid, after: Pyramid) -> Affine | None:
    """Return the map on which local features of both pictures agree, if there is one."""
    views = _square(before), _square(after)
    finder = cv2.SIFT.create(3000)
    found: Any = [
        finder.detectAndCompute(cv2.cvtColor(one.sample(view, _SIDE_PX), cv2.COLOR_RGB2GRAY), None)
        for one, view in zip((before, after), views, strict=True)
    ]
    (first, ours), (second, theirs) = found
    if ours is None or theirs is None:
        return None
    pairs = cv2.BFMatcher().knnMatch(ours, theirs, k=2)
    good = [
        two[0] for two in pairs if len(two) > 1 and two[0].distance < _DISTINCT * two[1].distance
    ]
    if len(good) < _LEAST_MATCHES:
        return None
    points = np.array([first[one.queryIdx].pt for one in good])
    moved = np.array([second[one.trainIdx].pt for one in good])
    step, agree = _similarity(points, moved, _MATCH_PX)
    if step is None or agree < _LEAST_MATCHES:
        return None
    return views[1].after(step).after(views[0].inverse)


def _similarity(points: Array, moved: Array, near_px: float) -> tuple[Affine | None, int]:
    """Return the similarity on which most points agree, and how many do."""
    found: Any = cv2.estimateAffinePartial2D(
        points, moved, method=cv2.RANSAC, ransacReprojThreshold=near_px
    )
    matrix, inside = found
    if matrix is None:
        return None, 0
    both = np.asarray(matrix, np.float64)
    return Affine(both[:, :2], both[:, 2]), int(inside.sum())
