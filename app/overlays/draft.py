"""The points of a face that is being marked and isn't one yet."""

from __future__ import annotations

from PySide6.QtCore import QLineF
from PySide6.QtGui import QPainter

from ..marking import CORNERS
from . import glyphs
from .base import Overlay, Place


class Draft(Overlay):
    """Diamonds for the corners of eyes and mouth, dots and rings for the first landmarks."""

    def wanted(self) -> bool:
        """Show it in manual mode, whatever is switched on."""
        scene = self.shown
        return scene.state.mode == "manual" and (bool(scene.state.draft) or scene.marking)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw what has been marked so far, and where the next mark would be set."""
        for number, (source, target) in enumerate(self.shown.state.draft):
            at, to = place.points([source, target])
            if number < CORNERS:
                glyphs.diamond(painter, at, glyphs.LANDMARK)
                continue
            glyphs.dot(painter, at, glyphs.LANDMARK)
            glyphs.lines(painter, [QLineF(at, to)], glyphs.TARGET, 1.0)
            glyphs.ring(painter, to, glyphs.TARGET)
        if self.shown.marking and self.shown.cursor is not None:
            glyphs.cross(painter, place.points(self.shown.cursor)[0], glyphs.LANDMARK)
