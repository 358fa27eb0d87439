"""Point maps: the points of a file that are our outline, eye corners and mouth corners."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.faces.face import OUTLINE_POINTS, Face
from kogao_core.faces.landmarks.outline import resampled

SOURCE: Final = "points"
_STEPS: Final = 16  # straight pieces between two points of an outline


@dataclass(frozen=True, slots=True)
class PointMap:
    """Point numbers from 0, in the order of `Face`."""

    outline: tuple[int, ...]
    eyes: tuple[int, ...]
    mouth: tuple[int, ...]

    def face(self, points: Array) -> Face:
        """Return the face in the points (N, 2) of a file, with 21 outline points. Raises BadFile.

        Every map but `OWN` spaces the outline points evenly.
        """
        line = points[list(self.outline)]
        if self != OWN:
            line = along(line, OUTLINE_POINTS)
        if not np.linalg.norm(np.diff(line, axis=0), axis=1).all():
            raise BadFile(Text("two neighbouring points of the outline are equal"))
        return Face(line, points[list(self.eyes)], points[list(self.mouth)], source=SOURCE)


OWN: Final = PointMap(tuple(range(21)), (21, 22, 23, 24), (25, 26))
_IBUG: Final = PointMap(tuple(range(17)), (36, 39, 42, 45), (48, 54))
_BY_COUNT: Final = {27: OWN, 68: _IBUG}


def own_points(face: Face) -> Array:
    """Return our 27 points of a face, shape (27, 2). Resamples outlines of other lengths."""
    outline = face.outline
    if len(outline) != OUTLINE_POINTS:
        outline = along(outline, OUTLINE_POINTS)
    return np.vstack([outline, face.eyes, face.mouth])


def default_map(points: Array) -> PointMap:
    """Return the map for the number of points: 27 (ours) or 68 (iBUG, dlib). Raises BadFile."""
    count = len(points)
    if count not in _BY_COUNT:
        raise BadFile(
            Text(
                "the file has {count} points instead of 27 or 68 (docs/interchange.md)",
                count=count,
            )
        )
    return _BY_COUNT[count]


def along(line: Array, count: int) -> Array:
    """Return `count` evenly spaced points on the Catmull-Rom curve through a line (N, 2), N >= 2.

    Result (count, 2), with both ends of the line. Straight pieces would cut every bend: on an oval
    face, 21 points to 17 and back lose 1.5 % of the distance between the eyes.
    """
    ends = 2.0 * line[[0, -1]] - line[[1, -2]]
    around = np.vstack([ends[:1], line, ends[1:]])
    before, first, last, after = (around[k : len(around) - 3 + k, None] for k in range(4))
    t = (np.arange(_STEPS) / _STEPS)[:, None]
    pieces = first + t / 2.0 * (
        last - before
        + t * (2.0 * before - 5.0 * first + 4.0 * last - after)
        + t**2 * (3.0 * (first - last) + after - before)
    )  # fmt: skip
    return resampled(np.vstack([pieces.reshape(-1, 2), line[-1:]]), count)
