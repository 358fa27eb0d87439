"""Overlays without a switch: they depend on tool, zoom, number of faces and comparison."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import starmap
from typing import Final, NamedTuple

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QPainter, QPainterPath, QPen, QTransform

from kogao_core.base.geometry import Array
from kogao_core.faces import reshape
from kogao_core.faces.doubt import verdicts

from ...document import CORNERS
from ...i18n import tr
from ...view_state import GAIN, Handle, ViewState
from .. import handles
from ..photo_layer import PhotoItem
from . import glyphs
from .listed import LISTED, kinds
from .marks import BrushRing
from .overlay import Overlay, Place

_BAND_PX: Final = 9.0
_OPAQUE: Final = 191
KNOB_PX: Final = 14.0
_LOUPE_PX: Final = 96.0
_MAGNIFIED: Final = 4.0
_TOP_PX: Final = 20.0


class Badge(NamedTuple):
    """The number of a face: text, selection, and label rectangle in px of the screen."""

    face: int
    text: str
    chosen: bool
    plate: QRectF


def badges(view: ViewState, place: Place, font: QFont) -> Iterator[Badge]:
    """Yield the numbers above the faces' topmost landmarks, the topmost badge last."""
    held = _held_back(view)
    if len(view.state.faces) < 2:
        return
    # The selected face's badge is on top.
    for index in sorted(range(len(view.state.faces)), key=lambda index: index == view.face):
        if "landmarks" not in view.visible and index not in held:
            continue
        left, top, width, _ = view.state.faces[index].box
        (at,) = place.points([(left + width / 2, top)])
        chosen = index == view.face or index in view.also
        text = tr("● {n}", n=index + 1) if chosen else str(index + 1)
        if index in held:
            text = tr("{face} ⚠ {n:.0f} %", face=text, n=100 * held[index])
        within = place.viewport if place.viewport.contains(at) else None
        above = at - QPointF(8, 20)
        yield Badge(
            index, text, chosen, glyphs.plate(font, above, text, bold=chosen, within=within)
        )


def _held_back(view: ViewState) -> dict[int, float]:
    """Return faces with limited displacement in the newest frame, and the remaining share."""
    on = [index for index in range(len(view.state.faces)) if index not in view.state.off]
    shares = () if view.frame is None else view.frame.rendering.shares
    pairs = zip(on, shares, strict=True) if len(on) == len(shares) else ()
    return {index: share for index, share in pairs if share < 1.0}


class FaceNumbers(Overlay):
    """A number over each face; the selected face's number is bold with a dot."""

    height = 120

    def draw(self, painter: QPainter, place: Place) -> None:
        for badge in badges(self.shown, place, painter.font()):
            glyphs.on_plate(painter, badge.plate, badge.text, bold=badge.chosen)


class PointsToLookAt(Overlay):
    """An amber ring around each doubtful landmark that no user has placed; at rest a small dot."""

    height = 125

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the rings of all active faces that are large enough, unless overlays are hidden."""
        state = self.shown.state
        if not self.shown.switched:
            return
        for index, verdict in enumerate(verdicts(state.faces, self.shown.image)):
            face = state.faces[index]
            if index in state.off or not handles.apart(face, place.zoom):
                continue
            # A ring has its landmark in the middle: what is ringed can be dragged.
            ringed = self.shown.marks(index) and "landmarks" in self.shown.visible
            for at in place.points(face.points[list(verdict.look_at)]):
                if ringed:
                    glyphs.ring(painter, at, glyphs.CHECK, 1.8)
                else:
                    glyphs.dot(painter, at, glyphs.CHECK, 0.6)


class Draft(Overlay):
    """Diamonds for the corners of eyes and mouth, dots and rings for the first landmarks."""

    height = 130

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw all marked points, and the position of the next point."""
        if self.shown.state.mode != "manual":
            return
        for number, (source, target) in enumerate(self.shown.state.draft):
            ends = place.to_screen([source, target])
            at, to = starmap(QPointF, ends.tolist())
            if number < CORNERS:
                glyphs.diamond(painter, at, glyphs.LANDMARK)
                continue
            glyphs.dot(painter, at, glyphs.LANDMARK)
            glyphs.lines(painter, [ends], glyphs.WAY)
            glyphs.ring(painter, to, glyphs.TARGET)
        if self.shown.marking and self.shown.cursor is not None:
            glyphs.cross(painter, place.points(self.shown.cursor)[0], glyphs.LANDMARK)


