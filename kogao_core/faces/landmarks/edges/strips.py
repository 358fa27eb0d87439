"""Strips: what a face looks like across its outline, unrolled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Affine, Array, Image, degrees_of
from kogao_core.faces.landmarks.edges.network import Floats
from kogao_core.faces.landmarks.outline import resampled
from kogao_core.faces.landmarks.pixels import Pyramid, sharpened

ALONG: Final = 41
ACROSS: Final = np.arange(-24.0, 51.0)  # steps from inside to outside
MOVES: Final = np.arange(-14, 41)  # the part of them where the edge may be: beards are long
UNIT: Final = 100  # steps per outer inter-ocular distance
# Where a beard seldom grows, so that one stands out against it: the lines from the chin (0) to the
# ends (1), and how far inside.
_CHEEKS: Final = (0.35, 0.8)
_DEEP: Final = -6
_SIDE: Final = 384  # of the picture that strips are cut from, steps


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Places along an outline with their outward normals; steps of a `Cut`."""

    # (41, 2): at equal steps of arc length.
    points: Array
    normals: Array

    def moved(self, moves: Array) -> Array:
        """Return the points moved along their normals by `moves`, shape (41,)."""
        return self.points + moves[:, None] * self.normals


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """A face cut out upright at a fixed size."""

    picture: Image  # uint8 (384, 384, 3): RGB
    to_image: Affine  # maps its pixels to the image

    @staticmethod
    def of(image: Pyramid, eyes: Array, outline: Array) -> Cut:
        """Return the cut of a face by eye corners (4, 2) and outline (N, 2), px of the image."""
        across = eyes[3] - eyes[0]
        scale = max(1e-6, float(np.linalg.norm(across))) / UNIT
        degrees = degrees_of(across)
        turn = Affine.similarity(scale, degrees, (0.0, 0.0))
        middle = (outline.min(axis=0) + outline.max(axis=0) + 2.0 * eyes.mean(axis=0)) / 4.0
        half = (_SIDE - 1) / 2.0
        to_image = Affine(turn.matrix, middle - turn((half, half)))
        return Cut(sharpened(image.sample(to_image, _SIDE, cv2.BORDER_REPLICATE)), to_image)

    def strip(self, lines: Lines, steps: Array = ACROSS) -> Image:
        """Return the picture across these lines, shape (41, 75, 3), there or at other steps."""
        grid = lines.points[:, None] + steps[..., None] * lines.normals[:, None]
        x, y = np.moveaxis(grid.astype(np.float32), -1, 0)
        strip = cv2.remap(self.picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(strip)


def lines_of(outline: Array) -> Lines:
    """Return 41 lines across an outline (N, 2), px of a `Cut`, that runs from left to right."""
    points = resampled(smooth(outline), ALONG)
    along = np.gradient(points, axis=0)
    along[1:-1] = (along[:-2] + 2.0 * along[1:-1] + along[2:]) / 4.0
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    return Lines(points, np.column_stack([-along[:, 1], along[:, 0]]))


def smooth(outline: Array) -> Array:
    """Return points (N, 2) and between them N - 1 on the cubic through four, no chords."""
    ends = np.vstack([2.0 * outline[0] - outline[1], outline, 2.0 * outline[-1] - outline[-2]])
    halfway = (9.0 * (ends[1:-2] + ends[2:-1]) - ends[:-3] - ends[3:]) / 16.0
    result = np.empty((2 * len(outline) - 1, 2))
    result[::2], result[1::2] = outline, halfway
    return result


def planes(strip: Image) -> Floats:
    """Return what the network sees of a strip, shape (5, 41, 75): Lab against the skin, places."""
    lab = cv2.cvtColor(np.ascontiguousarray(strip), cv2.COLOR_RGB2LAB).astype(np.float32)
    away = np.abs(np.linspace(-1.0, 1.0, ALONG))
    cheeks = lab[(away > _CHEEKS[0]) & (away < _CHEEKS[1])][:, ACROSS < _DEEP]
    # The median, without the modules that numpy's loads.
    ordered = np.sort(cheeks.reshape(-1, 3), axis=0)
    skin = (ordered[(len(ordered) - 1) // 2] + ordered[len(ordered) // 2]) / 2.0
    spread = np.array([lab[..., 0].std() + 8.0, 12.0, 12.0], np.float32)
    places = np.meshgrid(away, ACROSS / 10.0, indexing="ij")
    return np.stack([*np.moveaxis((lab - skin) / spread, -1, 0), *places]).astype(np.float32)
