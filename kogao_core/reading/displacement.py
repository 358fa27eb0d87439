"""Read how an edited copy of a photo moved outline, features, ears and hairline of its faces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np

from kogao_core.base.geometry import Affine, Array, Image
from kogao_core.base.threads import one_blas_thread
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks.pixels import Pyramid
from kogao_core.field.measures import measures
from kogao_core.reading.flow import Alignment, NotRead, aligned, at, contrast, flow

# Width of the outline in the square in which a face is measured, and the side of the square, px.
_FACE_PX: Final = 360.0
_SIDE_PX: Final = 960
# A point is read from its surroundings: a Gaussian of the first width, px; the more doubt there
# is (% of the face width for the half), the more of the second.
_AROUND_PX: Final = (3.0, 9.0)
_DOUBTED: Final = 0.08
# Distance of both directions of the flow at which a pixel counts half, px.
_AGREE_PX: Final = 0.7
# Blurs with which a face and its copy, moved back, are compared, px.
_FINE_PX: Final = 1.0
_COARSE_PX: Final = 8.0
# Compared part of the mouth: half width and half height, distances between the outer eye corners.
_MOUTH: Final = (0.5, 0.3)
_LEAST_FACE_PX: Final = 70.0
# Largest difference (1 - correlation) of a retouched face, and of its mouth. Heavy smoothing
# changes the mouth, too, but less than the detail of the whole face: the mouth may differ by a
# share of that.
_MOST_UNLIKE: Final = 0.06
_MOUTH_UNLIKE: Final = 0.0108
_MOUTH_SHARE: Final = 0.27
# Half width of the interval of a mean move, doubts of the flow: measured on thin plates.
_FLOW_DOUBTS: Final = 2.0
_MOST_DOUBT: Final = 0.5  # median of a face, % of the width


@dataclass(frozen=True, eq=False)
class Reading:
    """How a copy moved one face; px of the original, doubt in % of the outline's width."""

    face: Face
    points: Array  # (N, 2): outline, eyes, mouth, ears and, where known, hairline
    moved: Array  # (N, 2): where the copy shows them
    doubt: Array  # (N,): how far both directions of the flow disagree there
    shift_doubt: float  # of the alignment: standard deviation of corners in the background
    to_copy: Affine  # from px of the original to px of the copy, measured beside the heads

    @property
    def outline(self) -> Array:
        """The outline in the copy, px of the original."""
        return self.moved[: len(self.face.outline)]

    def narrower(self, row: int) -> float:
        """Return the change of the distance of an outline point from its opposite, %."""
        first, last = row, len(self.face.outline) - 1 - row
        ours, theirs = (
            np.linalg.norm(where[first] - where[last]) for where in (self.points, self.moved)
        )
        return float(100.0 * (theirs / ours - 1.0))

    @property
    def moved_percent(self) -> float:
        """Mean move of the outline, % of its width."""
        away = np.linalg.norm(self.outline - self.face.outline, axis=1).mean()
        return float(100.0 * away / measures(self.face).width_px)

    @property
    def moved_doubt_percent(self) -> float:
        """Half width of an interval of about 95 % of `moved_percent`, % of the outline's width."""
        flow = float(np.median(self.doubt[: len(self.face.outline)]))
        return math.hypot(_FLOW_DOUBTS * flow, self.shift_doubt)

    def to_dict(self) -> dict[str, Any]:
        return {
            "points": self.points.round(3).tolist(),
            "moved": self.moved.round(3).tolist(),
            "doubt_percent": self.doubt.round(3).tolist(),
            "shift_doubt_percent": round(self.shift_doubt, 3),
            "moved_percent": round(self.moved_percent, 3),
            "moved_doubt_percent": round(self.moved_doubt_percent, 3),
        }


def read_faces(before: Image, after: Image, faces: Sequence[Face]) -> list[Reading]:
    """Return how `after` moved the faces of `before`.

    Raises NotRead where `after` is no retouch of `before`, or a face is too small.
    """
    if not faces:
        raise NotRead("no face was found in the original")
    with one_blas_thread():
        ours, theirs = Pyramid(before), Pyramid(after)
        alignment = aligned(ours, theirs, faces)
        return [_read(ours, theirs, alignment, face) for face in faces]


