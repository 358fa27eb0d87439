"""Overlays of the current state: points, centre line, protected regions, brush."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from functools import lru_cache
from itertools import starmap
from typing import Final

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPainterPath, QPainterPathStroker, QPen, QPolygonF, QTransform

from kogao_core.additions.head import forehead_pairs
from kogao_core.base.geometry import Affine, Array
from kogao_core.base.language import Text
from kogao_core.faces.doubt import SEEN
from kogao_core.faces.face import Face
from kogao_core.faces.targets import center_candidates
from kogao_core.field.mask import Mask
from kogao_core.field.protection import Stroke

from ...view_state import RenderedFrame, ViewState
from ..handles import apart
from . import glyphs
from .overlay import Overlay, Place

_TICK_PX: Final = 6.0
# Least landmark spacing on screen for marks of full size.
_ROOM_PX: Final = 16.0
_FOLLOWER: Final = 0.5  # size of a follower's mark, relative to a target's mark
_THINNEST_PX: Final = 3.0
_READ_PX: Final = 1.6
# The protected area is sampled at every fifth px of the screen.
_SAMPLE_PX: Final = 5
_IN_FULL: Final = 0.98  # a position with this share of its displacement counts as fully moved
_ROUNDNESS: Final = 0.05  # maximum error of an outline, as a fraction of the radius


class Landmarks(Overlay):
    """Outline dots, and diamonds at the corners of eyes and mouth; a line for a small face.

    The selected face's outline is a bright line.
    """

    name = "landmarks"
    title = Text("Landmarks")
    height = 110
    key = "L"
    handles = frozenset({"outline", "eye", "mouth"})

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        glyphs.dot(painter, box.center(), glyphs.LANDMARK)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw points; hollow or dotted for inactive faces and uncertain points."""
        for index, face in enumerate(self.shown.state.faces):
            if not self.shown.marks(index):
                continue
            chosen, seen = index == self.shown.face, apart(face, place.zoom)
            off = index in self.shown.state.off
            if chosen or not seen:
                colour, width = (glyphs.HALO, 2.2) if chosen else (glyphs.OUTLINE, 1.6)
                glyphs.polyline(painter, place.points(face.outline), colour, width, dotted=off)
            if seen:
                unsure = np.full(len(face.points), off)
                if face.confidence is not None:
                    unsure |= face.confidence < SEEN
                size = _size(place, face)
                for number, at in enumerate(place.points(face.points)):
                    sure = glyphs.dot if number < len(face.outline) else glyphs.diamond
                    mark = glyphs.hollow if unsure[number] else sure
                    mark(painter, at, glyphs.LANDMARK, size)


def _large(view: ViewState, place: Place) -> Iterator[tuple[int, Face]]:
    """Yield the active faces with visible, distinguishable marks."""
    for index, face in enumerate(view.state.faces):
        if index not in view.state.off and view.marks(index) and apart(face, place.zoom):
            yield index, face


def _size(place: Place, face: Face) -> float:
    """Return the relative size of a face's marks, 0 to 1: smaller for a small face."""
    return min(1.0, face.anchor.spacing_px * place.zoom / _ROOM_PX)


