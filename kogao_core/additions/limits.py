"""Check that faces and strokes lie near the photo, and limit memory and time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from kogao_core.base.geometry import Array, Box
from kogao_core.base.language import Text, TextError

if TYPE_CHECKING:
    from kogao_core.additions.brush import Brushwork
    from kogao_core.faces.face import Face
    from kogao_core.field.protection import Protection

# Control points of all faces together, on the finest lattice.
MOST_CONTROL_POINTS: Final = 2**20
# Landmarks of one system of equations: 230 faces whose lattices overlap.
MOST_TOGETHER: Final = 5000
# Faces in one place. Solving for these takes longer than for faces side by side.
MOST_ON_ONE: Final = 20
_ON_ONE: Final = 0.25  # largest distance of their middles, in sizes of a face
# Corners of all protected strokes together.
MOST_CORNERS: Final = 10_000
# Steps along all strokes of push and restore together; a radius has eight.
MOST_BRUSH_STEPS: Final = 2**15
# A stroke may be as wide as the editor's largest brush on any photo.
WIDEST_PX: Final = 1024.0
# Landmarks of all faces in one file.
MOST_LANDMARKS: Final = 50_000


class OutOfBounds(TextError, ValueError):
    """A point lies far outside the photo, or a limit of size is exceeded."""


def check_faces(faces: Sequence[Face], image: Box, *, typed: bool = False) -> None:
    """Check that landmarks and targets lie on or near a photo. Raises OutOfBounds."""
    for number, face in enumerate(faces, start=1):
        room = size_px(face) if typed else max(size_px(face), float(max(image.width, image.height)))
        _check_near(face.points, image, room, Text("landmark {{}} of face {number}", number=number))
        if face.targets is not None:
            _check_near(
                face.targets, image, room, Text("target {{}} of face {number}", number=number)
            )
    _check_apart(faces)


def _check_apart(faces: Sequence[Face]) -> None:
    """Check that at most `MOST_ON_ONE` faces lie in one place."""
    middles = np.array([np.median(face.points, axis=0) for face in faces]).reshape(-1, 2)
    for number, face in enumerate(faces, start=1):
        off = middles - middles[number - 1]
        on_it = int((np.hypot(*off.T) < _ON_ONE * size_px(face)).sum())
        if on_it > MOST_ON_ONE:
            raise OutOfBounds(
                "{count} faces lie where face {number} does, and at most {most} are worked on; "
                "take those away that are there twice",
                count=on_it,
                number=number,
                most=MOST_ON_ONE,
            )


def size_px(face: Face) -> float:
    """Return the approximate width of a face, px. A few distant landmarks have no effect."""
    from_middle = face.points - np.median(face.points, axis=0)
    return 2.0 * float(np.median(np.hypot(from_middle[:, 0], from_middle[:, 1])))


def check_protection(protection: Protection, image: Box) -> None:
    """Check position, width and number of protected strokes. Raises OutOfBounds."""
    check_corners(protection)
    longer = float(max(image.width, image.height))
    widest = max(longer, WIDEST_PX)
    for number, stroke in enumerate(protection.drawn, start=1):
        _check_near(
            stroke.points_px,
            image,
            longer,
            Text("corner {{}} of protected line {number}", number=number),
        )
        if 2.0 * stroke.radius_px > widest:
            raise OutOfBounds(
                "protected line {number} is wider than {px:g} px; use a narrower line",
                number=number,
                px=widest,
            )


def check_corners(protection: Protection) -> None:
    """Check that strokes have at most `MOST_CORNERS` corners in all. Raises OutOfBounds."""
    corners = sum(len(stroke.points_px) for stroke in protection.drawn)
    if corners > MOST_CORNERS:
        raise OutOfBounds(
            "the protected lines have {corners} corners together; at most "
            "{most_corners} are allowed: draw them with fewer",
            corners=corners,
            most_corners=MOST_CORNERS,
        )


def check_brushwork(brushwork: Brushwork, image: Box) -> None:
    """Check position, width and size of strokes of push and restore. Raises OutOfBounds."""
    check_strokes(brushwork)
    longer = float(max(image.width, image.height))
    for number, stroke in enumerate(brushwork.strokes, start=1):
        where = Text("corner {{}} of brush stroke {number}", number=number)
        _check_near(stroke.points_px, image, longer, where)
        if stroke.radius_px > max(longer, WIDEST_PX):
            raise OutOfBounds("brush stroke {number} is wider than the photo", number=number)


def check_strokes(brushwork: Brushwork) -> None:
    """Check the length of strokes of push and restore. Raises OutOfBounds."""
    steps, nodes = 0, 0.0
    for stroke in brushwork.strokes:
        steps += int(stroke.steps.sum())
        sides = np.ptp(stroke.points_px, axis=0) + 2.0 * stroke.radius_px
        nodes += float(np.prod(sides / stroke.spacing_px))
    if steps > MOST_BRUSH_STEPS or nodes > MOST_CONTROL_POINTS:
        raise OutOfBounds(
            "the strokes of push and restore are too long for so small a brush; draw shorter "
            "ones, or take a larger brush"
        )


def _check_near(points: Array, image: Box, room_px: float, name: str) -> None:
    """Check points (N, 2) and skip rows of NaN. Raises OutOfBounds."""
    low = np.array([image.left, image.top]) - room_px
    high = np.array([image.right - 1, image.bottom - 1]) + room_px
    far = np.flatnonzero(((points < low) | (points > high)).any(axis=1))
    if len(far):
        x, y = points[far[0]].tolist()
        raise OutOfBounds(
            "{format} lies at {x:g}, {y:g}, far outside the photo, which ends at "
            "{right}, {bottom}; correct it",
            format=name.format(far[0] + 1),
            x=x,
            y=y,
            right=image.right - 1,
            bottom=image.bottom - 1,
        )
