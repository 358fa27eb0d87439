"""How far outside a photo anything may lie, and how much may be asked for at once.

Each number alone says little: a face may be as large as the photo, a lattice may be fine, and a
photo may hold a hundred faces. It is their product that fills the memory, so it is bounded here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from kogao_core.base.geometry import Array, Box
from kogao_core.base.language import Text

if TYPE_CHECKING:
    from kogao_core.faces.face import Face
    from kogao_core.warp.brush import Brushwork
    from kogao_core.warp.protection import Protection

# Control points of all faces together, at the finest lattice that is looked at.
MOST_CONTROL_POINTS: Final = 2**20
# Landmarks and protected places that are solved for at once, where lattices reach into each other:
# 230 faces that all touch.
MOST_TOGETHER: Final = 5000
# Faces whose middles lie on one another: that is nobody's photo, and solving for them takes longer
# than for as many that merely touch.
MOST_ON_ONE: Final = 20
_ON_ONE: Final = 0.25  # of a face's size
# Places along and across a protected stroke, near one face.
MOST_SAMPLES: Final = 2**20
# Corners of all protected lines together.
MOST_CORNERS: Final = 10_000
# Places along all strokes of push and restore together, eight to a radius.
MOST_BRUSH_STEPS: Final = 2**15
# On a photo that is smaller, a stroke may still be as wide as the editor's largest brush.
WIDEST_PX: Final = 1024.0
# Landmarks of all faces in one file.
MOST_LANDMARKS: Final = 50_000


class OutOfBounds(ValueError):
    """Something lies far from the photo, or too much is asked for; the message names it."""


def check_faces(faces: Sequence[Face], image: Box, *, typed: bool = False) -> None:
    """Check that landmarks and targets lie on a photo, or not far outside. Raises OutOfBounds."""
    for number, face in enumerate(faces, start=1):
        room = size_px(face) if typed else max(size_px(face), _longer(image))
        _check_near(face.points, image, room, Text("landmark {{}} of face {number}", number=number))
        if face.targets is not None:
            _check_near(
                face.targets, image, room, Text("target {{}} of face {number}", number=number)
            )
    _check_apart(faces)


def _check_apart(faces: Sequence[Face]) -> None:
    """Check that no more than `MOST_ON_ONE` faces lie in one place."""
    middles = np.array([np.median(face.points, axis=0) for face in faces]).reshape(-1, 2)
    for number, face in enumerate(faces, start=1):
        off = middles - middles[number - 1]
        on_it = int((np.hypot(*off.T) < _ON_ONE * size_px(face)).sum())
        if on_it > MOST_ON_ONE:
            raise OutOfBounds(
                Text(
                    "{count} faces lie where face {number} does, and at most {most} are worked on; "
                    "take those away that are there twice",
                    count=on_it,
                    number=number,
                    most=MOST_ON_ONE,
                )
            )


def size_px(face: Face) -> float:
    """Return about how wide a face is; a few landmarks far away don't make it larger, px."""
    from_middle = face.points - np.median(face.points, axis=0)
    return 2.0 * float(np.median(np.hypot(from_middle[:, 0], from_middle[:, 1])))


def check_protection(protection: Protection, image: Box) -> None:
    """Check that protected places lie on a photo or not far outside, and aren't too many.

    Raises OutOfBounds.
    """
    check_corners(protection)
    longer = _longer(image)
    widest = max(longer, WIDEST_PX)
    for number, stroke in enumerate(protection.strokes, start=1):
        _check_near(
            stroke.points_px,
            image,
            longer,
            Text("corner {{}} of protected line {number}", number=number),
        )
        for name, width in (("width", 2.0 * stroke.radius_px), ("feather", stroke.feather_px)):
            if width > widest:
                raise OutOfBounds(
                    Text(
                        "protected line {number} has a {name} of {width:g} px, on a "
                        "photo whose longer side is {longer:g} px; at most "
                        "{widest:g} px are allowed",
                        number=number,
                        name=name,
                        width=width,
                        longer=longer,
                        widest=widest,
                    )
                )


def check_corners(protection: Protection) -> None:
    """Check that protected lines have no more than `MOST_CORNERS` corners together.

    Raises OutOfBounds.
    """
    corners = sum(len(stroke.points_px) for stroke in protection.strokes)
    if corners > MOST_CORNERS:
        raise OutOfBounds(
            Text(
                "the protected lines have {corners} corners together; at most "
                "{most_corners} are allowed: draw them with fewer",
                corners=corners,
                most_corners=MOST_CORNERS,
            )
        )


def check_brushwork(brushwork: Brushwork, image: Box) -> None:
    """Check that strokes of push and restore lie on a photo or not far outside, as `check_strokes`.

    Raises OutOfBounds.
    """
    check_strokes(brushwork)
    longer = _longer(image)
    for number, stroke in enumerate(brushwork.strokes, start=1):
        where = Text("corner {{}} of brush stroke {number}", number=number)
        _check_near(stroke.points_px, image, longer, where)
        if stroke.radius_px > max(longer, WIDEST_PX):
            raise OutOfBounds(Text("brush stroke {number} is wider than the photo", number=number))


def check_strokes(brushwork: Brushwork) -> None:
    """Check that strokes of push and restore ask for no more than can be worked on.

    Raises OutOfBounds.
    """
    steps, nodes = 0, 0.0
    for stroke in brushwork.strokes:
        steps += int(stroke.steps.sum())
        sides = np.ptp(stroke.points_px, axis=0) + 2.0 * stroke.radius_px
        nodes += float(np.prod(sides / stroke.spacing_px))
    if steps > MOST_BRUSH_STEPS or nodes > MOST_CONTROL_POINTS:
        raise OutOfBounds(
            Text(
                "the strokes of push and restore are too long for so small a brush; draw shorter "
                "ones, or take a larger brush"
            )
        )


def _longer(image: Box) -> float:
    return float(max(image.width, image.height))


def _check_near(points: Array, image: Box, room_px: float, name: str) -> None:
    """Check points of shape (N, 2); rows of NaN lie nowhere and are left out."""
    low = np.array([image.left, image.top]) - room_px
    high = np.array([image.right - 1, image.bottom - 1]) + room_px
    far = np.flatnonzero(((points < low) | (points > high)).any(axis=1))
    if len(far):
        x, y = points[far[0]].tolist()
        raise OutOfBounds(
            Text(
                "{format} lies at {x:g}, {y:g}, far outside the photo, which ends at "
                "{right}, {bottom}; correct it",
                format=name.format(far[0] + 1),
                x=x,
                y=y,
                right=image.right - 1,
                bottom=image.bottom - 1,
            )
        )