class Targets(Overlay):
    """Rings at the targets with lines to these; smaller for forehead points that follow."""

    name = "targets"
    title = Text("Targets")
    height = 100
    key = "T"
    handles = frozenset({"target"})

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        glyphs.ring(painter, box.center(), glyphs.TARGET)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the targets of all active faces that are large enough."""
        for index, face in _large(self.shown, place):
            pairs, size = self.shown.state.pairs[index], _size(place, face)
            _draw_ways(painter, place, pairs.source_px, pairs.target_px, size)
            recipe = self.shown.state.recipe.of_face(face.recipe)
            follow = forehead_pairs(self.shown.state.seen[index], recipe, pairs.started)
            _draw_ways(painter, place, *follow, _FOLLOWER * size)


def _draw_ways(
    painter: QPainter, place: Place, sources_px: Array, targets_px: Array, size: float
) -> None:
    ways = np.stack([sources_px, targets_px], axis=1)
    glyphs.lines(painter, place.to_screen(ways), glyphs.WAY)
    for at in place.points(targets_px):
        glyphs.ring(painter, at, glyphs.TARGET, size)


class ReadOutline(Overlay):
    """The outline of each face as read from a retouched copy."""

    name = "read"
    title = Text("Read outline")
    height = 107
    key = "Shift+T"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        chin = [box.topLeft(), QPointF(box.center().x(), box.bottom()), box.topRight()]
        glyphs.polyline(painter, chin, glyphs.READ, _READ_PX, dotted=False)

    @classmethod
    def is_there(cls, view: ViewState) -> bool:
        return view.retouched is not None

    def draw(self, painter: QPainter, place: Place) -> None:
        copy = self.shown.retouched
        for outline in () if copy is None else copy.outlines:
            glyphs.polyline(painter, place.points(outline), glyphs.READ, _READ_PX, dotted=False)


class Centre(Overlay):
    """The line from the eyes to the mouth with four candidates, and the selected centre."""

    name = "centre"
    title = Text("Centre and its candidates")
    height = 90
    key = "C"
    handles = frozenset({"centre"})

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        glyphs.cross(painter, box.center(), glyphs.CENTRE, 0.9)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the line of all active faces that are large enough."""
        for _, face in _large(self.shown, place):
            self._draw_line(painter, place, face)

    def _draw_line(self, painter: QPainter, place: Place, face: Face) -> None:
        line = place.to_screen([face.eye_center, face.mouth_center])
        places = place.points(center_candidates(face))
        size = _size(place, face)
        ticks = glyphs.ticks(line, [at.toTuple() for at in places], _TICK_PX * size)
        glyphs.lines(painter, [line, *ticks], glyphs.CENTRE)
        recipe = self.shown.state.recipe.of_face(face.recipe)
        chosen = int(recipe.center) - 1
        # Only the face alone moves towards a centre.
        used = recipe.scope == "face"
        mark = glyphs.cross if used else glyphs.hollow
        mark(painter, places[chosen], glyphs.CENTRE, size)
        if QLineF(places[0], places[3]).length() > 5 * _TICK_PX:
            # Labels are higher than the spacing: odd numbers go right, even numbers left.
            for number, at in enumerate(places, 1):
                beside = QPointF(12.0 if number % 2 else -28.0, 0.0)
                glyphs.label(painter, at + beside, str(number), bold=used and number == chosen + 1)


class Protected(Overlay):
    """A hatch over each stroke, and a dashed line around the region that moves less."""

    name = "protection"
    title = Text("Protected places")
    height = 50
    key = "P"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        painter.setPen(QPen(glyphs.HALO, 1.4))
        painter.setBrush(glyphs.protected())
        painter.drawRoundedRect(box.adjusted(2, 4, -2, -4), 5, 5)

    @classmethod
    def is_there(cls, view: ViewState) -> bool:
        return bool(view.state.protection.strokes)

    def wanted(self, visible: AbstractSet[str]) -> bool:
        """Return True if the overlay is on or a protecting tool is selected."""
        return super().wanted(visible) or self.shown.brush.protects

    def draw(self, painter: QPainter, place: Place) -> None:
        """Fill the strokes with one hatch, fixed to the photo."""
        matrix, (dx, dy) = place.to_screen.matrix, place.to_screen.shift
        to_screen = QTransform(matrix[0, 0], matrix[1, 0], matrix[0, 1], matrix[1, 1], dx, dy)
        painter.setBrushOrigin(QPointF(dx, dy))
        strokes = self.shown.state.protection.strokes
        for stroke in strokes:
            shape = to_screen.map(_shape(stroke))
            if isinstance(stroke, Stroke) and stroke.radius_px * place.zoom < _THINNEST_PX / 2:
                shape = _outline(place.points(stroke.points_px), _THINNEST_PX / 2)
            painter.fillPath(shape, glyphs.protected())
            glyphs.outlined(painter, shape, glyphs.HALO)
        if strokes and self.shown.frame is not None:
            edge = _slowed(painter, place, self.shown.frame)
            glyphs.outlined(painter, edge, glyphs.HALO, 1.0, style=Qt.PenStyle.DashLine)


class BrushRing(Overlay):
    """The brush size around the cursor, with the start of the falloff or the eraser's cross."""

    height = 170

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the ring while a painting tool is over the photo."""
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


@lru_cache(maxsize=256)  # outlining a stroke is slower than filling
def _shape(stroke: Stroke | Mask) -> QPainterPath:
    if isinstance(stroke, Mask):
        path = QPainterPath()
        for line in stroke.outlines_px:
            path.addPolygon(QPolygonF(list(starmap(QPointF, line.tolist()))))
        return path
    return _outline([QPointF(x, y) for x, y in stroke.points_px.tolist()], stroke.radius_px)


def _slowed(painter: QPainter, place: Place, frame: RenderedFrame) -> QPainterPath:
    """Return the outline, on screen, of the region with displacement reduced by protection."""
    (left, top), (right, bottom) = place.to_screen(np.array(place.seen))
    xs, ys = np.arange(left, right, _SAMPLE_PX), np.arange(top, bottom, _SAMPLE_PX)
    places = place.to_screen.inverse(np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2))
    share = frame.rendering.field.protected_share(frame.to_photo.inverse(places))
    mask = share.reshape(len(ys), len(xs)) < _IN_FULL
    return glyphs.mask_outline(painter, mask, Affine(np.eye(2) * _SAMPLE_PX, np.array([left, top])))


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
