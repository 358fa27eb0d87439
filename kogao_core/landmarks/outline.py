"""The 21 outline points of section 3.1: the silhouette of the mesh, not its fixed jaw line."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from kogao_core.face import OUTLINE_POINTS
from kogao_core.geometry import Array

LEFT_EAR: Final = 234
RIGHT_EAR: Final = 454
CHIN: Final = 152

# Mesh points that can lie on a face's silhouette: its oval, then the cheek points that stand out
# beyond it when the head turns. Nose and lips stay out: a profile's outline isn't its nose.
_OVAL: Final = (
    *(10, 338, 297, 332, 284, 251, 389, 356, 454, 323, 361, 288, 397, 365, 379, 378, 400, 377),
    *(152, 148, 176, 149, 150, 136, 172, 58, 132, 93, 234, 127, 162, 21, 54, 103, 67, 109),
)
_CHEEKS: Final = (
    *(34, 123, 135, 137, 138, 140, 147, 169, 177, 187, 192, 213, 214, 215, 227, 116),
    *(264, 352, 364, 366, 367, 369, 376, 394, 401, 411, 416, 433, 434, 435, 447, 345),
)
_RIM: Final = np.array(_OVAL + _CHEEKS)

# The mesh's jaw lies inside the visible one. Measured on 81 labelled studio faces, in lengths of
# the whole outline: most at the chin (t = 0), little at the ears (t = -1 and 1).
_OUTWARD_AT_CHIN: Final = 0.0039
_OUTWARD_LESS_AT_EARS: Final = 0.0029

# The ends lie above the line through the mesh's ears by this part of its length. An outline that
# ends on it misses 6 % of the outer inter-ocular distance of what people draw up to "ear level".
_ABOVE_EARS: Final = 0.06


def silhouette(mesh: Array, count: int = OUTLINE_POINTS) -> Array:
    """Return the visible edge of a face from ear level round the chin to ear level.

    Parameters
    ----------
    mesh : array of shape (468 or more, 2)
        Points of the MediaPipe face mesh, px.
    count : int
        Number of outline points, at equal steps of arc length.

    Returns
    -------
    array of shape (count, 2)
        From the mesh's left (point 234) to its right (454), px.

    Raises
    ------
    ValueError
        If the mesh has collapsed, so that no part of it lies below the ears.
    """
    return _pushed_out(resampled(_below_ears(mesh), count))


def _below_ears(mesh: Array) -> Array:
    # The line through both ears follows roll, yaw and pitch.
    rim = mesh[_RIM].astype(np.float32)
    hull = rim[cv2.convexHull(rim, returnPoints=False).ravel()].astype(np.float64)
    left, right = mesh[LEFT_EAR], mesh[RIGHT_EAR]
    across = right - left
    down = np.array([-across[1], across[0]])
    if down @ (mesh[CHIN] - left) < 0.0:
        down = -down
    depth = (hull - left) @ down + _ABOVE_EARS * float(across @ across)
    below = depth > 0.0
    starts = np.flatnonzero(below & ~np.roll(below, 1))
    if len(starts) != 1:
        raise ValueError("the mesh has collapsed: nothing of it lies below the ears")
    hull, depth = np.roll(hull, -starts[0], axis=0), np.roll(depth, -starts[0])
    last = int(np.count_nonzero(below)) - 1
    first_end = _crossing(hull[-1], hull[0], depth[-1], depth[0])
    last_end = _crossing(hull[last], hull[last + 1], depth[last], depth[last + 1])
    arc = np.vstack([first_end, hull[: last + 1], last_end])
    return arc if (arc[-1] - arc[0]) @ across > 0.0 else arc[::-1]


def _crossing(one: Array, other: Array, depth_one: float, depth_other: float) -> Array:
    return np.asarray(one + depth_one / (depth_one - depth_other) * (other - one))


def _arc_lengths(line: Array) -> Array:
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def resampled(line: Array, count: int) -> Array:
    """Return `count` points at equal steps of arc length along a polyline, ends kept.

    Parameters
    ----------
    line : array of shape (N, 2 or more)
        x, y and whatever else is to be interpolated with them.
    count : int
        Number of points.
    """
    lengths = _arc_lengths(line[:, :2])
    wanted = np.linspace(0.0, lengths[-1], count)
    return np.column_stack(
        [np.interp(wanted, lengths, line[:, axis]) for axis in range(line.shape[1])]
    )


def _pushed_out(line: Array) -> Array:
    t = np.linspace(-1.0, 1.0, len(line))
    along = np.gradient(line, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    outward = np.column_stack([-along[:, 1], along[:, 0]])
    # A mirrored mesh runs the other way round.
    if outward[len(line) // 2] @ (line[len(line) // 2] - (line[0] + line[-1]) / 2.0) < 0.0:
        outward = -outward
    distance = (_OUTWARD_AT_CHIN - _OUTWARD_LESS_AT_EARS * t**2) * _arc_lengths(line)[-1]
    return np.asarray(line + distance[:, None] * outward)
