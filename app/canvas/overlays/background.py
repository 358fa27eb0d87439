"""Overlays of the background: straight lines with their bend, and people."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QImage, QPainter, QPainterPath

from kogao_core.background.lines import SEEN_PX, BentLine
from kogao_core.base.display import Rgb8
from kogao_core.base.language import Text

from ...i18n import tr
from ...render.pictures import qt_image
from . import glyphs
from .overlay import Overlay, Place

_DASHED: Final = Qt.PenStyle.DashLine
_TICK_PX: Final = 5.0
_BESIDE: Final = QPointF(8.0, 0.0)
_OPACITY: Final = 0.45


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


class People(Overlay):
    """A tint over people, with an outline."""

    name = "people"
    title = Text("People")
    height = 25
    key = "U"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        """Draw head and shoulders."""
        middle = box.center()
        person = QPainterPath()
        person.addEllipse(middle - QPointF(0.0, 3.0), 3.5, 3.5)
        person.addRoundedRect(QRectF(middle.x() - 6.0, middle.y() + 1.5, 12.0, 6.0), 3.0, 3.0)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.fillPath(person, glyphs.PERSON)

    _drawn: Rgb8 | None = None
    _image = QImage()

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the tint, from the cache if the mask is the same; draw nothing before detection."""
        people = self.shown.people
        if people is None:
            return
        if people is not self._drawn:
            self._drawn, self._image = people, tinted(people)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.drawImage(place.box(self.shown.image), self._image)


def tinted(people: Rgb8) -> QImage:
    """Return the tint of a mask, shape (H, W), 0 to 255, with an outline at 50 % confidence."""
    shades = np.empty((*people.shape, 4), np.uint8)
    colour = glyphs.PERSON
    shades[...] = (colour.red(), colour.green(), colour.blue(), 0)
    shades[..., 3] = _OPACITY * people
    # The outline is light inside and dark outside: visible on any ground and without colours.
    here = (people > 127).astype(np.uint8)
    round_it = np.ones((3, 3), np.uint8)
    edge = glyphs.light(colour)
    inner = (edge.red(), edge.green(), edge.blue(), 255)
    shades[here > cv2.erode(here, round_it)] = inner
    shades[here < cv2.dilate(here, round_it)] = (0, 0, 0, glyphs.CASE.alpha())
    return qt_image(shades).convertToFormat(QImage.Format.Format_ARGB32_Premultiplied)
