"""The overlay of straight lines in the background, with their turn."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter

from kogao_core.background.lines import SEEN_DEGREES, BackgroundLine
from kogao_core.base.language import Text

from ...i18n import tr
from . import glyphs
from .overlay import Overlay, Place

_DASHED: Final = Qt.PenStyle.DashLine
_TICK_PX: Final = 5.0
_BESIDE: Final = QPointF(8.0, 0.0)


class TurnedLines(Overlay):
    """Straight lines of the background; turned lines are thick and labelled with degrees.

    Lines that only the constraint keeps from turning are thick, too. Released lines are dashed.
    """

    name = "straight"
    title = Text("Straight lines and their turn")
    height = 70
    key = "S"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        slant = (box.left() + 3, box.bottom() - 4), (box.right() - 3, box.top() + 4)
        glyphs.lines(painter, [slant], glyphs.TURNED, 2.4)

    def draw(self, painter: QPainter, place: Place) -> None:
        for line in reversed(self.shown.lines):
            chord = place.to_screen([line.start_px, line.end_px])
            drawn = [chord, *glyphs.ticks(chord, chord, _TICK_PX)]
            is_turned = line.turn_degrees >= SEEN_DEGREES
            would_turn = line.unheld_turn_degrees >= SEEN_DEGREES
            colour = glyphs.TURNED if is_turned else glyphs.STRAIGHT
            style = _DASHED if line.holding == "let go" else Qt.PenStyle.SolidLine
            width = 2.4 if would_turn or is_turned else glyphs.WIDTH_PX
            glyphs.lines(painter, drawn, colour, width, style=style)
            if not is_turned:
                continue
            middle, text = QPointF(*chord.mean(axis=0)), _words(line)
            within = place.viewport if place.viewport.contains(middle) else None
            glyphs.label(painter, middle + _BESIDE, text, bold=True, within=within)


def _words(line: BackgroundLine) -> str:
    """Return the turn of a line, and the turn without constraints if the line gave way."""
    if line.holding == "gave way":
        turns = line.turn_degrees, line.unheld_turn_degrees
        return tr("gives way: {now:.1f} of {all:.1f}°", now=turns[0], all=turns[1])
    return tr("{degrees:.1f}°", degrees=line.turn_degrees)
