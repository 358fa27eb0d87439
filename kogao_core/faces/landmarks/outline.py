"""The 21 outline points of section 3.1: the silhouette of the mesh, not its fixed jaw line.

The rest of the silhouette is the rim of the forehead.
"""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array, arc_lengths
from kogao_core.base.language import BadValue
from kogao_core.faces.face import FOREHEAD_POINTS, OUTLINE_POINTS

# Ends of an outline on the silhouette: this far below the line through the outer eye corners, in
# distances between these corners. 0 is the eye line, as in mark-ups of 68 points and in hand labels
# of studio faces (0.04 below the line on average, 0.08 variation between faces).
END_BELOW_EYES: Final = 0.0

# Mesh points that can be on a face's silhouette: the oval, then the cheek points that extend beyond
# the oval of a turned head. Nose and lips are excluded, so a profile's outline omits the nose.
_OVAL: Final = (
    *(10, 338, 297, 332, 284, 251, 389, 356, 454, 323, 361, 288, 397, 365, 379, 378, 400, 377),
    *(152, 148, 176, 149, 150, 136, 172, 58, 132, 93, 234, 127, 162, 21, 54, 103, 67, 109),
)
_CHEEKS: Final = (
    *(34, 123, 135, 137, 138, 140, 147, 169, 177, 187, 192, 213, 214, 215, 227, 116),
    *(264, 352, 364, 366, 367, 369, 376, 394, 401, 411, 416, 433, 434, 435, 447, 345),
)
_RIM: Final = np.array(_OVAL + _CHEEKS)

# The mesh's jaw is inside the visible jaw. Measured on 81 labelled studio faces, in lengths of the
# whole outline: most at the chin (t = 0), little at the ends (t = -1 and 1).
_OUTWARD_AT_CHIN: Final = 0.0039
_OUTWARD_LESS_AT_ENDS: Final = 0.0029


def silhouette(mesh: Array, eyes: Array) -> Array:
    """Return the visible edge of a face from the eye line round the chin to the eye line.

    `mesh` (468 or more, 2) px; `eyes` (4, 2) px. Result (21, 2): left to right at equal steps of
    arc length, px.
    """
    return _pushed_out(resampled(_arc(mesh, eyes), OUTLINE_POINTS))


def forehead(mesh: Array, eyes: Array) -> Array:
    """Return the visible edge of a face from the eye line over the forehead to the eye line.

    The `silhouette` above the eyes, of shape (15, 2): both ends and `FOREHEAD_POINTS` between them.
    """
    # In an upside-down face the forehead is the part below the eyes.
    return resampled(_arc(mesh, eyes[::-1])[::-1], FOREHEAD_POINTS + 2)


def joined(rim: Array, outline: Array) -> Array:
    """Return the inner points of a `forehead`, shifted so that the ends meet an outline's ends.

    `rim` (15, 2) px. Result (13, 2) px.
    """
    share = np.linspace(0.0, 1.0, len(rim))[:, None]
    moved = rim + (1.0 - share) * (outline[0] - rim[0]) + share * (outline[-1] - rim[-1])
    return np.asarray(moved[1:-1])


def _arc(mesh: Array, eyes: Array) -> Array:
    """Return the part of the silhouette below the eyes, from the first eye's side on."""
    rim = mesh[_RIM].astype(np.float32)
    hull = rim[cv2.convexHull(rim, returnPoints=False).ravel()].astype(np.float64)
    hull = np.roll(hull, -int(_below_eyes(hull, eyes).argmin()), axis=0)
    arc = ended(np.vstack([hull, hull[:1]]), eyes)
    backwards = (arc[-1] - arc[0]) @ (eyes[3] - eyes[0]) < 0.0
    return arc[::-1] if backwards else arc


def ended(line: Array, eyes: Array) -> Array:
    """Return the part of a line round the chin between the heights of `END_BELOW_EYES`.

    `eyes` (4, 2) px. Result (M, 2) px, with both ends at that height.
    """
    depth = _below_eyes(line, eyes) - END_BELOW_EYES
    chin = int(depth.argmax())
    if not depth[chin] > 0.0:
        raise BadValue("the face has collapsed: nothing of it lies below the eyes")
    first = _raised(line[chin::-1], depth[chin::-1])
    last = _raised(line[chin:], depth[chin:])
    return np.vstack([first[:0:-1], last])


def _below_eyes(points: Array, eyes: Array) -> Array:
    """Return the depth of points below the line through the outer eye corners, in its length."""
    across = eyes[3] - eyes[0]
    down = np.array([-across[1], across[0]]) / max(1e-12, float(across @ across))
    return np.asarray((points - eyes[0]) @ down)


def _raised(side: Array, depth: Array) -> Array:
    """Cut a line, which starts at the chin, at depth 0."""
    over = np.flatnonzero(depth <= 0.0)
    at = int(over[0]) if len(over) else len(side) - 1
    if at == 0 or not depth[at] < depth[at - 1]:
        raise BadValue("the face has collapsed: its outline doesn't reach the eyes")
    end = side[at - 1] + depth[at - 1] / (depth[at - 1] - depth[at]) * (side[at] - side[at - 1])
    return np.vstack([side[:at] if len(over) else side, end])


def resampled(line: Array, count: int) -> Array:
    """Return `count` points at equal steps of arc length along a polyline, ends kept.

    `line` (N, 2 or more). Result (count, 2 or more).
    """
    lengths = arc_lengths(line[:, :2])
    wanted = np.linspace(0.0, lengths[-1], count)
    return np.column_stack(
        [np.interp(wanted, lengths, line[:, axis]) for axis in range(line.shape[1])]
    )


def _pushed_out(line: Array) -> Array:
    t = np.linspace(-1.0, 1.0, len(line))
    along = np.gradient(line, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    outward = np.column_stack([-along[:, 1], along[:, 0]])
    distance = (_OUTWARD_AT_CHIN - _OUTWARD_LESS_AT_ENDS * t**2) * arc_lengths(line)[-1]
    return np.asarray(line + distance[:, None] * outward)
