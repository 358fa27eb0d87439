"""The overlay of straight lines in the background, with their bend."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter

from kogao_core.background.lines import SEEN_PX, BentLine
from kogao_core.base.language import Text

from ...i18n import tr
from . import glyphs
from .overlay import Overlay, Place

_DASHED: Final = Qt.PenStyle.DashLine
_TICK_PX: Final = 5.0
_BESIDE: Final = QPointF(8.0, 0.0)


class BentLines(Overlay):
    """Straight lines of the background; bent lines are thick and labelled with the bend in px.

    Lines that only the constraint keeps straight are thick, too. Released lines are dashed.
    """

    name = "straight"
    title = Text("Straight lines and their bend")
    height = 70
    key = "S"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        """Draw a slanted line."""
        slant = (box.left() + 3, box.bottom() - 4), (box.right() - 3, box.top() + 4)
        glyphs.lines(painter, [slant], glyphs.BENT, 2.4)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the lines, the most bent lines on top."""
        for line in reversed(self.shown.lines):
            chord = place.to_screen([line.start_px, line.end_px])
            drawn = [chord, *glyphs.ticks(chord, chord, _TICK_PX)]
            is_bent, would_bend = line.bend_px >= SEEN_PX, line.unheld_px >= SEEN_PX
            colour = glyphs.BENT if is_bent else glyphs.STRAIGHT
            style = _DASHED if line.holding == "let go" else Qt.PenStyle.SolidLine
            width = 2.4 if would_bend or is_bent else glyphs.WIDTH_PX
            glyphs.lines(painter, drawn, colour, width, style=style)
            if not is_bent:
                continue
            middle, text = QPointF(*chord.mean(axis=0)), _words(line)
            within = place.viewport if place.viewport.contains(middle) else None
            glyphs.label(painter, middle + _BESIDE, text, bold=True, within=within)


def _words(line: BentLine) -> str:
    """Return the bend of a line, and the bend without constraints if the line gave way."""
    if line.holding == "gave way":
        return tr("gives way: {px:.1f} of {all:.1f} px", px=line.bend_px, all=line.unheld_px)
    return tr("{px:.1f} px", px=line.bend_px)
