"""Refine outlines: find the visible edge of the face near the mesh's silhouette.

The picture across the outline is unrolled into a strip. A very small convolutional network scores
each step across the outline; a chain model turns the scores into one smooth line.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array, Image, degrees_of
from kogao_core.faces.landmarks import locked
from kogao_core.faces.landmarks.outline import resampled
from kogao_core.faces.landmarks.pixels import Pyramid, sharpened

Floats = npt.NDArray[np.float32]
Layer = tuple[int, int, int, int, int]

OUTPUTS: Final = 2  # log-odds: the edge is here; the edge is hidden
# Per layer: channels in and out, reach along the outline, number of taps across and their distance.
# All layers are symmetric along the outline, so a mirrored face gets the mirrored result.
LAYERS: Final[tuple[Layer, ...]] = (
    (5, 12, 1, 5, 1),
    (12, 12, 2, 5, 2),
    (12, 12, 4, 5, 2),
    (12, 12, 1, 3, 1),
    (12, OUTPUTS, 1, 1, 1),
)
LAST: Final = len(LAYERS) - 1  # this layer has no rectifier
ALONG: Final = 41  # lines across an outline
ACROSS: Final = np.arange(-24.0, 51.0)  # steps from inside to outside
MOVES: Final = np.arange(-14, 41)  # steps where the edge may be; large values allow long beards
UNIT: Final = 100  # steps per outer inter-ocular distance
# Region with few beard hairs, the reference for skin: lines from the chin (0) to the ends (1), and
# the range of steps inside the outline.
_CHEEKS: Final = (0.35, 0.8)
_DEEP: Final = -6
# XYZ of linear sRGB (IEC 61966-2-1), each divided by that of white.
_TO_XYZ: Final = np.array(
    [[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169], [0.019334, 0.119193, 0.950227]]
) / np.array([[0.950456], [1.0], [1.088754]])
_SIDE: Final = 384  # side of the crop, steps
MODEL: Final = "models/edges.npz"

# One step is 1 % of the outer inter-ocular distance. Larger deviations permit larger moves of the
# silhouette. Deviation of a visible edge inside the silhouette at the chin, in steps. Without
# beards, an edge farther than twice this value is not the chin's edge.
_INWARDS: Final = 2.5
# Deviation outside the silhouette at the chin, in steps: beards extend far below the chin.
_OUTWARDS: Final = 20.0
_ON_CHEEKS: Final = 5.0  # deviation in both directions on the cheeks, in steps
_GUESSED: Final = 10.0  # deviation of a hidden edge in both directions, in steps
_CHANGE: Final = 1.5  # deviation between neighbouring lines, in steps; smaller: a smoother outline
_SAME: Final = 3.0  # scores within this many steps of the result count for the confidence
# Exponent of each line's evidence: neighbouring lines see overlapping pixels.
_OWN_SHARE: Final = 0.5
_NEIGHBOURS: Final = np.array([0.1, 0.2, 0.4, 0.2, 0.1])  # weights of a mean of confidences
# 0 for lines at the chin, 1 for lines at a cheek.
_CHEEK: Final = np.clip(2.0 * np.abs(np.linspace(-1.0, 1.0, ALONG)) - 0.5, 0.0, 1.0)[:, None]
_AT_CHIN: Final = np.where(MOVES > 0, _OUTWARDS, _INWARDS)
_SEEN: Final = np.exp(-0.5 * (MOVES / (_AT_CHIN + _CHEEK * (_ON_CHEEKS - _AT_CHIN))) ** 2)
_OF_CHIN: Final = np.abs(MOVES) <= 2.0 * _INWARDS
_UNSEEN: Final = np.exp(-0.5 * (MOVES / _GUESSED) ** 2) * (-MOVES[0] >= MOVES)  # either way alike
INSIDE: Final = int(MOVES[0] - ACROSS[0])


def shapes() -> list[tuple[int, ...]]:
    """Return the shapes of all parameters: weights and biases in turn."""
    result: list[tuple[int, ...]] = []
    for inputs, outputs, _, taps, _ in LAYERS:
        result += [(outputs, 2 * inputs * taps), (outputs, 1)]
    return result


def forward(parameters: list[Floats], strips: Floats) -> Floats:
    """Run the network. `strips` (B, 5, along, across). Result (B, 2, along, across)."""
    here = strips
    for index in range(len(LAYERS)):
        _, here = through(parameters, index, here)
    return here


def through(parameters: list[Floats], index: int, here: Floats) -> tuple[Floats, Floats]:
    """Return the columns that one layer gathers from its input (B, C, along, across), and output.

    `columns` (B, 2 C taps, along * across): the taps across at each position, and the sums of the
    neighbours along the outline; `output` (B, outputs, along, across).
    """
    columns = _columns(here, LAYERS[index])
    output = np.matmul(parameters[2 * index], columns) + parameters[2 * index + 1]
    if index < LAST:
        np.maximum(output, 0.0, out=output)
    return columns, output.reshape(len(here), -1, *here.shape[2:])


def _columns(here: Floats, layer: Layer) -> Floats:
    _, _, reach, taps, step = layer
    both = np.concatenate([here, neighbours(here, reach)], axis=1)
    middle = taps // 2
    parts = [shifted(both, (tap - middle) * step, axis=3) for tap in range(taps)]
    return np.concatenate(parts, axis=1).reshape(len(here), -1, here[0, 0].size)


def neighbours(here: Floats, reach: int) -> Floats:
    """Return the sums of the positions `reach` before and after each along the outline (axis 2)."""
    return shifted(here, reach, axis=2) + shifted(here, -reach, axis=2)


def shifted(here: Floats, by: int, axis: int) -> Floats:
    """Return `here` shifted by `by` positions along `axis`, padded with zeros."""
    if by == 0:
        return here
    result = np.zeros_like(here)
    source = [slice(None)] * here.ndim
    target = list(source)
    source[axis] = slice(max(0, by), min(here.shape[axis], here.shape[axis] + by))
    target[axis] = slice(max(0, -by), min(here.shape[axis], here.shape[axis] - by))
    result[tuple(target)] = here[tuple(source)]
    return result


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Points on an outline with outward normals, in steps of a `Cut`."""

    # (41, 2): at equal steps of arc length.
    points: Array
    normals: Array

    def moved(self, moves: Array) -> Array:
        """Return the points moved along their normals by `moves`, shape (41,)."""
        return self.points + moves[:, None] * self.normals


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """An upright crop of a face at a fixed size."""

    picture: Image  # uint8 (384, 384, 3): RGB
    to_image: Affine  # maps pixels of the crop to the image

    @staticmethod
    def of(image: Pyramid, eyes: Array, outline: Array) -> Cut:
        """Return the crop of a face by eye corners (4, 2) and outline (N, 2), px of the image."""
        across = eyes[3] - eyes[0]
        scale = max(1e-6, float(np.linalg.norm(across))) / UNIT
        degrees = degrees_of(across)
        turn = Affine.similarity(scale, degrees, (0.0, 0.0))
        middle = (outline.min(axis=0) + outline.max(axis=0) + 2.0 * eyes.mean(axis=0)) / 4.0
        half = (_SIDE - 1) / 2.0
        to_image = Affine(turn.matrix, middle - turn((half, half)))
        return Cut(sharpened(image.sample(to_image, _SIDE, cv2.BORDER_REPLICATE)), to_image)

    def strip(self, lines: Lines, steps: Array = ACROSS) -> Image:
        """Sample the picture along the lines' normals at `steps`; default shape (41, 75, 3)."""
        grid = lines.points[:, None] + steps[..., None] * lines.normals[:, None]
        x, y = np.moveaxis(grid.astype(np.float32), -1, 0)
        strip = cv2.remap(self.picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(strip)


def lines_of(outline: Array) -> Lines:
    """Return 41 lines across an outline (N, 2), px of a `Cut`, from left to right."""
    points = resampled(smooth(outline), ALONG)
    along = np.gradient(points, axis=0)
    along[1:-1] = (along[:-2] + 2.0 * along[1:-1] + along[2:]) / 4.0
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    return Lines(points, np.column_stack([-along[:, 1], along[:, 0]]))


def smooth(outline: Array) -> Array:
    """Insert N - 1 points between points (N, 2), each on a cubic through four points."""
    ends = np.vstack([2.0 * outline[0] - outline[1], outline, 2.0 * outline[-1] - outline[-2]])
    halfway = (9.0 * (ends[1:-2] + ends[2:-1]) - ends[:-3] - ends[3:]) / 16.0
    result = np.empty((2 * len(outline) - 1, 2))
    result[::2], result[1::2] = outline, halfway
    return result


def planes(strip: Image) -> Floats:
    """Return the network's input for a strip, (5, 41, 75): Lab relative to the skin, positions."""
    lab = cielab(strip).astype(np.float32)
    away = np.abs(np.linspace(-1.0, 1.0, ALONG))
    cheeks = lab[(away > _CHEEKS[0]) & (away < _CHEEKS[1])][:, ACROSS < _DEEP]
    # A median by sorting, without the import of numpy's extra modules.
    ordered = np.sort(cheeks.reshape(-1, 3), axis=0)
    skin = (ordered[(len(ordered) - 1) // 2] + ordered[len(ordered) // 2]) / 2.0
    spread = np.array([lab[..., 0].std() + 8.0, 12.0, 12.0], np.float32)
    places = np.meshgrid(away, ACROSS / 10.0, indexing="ij")
    return np.stack([*np.moveaxis((lab - skin) / spread, -1, 0), *places]).astype(np.float32)


def cielab(rgb: Image) -> Image:
    """Convert sRGB to CIELAB with L* times 2.55 and a*, b* plus 128; uint8 (..., 3).

    Every value equals that of OpenCV's ``COLOR_RGB2LAB``, which first computes tables for 37 ms.
    """
    share, levels = np.arange(256) / 255.0, 255 * 8
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    light = np.rint(levels * linear).astype(np.int64)[rgb]
    xyz = _shifted_right(light @ np.rint(_TO_XYZ.T * 2**12).astype(np.int64), 12)
    t = np.arange(levels + 2, dtype=np.float32) / np.float32(levels)
    root = np.where(t < 216 / 24389, t * np.float32(841 / 108) + np.float32(4 / 29), np.cbrt(t))
    x, y, z = np.moveaxis(np.rint(2**15 * root).astype(np.int64)[xyz], -1, 0)
    middle = 128 * 2**15
    # L* is 116 y - 16; both factors are rounded like OpenCV's.
    lab = np.stack([296 * y - 1336934, 500 * (x - y) + middle, 200 * (y - z) + middle], axis=-1)
    return np.asarray(np.clip(_shifted_right(lab, 15), 0, 255), np.uint8)


def _shifted_right(values: npt.NDArray[np.int64], bits: int) -> npt.NDArray[np.int64]:
    """Divide by a power of two and round."""
    return (values + (1 << bits - 1)) >> bits


class EdgeNetwork:
    """Moves an outline onto the visible edge."""

    def __init__(self, parameters: list[Floats], *, beards: bool = True) -> None:
        self._parameters = parameters
        self._beards = beards

    @staticmethod
    def read(path: Path, *, beards: bool = True) -> EdgeNetwork:
        """Read a model file. `beards` False: the outline follows the chin. Raises ModelRefused."""
        stored = locked.arrays(path)
        parameters = [np.asarray(stored[name], np.float32) for name in sorted(stored)]
        return EdgeNetwork(parameters, beards=beards)

    def refined(self, image: Pyramid, eyes: Array, outline: Array) -> tuple[Array, Array]:
        """Return a finer outline and the confidence of each point.

        `eyes` (4, 2) px. `outline` (N, 2): at equal steps of arc length, px; `confidence` (N,):
        probability, 0 to 1, that the edge is visible and within 3 % of the outer inter-ocular
        distance.
        """
        cut = Cut.of(image, eyes, outline)
        lines = lines_of(cut.to_image.inverse(outline))
        outputs = forward(self._parameters, planes(cut.strip(lines))[None])
        moves, confidence = settle(*split(outputs[0]), beards=self._beards)
        moved = np.column_stack([lines.moved(moves), confidence])
        even = resampled(moved, len(outline))
        return cut.to_image(even[:, :2]), np.clip(even[:, 2], 0.0, 1.0)


def split(outputs: Floats) -> tuple[Floats, Floats]:
    """Return the log-odds of each move, shape (..., 41, 55), and of unseen edges, (..., 41)."""
    window = outputs[..., INSIDE : INSIDE + len(MOVES)]
    return window[..., 0, :, :], window[..., 1, :, :].mean(axis=-1)


def settle(seen: Floats, unseen: Floats, *, beards: bool = True) -> tuple[Array, Array]:
    """Return the expected move of each line and its confidence.

    The moves form a chain with similar neighbours, solved forwards and backwards. `seen` (41, 55);
    `unseen` (41,). `moves` (41,): steps outwards; `confidence` (41,): 0 to 1.
    """
    own = np.exp(seen - seen.max(axis=1, keepdims=True)).astype(np.float64)
    own /= own.sum(axis=1, keepdims=True)
    visible = 1.0 / (1.0 + np.exp(np.clip(unseen.astype(np.float64), -30.0, 30.0)))[:, None]
    if not beards:
        own = own * _OF_CHIN + 1e-12
        share = own.sum(axis=1, keepdims=True)
        visible, own = visible * share, own / share
    alone = own**_OWN_SHARE
    alone /= alone.sum(axis=1, keepdims=True)
    likely = visible * alone * _SEEN + (1.0 - visible) * _UNSEEN / _UNSEEN.sum()
    moves = _along_chain(likely) @ MOVES
    # Each line's own evidence predicts errors better than the overconfident chain: areas under the
    # curve for errors above 5 % are 0.86 and 0.72.
    near = np.abs(MOVES - moves[:, None]) <= _SAME
    agreed = visible[:, 0] * (own * near).sum(axis=1)
    return moves, np.convolve(np.pad(agreed, 2, mode="edge"), _NEIGHBOURS, "valid")


def _along_chain(likely: Array) -> Array:
    change = np.exp(-0.5 * ((MOVES[:, None] - MOVES) / _CHANGE) ** 2)
    change /= change.sum(axis=1, keepdims=True)
    before, after = likely.copy(), np.ones_like(likely)
    for line in range(1, len(likely)):
        before[line] *= before[line - 1] @ change
        before[line] /= before[line].sum()
    for line in range(len(likely) - 2, -1, -1):
        after[line] = change @ (after[line + 1] * likely[line + 1])
        after[line] /= after[line].sum()
    share = before * after
    return np.asarray(share / share.sum(axis=1, keepdims=True))
