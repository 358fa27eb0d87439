"""Face boxes without the networks: OpenCV's own Haar cascade, at a few angles."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Affine
from kogao_core.faces.landmarks.blazeface import INPUT_PX, Detection, Square
from kogao_core.faces.landmarks.pixels import Pyramid

_CASCADE: Final = "haarcascade_frontalface_alt2.xml"
_LOOK_PX: Final = 512
_LEAST_FACE_PX: Final = 24
# Upright first; the cascade itself stands about 15 degrees of tilt.
_TURNS: Final = (0.0, 30.0, -30.0, 90.0, -90.0, 180.0)
# From the cascade's squares to BlazeFace's, measured on the shared photographs.
_SIDE, _DOWN = 0.89, 0.12


class HaarFaces:
    """The cascade that travels with OpenCV; not thread-safe."""

    def __init__(self) -> None:
        folder = Path(cv2.__file__).parent / "data"
        self._cascade = cv2.CascadeClassifier(str(folder / _CASCADE))

    def boxes(self, picture: Pyramid) -> Iterator[list[Detection]]:
        """Return boxes without keypoints, for one angle after the other, upright first."""
        center = np.array([picture.width - 1.0, picture.height - 1.0]) / 2.0
        side = float(np.hypot(picture.width, picture.height))
        for degrees in _TURNS:
            yield self._boxes(picture, Square(center, side, degrees))

    def _boxes(self, picture: Pyramid, view: Square) -> list[Detection]:
        to_image = view.to_image.after(Affine.resize(INPUT_PX / _LOOK_PX, INPUT_PX / _LOOK_PX))
        grey = cv2.cvtColor(picture.sample(to_image, _LOOK_PX), cv2.COLOR_RGB2GRAY)
        found = self._cascade.detectMultiScale(grey, minSize=(_LEAST_FACE_PX, _LEAST_FACE_PX))
        return [
            Detection(
                to_image((x + width / 2.0 - 0.5, y + (0.5 + _DOWN) * width - 0.5)),
                _SIDE * width * to_image.scale,
                view.degrees,
                score=1.0,
            )
            for x, y, width, _ in sorted(map(tuple, found), key=lambda box: -box[2])
        ]
