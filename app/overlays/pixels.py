"""The borders of single pixels, where they are large enough on screen."""

from __future__ import annotations

from typing import Final

import numpy as np
from PySide6.QtCore import QLineF
from PySide6.QtGui import QColor, QPainter, QPen

from .base import Overlay, Place

FROM_ZOOM: Final = 8.0  # screen px per photo px
# Grey half seen through darkens light pixels and lightens dark ones.
_GREY: Final = QColor(128, 128, 128, 110)


class PixelGrid(Overlay):
    """Thin lines between the pixels of the photo, half way between their centres."""

    def wanted(self) -> bool:
        """Show it where the zoom is high enough, as `draw` knows, unless everything is hidden."""
        return bool(self.shown.visible)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the lines on screen."""
        if place.zoom < FROM_ZOOM:
            return
        image, (low, high) = self.shown.image, place.seen
        first = np.maximum(np.floor(low), (image.left, image.top)).astype(int) - 0.5
        last = np.minimum(np.ceil(high) + 1, (image.right, image.bottom)).astype(int) - 0.5
        (left, top), (right, bottom) = (p.toTuple() for p in place.points([first, last]))
        xs = place.to_screen([(x, 0.0) for x in np.arange(first[0], last[0] + 1)])[..., 0]
        ys = place.to_screen([(0.0, y) for y in np.arange(first[1], last[1] + 1)])[..., 1]
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        painter.setPen(QPen(_GREY, 0))
        upright = [QLineF(x, top, x, bottom) for x in xs.tolist()]
        painter.drawLines([*upright, *(QLineF(left, y, right, y) for y in ys.tolist())])
