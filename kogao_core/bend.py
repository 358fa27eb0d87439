"""Door frames and shelves near a face: how far does the warp bend straight lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np

from kogao_core.field import Field, shown_at
from kogao_core.geometry import Array, Box, Image

_SHORTEST: Final = 0.04  # of the photo's longer side; shorter lines are texture
_SAMPLES: Final = 64
_DETECTOR_PX: Final = 1600  # longer side of what the detector sees: finer is noise, and slow


@dataclass(frozen=True, slots=True)
class BentLine:
    """A straight line of the photo.

    Parameters
    ----------
    start_px, end_px : tuple of float
        Where it runs in the photo (x, y).
    bend_px : float
        How far it departs from a straight line after the warp, px.
    """

    start_px: tuple[float, float]
    end_px: tuple[float, float]
    bend_px: float


def straight_lines(photo: Image, near: Box) -> Array:
    """Find straight lines of the photo that touch `near`.

    Parameters
    ----------
    photo : array of shape (H, W) or (H, W, C)
        The photo before the warp.
    near : Box
        The warp domain, or any other box; px.

    Returns
    -------
    array of shape (N, 2, 2)
        Ends (x, y) of each line, px.

    Examples
    --------
    >>> import numpy as np
    >>> from kogao_core.bend import straight_lines
    >>> from kogao_core.geometry import Box
    >>> photo = np.zeros((200, 300), np.uint8)
    >>> photo[:, 150:] = 255  # an edge
    >>> len(straight_lines(photo, Box.of(photo))) > 0
    True
    """
    box = near.grown(max(near.width, near.height) // 4).clipped(Box.of(photo))
    if box.width < 2 or box.height < 2:
        return np.zeros((0, 2, 2))
    grey = _grey(photo[box.slices])
    scale = min(1.0, _DETECTOR_PX / max(grey.shape))
    small = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    shortest = max(10, int(_SHORTEST * max(photo.shape[:2]) * scale))
    detector = cv2.ximgproc.createFastLineDetector(length_threshold=shortest, do_merge=True)
    found: Any = detector.detect(small)  # None when there is no line
    if found is None:
        return np.zeros((0, 2, 2))
    ends = (found.reshape(-1, 2, 2).astype(np.float64) + 0.5) / scale - 0.5
    return np.asarray(ends + np.array([box.left, box.top]))


def beside(lines: Array, outlines: Sequence[Array]) -> Array:
    """Drop lines of shape (N, 2, 2) whose middle lies on a face: brows and lips are meant to move.

    Parameters
    ----------
    lines : array of shape (N, 2, 2)
        Ends (x, y) of each line, px.
    outlines : sequence of arrays of shape (M, 2)
        Outline of each face, px.

    Returns
    -------
    array of shape (K, 2, 2)
        The lines that are left.

    Examples
    --------
    >>> import numpy as np
    >>> from kogao_core.bend import beside
    >>> lines = np.array([[(0, 5), (10, 5)], [(50, 5), (60, 5)]], np.float64)
    >>> beside(lines, [np.array([(0, 0), (10, 0), (10, 10), (0, 10)])]).tolist()
    [[[50.0, 5.0], [60.0, 5.0]]]
    """
    hulls = [cv2.convexHull(outline.astype(np.float32)) for outline in outlines]
    apart = [
        all(cv2.pointPolygonTest(hull, middle, measureDist=False) < 0 for hull in hulls)
        for middle in lines.mean(axis=1).tolist()
    ]
    return np.asarray(lines[np.array(apart, bool)])


def bends(field: Field, lines: Array) -> list[BentLine]:
    """Measure how far lines depart from straight after the warp.

    Parameters
    ----------
    field : Field
        Of all faces.
    lines : array of shape (N, 2, 2)
        Ends (x, y) of each line in the photo, px.

    Returns
    -------
    list of BentLine
        The most bent first.

    Examples
    --------
    >>> import numpy as np
    >>> import kogao_core as kogao
    >>> from kogao_core.bend import bends
    >>> face = kogao.template_face((240, 180), 200)
    >>> field = kogao.render(np.zeros((360, 480), np.uint8), [face], kogao.Recipe(percent=6)).field
    >>> near, far = bends(field, np.array([[(0, 5), (30, 5)], [(340, 90), (340, 270)]]))
    >>> near.start_px, far.bend_px
    ((340.0, 90.0), 0.0)
    """
    t = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    along = lines[:, :1] + t * (lines[:, 1:] - lines[:, :1])
    shown = shown_at(field, along.reshape(-1, 2)).reshape(along.shape)
    measured = [
        BentLine(
            (float(start[0]), float(start[1])), (float(end[0]), float(end[1])), _departure(one)
        )
        for (start, end), one in zip(lines, shown, strict=True)
    ]
    return sorted(measured, key=lambda line: -line.bend_px)


def _departure(points: Array) -> float:
    """Return the distance of the farthest point from the least-squares line through them."""
    offsets = points - points.mean(axis=0)
    _, _, directions = np.linalg.svd(offsets, full_matrices=False)
    return float(np.abs(offsets @ directions[1]).max())


def _grey(pixels: Image) -> Image:
    depth = 1.0 if pixels.dtype == np.float32 else float(np.iinfo(pixels.dtype).max)
    unit = pixels.astype(np.float32) / depth
    if unit.ndim == 3:
        unit = unit[..., : 3 if unit.shape[2] >= 3 else 1].mean(axis=2)
    return np.asarray(np.clip(255.0 * unit, 0, 255), np.uint8)
