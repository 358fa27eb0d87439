"""Protected places as a hatch, and the ring of the brush under the cursor."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPainterPath, QPainterPathStroker, QPen, QTransform

from kogao_core.base.language import Text
from kogao_core.warp.protection import NOTHING, Protection, Stroke

from ...view_state import ViewState
from . import glyphs
from .overlay import Overlay, Place

_THINNEST_PX: Final = 3.0
_ROUNDNESS: Final = 0.05  # of the radius, the largest error of an outline


class Protected(Overlay):
    """A hatch over every stroke; hard ones have a firm edge and show their feather, dashed."""

    name = "protection"
    title = Text("Protected places")
    height = 50
    key = "P"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        """Draw its mark."""
        painter.setPen(QPen(glyphs.HALO, 1.4))
        painter.setBrush(glyphs.protected())
        painter.drawRoundedRect(box.adjusted(2, 4, -2, -4), 5, 5)

    @classmethod
    def is_there(cls, view: ViewState) -> bool:
        """Return whether anything is protected."""
        return bool(view.state.protection.strokes)

    _drawn: Protection = NOTHING
    _shapes: tuple[tuple[Stroke, QPainterPath, QPainterPath], ...] = ()

    def wanted(self) -> bool:
        """Show it also while a tool is in hand that changes it, unless everything is hidden."""
        return super().wanted() or (self.shown.brush.protects and bool(self.shown.visible))

    def draw(self, painter: QPainter, place: Place) -> None:
        """Fill the strokes with one hatch that stays with the photo."""
        self._trace(self.shown.state.protection)
        matrix, (dx, dy) = place.to_screen.matrix, place.to_screen.shift
        to_screen = QTransform(matrix[0, 0], matrix[1, 0], matrix[0, 1], matrix[1, 1], dx, dy)
        painter.setBrushOrigin(QPointF(dx, dy))
        for stroke, core, feathered in self._shapes:
            shape = to_screen.map(core)
            if stroke.radius_px * place.zoom < _THINNEST_PX / 2:
                shape = _outline(place.points(stroke.points_px), _THINNEST_PX / 2)
            painter.fillPath(shape, glyphs.protected())
            hard = stroke.feather_px > 0.0
            style = Qt.PenStyle.SolidLine if hard else Qt.PenStyle.DotLine
            glyphs.outlined(painter, shape, glyphs.HALO, style=style)
            if hard:
                edge = to_screen.map(feathered)
                glyphs.outlined(painter, edge, glyphs.HALO, 1.0, style=Qt.PenStyle.DashLine)

    def _trace(self, protection: Protection) -> None:
        # Outlining a brush stroke takes longer than filling it: once per change, not per paint.
        if protection is self._drawn:
            return
        known = {id(shape[0]): shape for shape in self._shapes}
        self._shapes = tuple(known.get(id(s)) or (s, *_shapes(s)) for s in protection.strokes)
        self._drawn = protection


class BrushRing(Overlay):
    """How large the brush is, round the cursor: where its falloff begins, or the eraser's cross."""

    height = 170

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the ring while a painting tool is over the photo, seen on any ground."""
        if not self.shown.brush.paints or self.shown.cursor is None:
            return
        (at,) = place.points(self.shown.cursor)
        radius = max(2.0, self.shown.brush.radius_px * place.zoom)
        ring = QPainterPath()
        ring.addEllipse(at, radius, radius)
        if self.shown.brush.tool == "eraser":
            for arm in (QPointF(3.0, 3.0), QPointF(3.0, -3.0)):
                ring.moveTo(at - arm)
                ring.lineTo(at + arm)
        glyphs.outlined(painter, ring, glyphs.HALO)
        if self.shown.brush.moves and self.shown.brush.falloff < 1.0:
            inner, whole = QPainterPath(), (1.0 - self.shown.brush.falloff) * radius
            inner.addEllipse(at, whole, whole)
            glyphs.outlined(painter, inner, glyphs.HALO, 1.0, style=Qt.PenStyle.DotLine)


def _shapes(stroke: Stroke) -> tuple[QPainterPath, QPainterPath]:
    line = [QPointF(x, y) for x, y in stroke.points_px.tolist()]
    core = _outline(line, stroke.radius_px)
    return core, _outline(line, stroke.radius_px + stroke.feather_px)


def _outline(line: list[QPointF], radius: float) -> QPainterPath:
    path = QPainterPath()
    if radius <= 0.0:
        return path
    if len(line) == 1:
        path.addEllipse(line[0], radius, radius)
        return path
    path.moveTo(line[0])
    for point in line[1:]:
        path.lineTo(point)
    stroker = QPainterPathStroker()
    stroker.setWidth(2.0 * radius)
    stroker.setCapStyle(Qt.PenCapStyle.RoundCap)
    stroker.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    stroker.setCurveThreshold(_ROUNDNESS * radius)
    return stroker.createStroke(path).simplified()
