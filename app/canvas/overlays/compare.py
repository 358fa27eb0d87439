"""What comparing draws over the photo: the divider, what each side is, and the loupe."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen, QTransform

from ...i18n import tr
from ...view_state import GAIN, ViewState
from . import glyphs
from .overlay import Overlay, Place

if TYPE_CHECKING:
    from ..photo_layer import PhotoItem

KNOB_PX: Final = 14.0
_LOUPE_PX: Final = 96.0
_MAGNIFIED: Final = 4.0
_TOP_PX: Final = 20.0


class Divider(Overlay):
    """The line between before and after, with a knob to drag, or what else is compared."""

    height = 160

    def draw(self, painter: QPainter, place: Place) -> None:
        """Name what is seen, at the top, while comparing; the photo as it was needs no name."""
        if self.shown.compare == "off" or self.shown.original:
            return
        area = place.viewport
        if self.shown.compare != "wipe":
            glyphs.label(painter, area.topLeft() + QPointF(_TOP_PX, _TOP_PX), self._text())
            return
        x = area.left() + round(self.shown.wipe * area.width())
        line = (x, area.top()), (x, area.bottom())
        glyphs.lines(painter, [line], glyphs.HALO)
        painter.setPen(QPen(glyphs.CASE, 1.6))
        painter.setBrush(glyphs.HALO)
        middle = QPointF(x, area.center().y())
        painter.drawEllipse(middle, KNOB_PX, KNOB_PX)
        painter.setPen(QPen(QColor(0, 0, 0), 1.8))
        for side in (-1.0, 1.0):
            tip = middle + QPointF(side * 9.0, 0.0)
            for dy in (-4.0, 4.0):
                painter.drawLine(tip, tip + QPointF(-side * 4.0, dy))
        width = painter.fontMetrics().horizontalAdvance(tr("before")) + 8
        glyphs.label(painter, QPointF(x - 10 - width, area.top() + _TOP_PX), tr("before"))
        glyphs.label(painter, QPointF(x + 10, area.top() + _TOP_PX), tr("after"))

    def _text(self) -> str:
        if self.shown.compare == "side":
            return tr("after")
        return tr("difference, {n} × as strong", n=GAIN)  # noqa: RUF001


class Loupe(Overlay):
    """What lies under the cursor, magnified: before in the left half, after in the right one."""

    height = 180

    def __init__(self, view: ViewState, photo: PhotoItem) -> None:
        super().__init__(view)
        self._photo = photo

    def draw(self, painter: QPainter, place: Place) -> None:
        """Paint both halves, then the rim over their edges, where the cursor is over the photo."""
        if not self.shown.loupe or self.shown.cursor is None or self.shown.original:
            return
        x, y = self.shown.cursor.tolist()
        (at,) = place.points([(x, y)])
        round_it = QRectF(at.x() - _LOUPE_PX, at.y() - _LOUPE_PX, 2 * _LOUPE_PX, 2 * _LOUPE_PX)
        zoom = _MAGNIFIED * place.zoom
        magnified = QTransform(zoom, 0.0, 0.0, zoom, at.x() - zoom * x, at.y() - zoom * y)
        right = QRectF(at.x(), round_it.top(), _LOUPE_PX, round_it.height())
        left = right.translated(-_LOUPE_PX, 0.0)
        for half, draw in ((left, self._photo.draw_original), (right, self._photo.draw_result)):
            disc, side = QPainterPath(), QPainterPath()
            disc.addEllipse(round_it)
            side.addRect(half)
            painter.save()
            painter.setClipPath(disc & side)
            painter.fillRect(half, QColor(0, 0, 0))
            painter.setWorldTransform(magnified)
            draw(painter)
            painter.restore()
        middle = (at.x(), round_it.top()), (at.x(), round_it.bottom())
        glyphs.lines(painter, [middle], glyphs.HALO, 1.0)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for pen in (QPen(glyphs.CASE, 5.0), QPen(glyphs.HALO, 2.0)):
            painter.setPen(pen)
            painter.drawEllipse(round_it)
