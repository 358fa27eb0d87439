"""Door frames and shelves near the face, and how far the warp bends each of them."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QLineF, QPointF, QRectF
from PySide6.QtGui import QPainter

from ...i18n import tr
from . import glyphs
from .overlay import Overlay, Place

# Half a pixel is where a bend in a straight edge begins to be seen.
SEEN_PX: Final = 0.5
_TICK_PX: Final = 5.0
_BESIDE: Final = QPointF(8.0, 0.0)


class BentLines(Overlay):
    """Thin lines with ticks at their ends; bent ones thick, in another colour, with their px."""

    name = "straight"
    height = 70
    key = "S"

    @classmethod
    def title(cls) -> str:
        """Return what the panel calls it."""
        return tr("Straight lines and their bend")

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        """Draw its mark."""
        slant = QLineF(box.left() + 3, box.bottom() - 4, box.right() - 3, box.top() + 4)
        glyphs.lines(painter, [slant], glyphs.BENT, 2.4)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the most bent ones last, over the others."""
        for line in reversed(self.shown.lines):
            start, end = place.points([line.start_px, line.end_px])
            chord = QLineF(start, end)
            across = chord.normalVector().unitVector()
            tick = QPointF(across.dx(), across.dy()) * _TICK_PX
            ticks = [QLineF(at - tick, at + tick) for at in (start, end)]
            if line.bend_px < SEEN_PX:
                glyphs.lines(painter, [chord, *ticks], glyphs.STRAIGHT, 1.0)
                continue
            glyphs.lines(painter, [chord, *ticks], glyphs.BENT, 2.4)
            middle, text = chord.center(), tr("{px:.1f} px", px=line.bend_px)
            within = place.viewport if place.viewport.contains(middle) else None
            glyphs.label(painter, middle + _BESIDE, text, bold=True, within=within)
