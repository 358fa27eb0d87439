"""Which face is which: their numbers, once there is more than one."""

from __future__ import annotations

from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainter

from ..i18n import tr
from . import glyphs
from .base import Overlay, Place


class FaceNumbers(Overlay):
    """A number over each face; the one whose settings are edited is bold and has a dot."""

    def wanted(self) -> bool:
        """Show it together with the landmarks, where there is something to tell apart."""
        return "landmarks" in self.shown.visible and len(self.shown.state.faces) > 1

    def draw(self, painter: QPainter, place: Place) -> None:
        """Write the numbers above the faces' topmost landmarks."""
        for index, face in enumerate(self.shown.state.faces):
            left, top, width, _ = face.box
            (at,) = place.points([(left + width / 2, top)])
            chosen = index == self.shown.face
            text = tr("● Face {n}", n=index + 1) if chosen else str(index + 1)
            glyphs.label(painter, at - QPointF(8, 20), text, bold=chosen)