def _read(before: Pyramid, after: Pyramid, alignment: Alignment, face: Face) -> Reading:
    width, to_after = measures(face).width_px, alignment.to_after
    if min(1.0, to_after.scale) * width < _LEAST_FACE_PX:
        raise NotRead("the face is too small to read: less than {n:g} px wide", n=_LEAST_FACE_PX)
    points, scale = _points(face), width / _FACE_PX
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    view = Affine.similarity(scale, 0.0, middle - scale * (_SIDE_PX - 1) / 2.0)
    pictures = before.sample(view, _SIDE_PX), after.sample(to_after.after(view), _SIDE_PX)
    there, back = flow(*pictures), flow(*pictures[::-1])
    y, x = np.mgrid[:_SIDE_PX, :_SIDE_PX].astype(np.float32)
    way = x + there[..., 0], y + there[..., 1]
    returned = cv2.remap(back, *way, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    apart = np.linalg.norm(there + returned, axis=2)
    weights = _texture(pictures[0]) / (1.0 + (apart / _AGREE_PX) ** 2)
    here = view.inverse(points)
    shown = cv2.remap(pictures[1], *way, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    inside = np.zeros(apart.shape, np.uint8)
    cv2.fillConvexPoly(inside, cv2.convexHull(np.round(here[: len(face.points)]).astype(int)), 1)
    if 100.0 / _FACE_PX * np.median(apart[inside > 0]) > _MOST_DOUBT:
        raise NotRead("a face was not warped smoothly: its displacement is too uncertain")
    _check((pictures[0], shown), inside > 0, _mouth(view.inverse, face))
    flows = np.dstack([(there - returned) / 2.0, apart])
    near, wide = (at(_mean(flows, weights, around), here) for around in _AROUND_PX)
    doubt = wide[:, 2:] * 100.0 / _FACE_PX
    moved = here + near[:, :2] + (wide - near)[:, :2] * doubt**2 / (doubt**2 + _DOUBTED**2)
    shift = 100.0 * alignment.doubt_px / width
    return Reading(face, points, view(moved), doubt[:, 0], shift, to_after)


def _points(face: Face) -> Array:
    ears = face.middle + 1.15 * (face.outline[[2, -3]] - face.middle)
    rim = [] if face.forehead is None else [face.forehead]
    return np.vstack([face.points, ears, *rim])


def _texture(picture: Image) -> Array:
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    across, down = (cv2.Sobel(grey, cv2.CV_32F, *order) for order in ((1, 0), (0, 1)))
    return np.asarray(cv2.GaussianBlur(across**2 + down**2, (0, 0), 2.0) + 1.0)


def _mean(values: Array, weights: Array, around_px: float) -> Array:
    """Return the weighted means of values (H, W, C) round each pixel."""
    total = cv2.GaussianBlur(weights, (0, 0), around_px) + 1e-6
    mean = cv2.GaussianBlur(values * weights[..., None], (0, 0), around_px)
    return np.asarray(mean / total[..., None], np.float32)


def _mouth(to_square: Affine, face: Face) -> tuple[slice, slice]:
    """Return rows and columns round the mouth."""
    middle, half = to_square(face.mouth_center), face.interocular_px * to_square.scale
    low, high = (np.round(middle + side * half * np.array(_MOUTH)).astype(int) for side in (-1, 1))
    return slice(low[1], high[1]), slice(low[0], high[0])


def _check(pictures: tuple[Image, Image], inside: Image, mouth: tuple[slice, slice]) -> None:
    """Raise NotRead where a face and its copy differ in more than shape, tone and detail."""

    def unlike(where: Any, blur_px: float) -> float:
        one, other = (cv2.GaussianBlur(contrast(each), (0, 0), blur_px) for each in pictures)
        return 1.0 - float(np.corrcoef(one[where].ravel(), other[where].ravel())[0, 1])

    most = max(_MOUTH_UNLIKE, _MOUTH_SHARE * unlike(inside, _FINE_PX))
    if unlike(inside, _COARSE_PX) > _MOST_UNLIKE or unlike(mouth, _COARSE_PX) > most:
        raise NotRead("a face differs in more than shape: another photo or another person")