class Placement(Overlay):
    """A frame around a face during placement, with corners to rotate and scale the face."""

    height = 140

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the frame and its corners while a face is being placed."""
        if self.shown.placing is None:
            return
        at = place.to_screen(handles.corners(self.shown.state.faces[self.shown.placing]))
        frame = np.stack([at, np.roll(at, -1, axis=0)], axis=1)
        glyphs.lines(painter, frame, glyphs.HALO, style=Qt.PenStyle.DashLine)
        painter.setPen(QPen(glyphs.CASE, 1.0))
        painter.setBrush(glyphs.HALO)
        for x, y in at.astype(int).tolist():
            painter.drawRect(x - 5, y - 5, 10, 10)


class Names(Overlay):
    """The name of the point under the cursor, and a ring around the selected point."""

    height = 150

    def draw(self, painter: QPainter, place: Place) -> None:
        view = self.shown
        shown = {*kinds(view.visible), "corner"}
        if view.selected is not None and view.selected.kind in shown:
            (at,) = place.points(handles.position(view.state, view.selected))
            glyphs.ring(painter, at, glyphs.HALO, 2.0)
        if view.hovered is not None and view.hovered.kind in shown:
            (at,) = place.points(handles.position(view.state, view.hovered))
            face = view.state.faces[view.hovered.face]
            count, confidence = len(face.outline), handles.confidence(face, view.hovered)
            sure = "" if confidence is None else tr(" · {n:.0f} % sure", n=100 * confidence)
            text = handles.name(view.hovered, count) + sure
            # Away from the face, so that the name hides no neighbouring point.
            (middle,) = place.points(face.points.mean(axis=0))
            glyphs.on_plate(
                painter,
                glyphs.outward_plate(painter.font(), at, middle, text, place.viewport),
                text,
            )


class FollowingBand(Overlay):
    """A band along points that follow a drag, and a ring around the mirrored point."""

    height = 106

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw a line between neighbouring points; the width shows how much the points follow."""
        led, view = self._led(), self.shown
        if led is None or led.kind not in kinds(view.visible):
            return
        # The start of the drag decides which points follow.
        face = view.document.committed.faces[led.face]
        if not handles.apart(face, place.zoom):
            return
        following = view.following
        at = place.points(handles.points(view.state, led.kind, led.face))
        mirror = reshape.opposite(face, led.index) if following.symmetric else None
        for index in (led.index, mirror):
            if index is not None and following.soft:
                weights = reshape.influence(face.outline, index, handles.reach_px(face, following))
                self._draw_band(painter, at, weights)
        if mirror is not None:
            glyphs.ring(painter, at[mirror], glyphs.HALO, 2.0)

    def _draw_band(self, painter: QPainter, at: list[QPointF], weights: Array) -> None:
        for start, end, weight in zip(
            at[:-1], at[1:], (weights[:-1] + weights[1:]) / 2.0, strict=True
        ):
            if weight > 0.0:
                colour = glyphs.translucent(glyphs.HALO, round(_OPAQUE * float(weight)))
                ends = start.toTuple(), end.toTuple()
                glyphs.lines(painter, [ends], colour, _BAND_PX * float(weight))

    def _led(self) -> Handle | None:
        """Return the dragged, hovered or selected landmark or target."""
        view = self.shown
        first = view.selected if view.document.in_gesture else view.hovered
        led = first or view.selected
        if led is None or led.kind not in handles.ON_OUTLINE:
            return None
        return led if handles.exists(view.document.committed, led) else None


class Divider(Overlay):
    """The divider between before and after with a knob, or the name of another comparison."""

    height = 160

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the divider and the names while comparing, not while the original is shown."""
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
        left = tr("before") if self.shown.retouched is None else tr("retouched copy")
        width = painter.fontMetrics().horizontalAdvance(left) + 8
        glyphs.label(painter, QPointF(x - 10 - width, area.top() + _TOP_PX), left)
        glyphs.label(painter, QPointF(x + 10, area.top() + _TOP_PX), tr("after"))

    def _text(self) -> str:
        if self.shown.compare == "side":
            return tr("after")
        return tr("difference, {n} × as strong", n=GAIN)  # noqa: RUF001


class Loupe(Overlay):
    """A magnifier at the cursor: original in the left half, result in the right half."""

    height = 180

    def __init__(self, view: ViewState, photo: PhotoItem) -> None:
        super().__init__(view)
        self._photo = photo

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw both halves and a rim while the cursor is over the photo."""
        if not self.shown.loupe or self.shown.cursor is None or self.shown.original:
            return
        x, y = self.shown.cursor
        (at,) = place.points([(x, y)])
        round_it = QRectF(at.x() - _LOUPE_PX, at.y() - _LOUPE_PX, 2 * _LOUPE_PX, 2 * _LOUPE_PX)
        zoom = _MAGNIFIED * place.zoom
        magnified = QTransform(zoom, 0.0, 0.0, zoom, at.x() - zoom * x, at.y() - zoom * y)
        right = QRectF(at.x(), round_it.top(), _LOUPE_PX, round_it.height())
        left = right.translated(-_LOUPE_PX, 0.0)
        disc = QPainterPath()
        disc.addEllipse(round_it)
        for half, draw in ((left, self._photo.draw_original), (right, self._photo.draw_result)):
            painter.save()
            painter.setClipPath(disc)
            painter.setClipRect(half, Qt.ClipOperation.IntersectClip)
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


_UNLISTED: Final[tuple[type[Overlay], ...]] = (
    *(FollowingBand, FaceNumbers, PointsToLookAt, Draft),
    *(Placement, Names, Divider, BrushRing),
)


def stack(view: ViewState) -> list[Overlay]:
    """Return all overlays, listed or not, in the order in which they are drawn."""
    return [kind(view) for kind in sorted((*LISTED, *_UNLISTED), key=lambda kind: kind.height)]
