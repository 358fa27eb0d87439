"""Recognise photos in the form of an identity document, which must not be retouched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np

from kogao_core.base.display import Rgb8, rgb8
from kogao_core.base.geometry import Image, degrees_of
from kogao_core.base.language import Text
from kogao_core.faces.face import Face

# Width / height of 35 x 45 mm, 2 x 2 inch, 50 x 70 mm and 33 x 48 mm.
_SHAPES: Final = (35 / 45, 1.0, 50 / 70, 33 / 48)
_SHAPE_TOLERANCE: Final = 0.01  # of width / height
_HEAD: Final = 2.05  # head height from crown to chin, in distances from eyes to chin
_HEAD_SHARE: Final = (0.5, 0.85)  # head height / photo height that the rules of many states ask for
_OFF_CENTRE: Final = 0.04  # largest distance of the face from the middle, of the photo width
_TILT_DEGREES: Final = 3.0  # largest roll of the line between the eyes
_CORNER: Final = (0.3, 0.12)  # height and width of the two upper corners, of the photo
_PLAIN: Final = 6.0  # largest standard deviation of a corner, of 255
_LIGHT: Final = 150.0  # least mean of a corner, of 255
NOTE: Final = Text("this looks like a passport photo; passport rules forbid changed faces")


def note(photo: Image, faces: Sequence[Face]) -> str:
    """Return a note if a photo has the form of an identity document, otherwise ""."""
    height, width = photo.shape[:2]
    if len(faces) != 1 or not np.isclose(width / height, _SHAPES, atol=_SHAPE_TOLERANCE).any():
        return ""
    (face,) = faces
    chin = face.outline[len(face.outline) // 2]
    head = _HEAD * float(np.hypot(*(chin - face.eye_center))) / height
    corner = slice(0, round(_CORNER[0] * height))
    side = max(1, round(_CORNER[1] * width))
    corners = [rgb8(photo[corner, :side]), rgb8(photo[corner, -side:])]
    fits = (
        _HEAD_SHARE[0] <= head <= _HEAD_SHARE[1]
        and abs(face.middle[0] - width / 2) <= _OFF_CENTRE * width
        and abs(degrees_of(face.eyes[3] - face.eyes[0])) <= _TILT_DEGREES
        and all(_is_plain_and_light(one) for one in corners)
    )
    return NOTE if fits else ""


def _is_plain_and_light(corner: Rgb8) -> bool:
    mean, spread = cv2.meanStdDev(corner)
    return bool(spread.max() <= _PLAIN and mean.mean() >= _LIGHT)
