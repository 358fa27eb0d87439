"""The 80 points of the model's shape: the outline first, then eyes, brows, nose and outer lips."""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.face import OUTLINE_POINTS, Face

# Indices of the 189 labels of the Face Research Lab sets, in the order of the 80 points.
OUTLINE_LABELS: Final = (*(109, 185, 110, 186, 111, *range(125, 134), 114, 188, 113, 187, 112),)
EYE_LABELS: Final = (18, 22, 23, 27)  # the corners, left to right
_EYES: Final = (18, 19, 20, 21, 22, 30, 29, 28, 23, 24, 25, 26, 27, 33, 32, 31)
_BROWS: Final = (71, 72, 73, 74, 75, 76, 84, 83, 77, 78, 79, 80, 81, 82, 86, 85)
_NOSE: Final = (51, 57, 52, 58, 54, 60, 61, 62, 63, 64, 55, 69, 68, 67, 66)
_LIPS: Final = (87, 88, 89, 90, 91, 92, 93, 108, 107, 106, 105, 104)
INNER_LABELS: Final = _EYES + _BROWS + _NOSE + _LIPS

_OPPOSITE: Final = {
    **dict(zip((18, 19, 20, 21, 22, 30, 29, 28), (27, 26, 25, 24, 23, 31, 32, 33), strict=True)),
    **dict(zip((71, 72, 73, 74, 75, 76, 84, 83), (82, 81, 80, 79, 78, 77, 85, 86), strict=True)),
    **dict(zip((51, 52, 54, 61, 62, 63, 64), (57, 58, 60, 66, 67, 68, 69), strict=True)),
    **dict(zip((87, 88, 89, 104, 105), (93, 92, 91, 108, 107), strict=True)),
}


def _row(label: int) -> int:
    return OUTLINE_POINTS + INNER_LABELS.index(label)


def _mirror() -> npt.NDArray[np.intp]:
    both = {**_OPPOSITE, **{right: left for left, right in _OPPOSITE.items()}}
    inner = [_row(both.get(label, label)) for label in INNER_LABELS]
    return np.array([*reversed(range(OUTLINE_POINTS)), *inner])


MIRROR: Final = _mirror()
"""Rows of the mirrored face: ``shape[MIRROR]`` with x negated is the face in a mirror."""
OUTLINE: Final = slice(0, OUTLINE_POINTS)
EYES: Final = [_row(label) for label in EYE_LABELS]
MOUTH: Final = [_row(label) for label in (87, 93)]


def face(shape: Array, score: float, confidence: Array, source: str) -> Face:
    """Return the paper's 27 points (section 3.1) of a shape (80, 2) and its confidence (80,)."""
    rows = [*range(OUTLINE_POINTS), *EYES, *MOUTH]
    return Face(
        shape[OUTLINE],
        shape[EYES],
        shape[MOUTH],
        score=score,
        source=source,
        confidence=confidence[rows],
    )


def similarity(points: Array, onto: Array) -> Affine:
    """Return the least-squares turn, scaling and shift of `points` (N, 2) onto `onto` (N, 2)."""
    middle, goal = points.mean(axis=0), onto.mean(axis=0)
    a, b = points - middle, onto - goal
    turn = np.array([(a * b).sum(), (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()]) / (a**2).sum()
    matrix = np.array([[turn[0], -turn[1]], [turn[1], turn[0]]])
    return Affine(matrix, goal - matrix @ middle)
