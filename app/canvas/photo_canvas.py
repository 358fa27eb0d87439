"""Mouse, pen and key events on the canvas: gestures of tools, and signals for clicks and keys."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt, Signal
from PySide6.QtGui import (
    QContextMenuEvent,
    QFocusEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPointingDevice,
    QTabletEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QApplication, QPinchGesture

from kogao_core.background.lines import BackgroundLine
from kogao_core.base.geometry import Array

from ..accessibility import announce
from ..i18n import tr
from ..view_state import Handle, ViewState
from .handles import ON_OUTLINE, apart, corners, face_at, handles
from .overlays import glyphs
from .overlays.curves import ShapeCurve, nearest
from .overlays.listed import kinds
from .overlays.overlay import Place, affine
from .overlays.unlisted import badges
from .spoken import SpokenView, place_name
from .tools.gesture import Gesture, PointerEvent, Tool
from .viewport import notches

GRAB_RADIUS_PX: Final = 12.0
_BESIDE_A_CURVE_PX: Final = 8.0  # the reach of a point that a curve passes
# Maximum distance from a landmark for Ctrl+click, in landmark spacings.
NEAR: Final = 3.0
_MARK_PX: Final = 5.0
ARROWS: Final = {
    Qt.Key.Key_Left: (-1, 0),
    Qt.Key.Key_Right: (1, 0),
    Qt.Key.Key_Up: (0, -1),
    Qt.Key.Key_Down: (0, 1),
}
_ENTER: Final = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_BY_TAB: Final = (Qt.FocusReason.TabFocusReason, Qt.FocusReason.BacktabFocusReason)
_MANY_STEPS: Final = 10
_POINTER_STEP_PX: Final = 4
_SAME_ZOOM: Final = 0.01
_PEN, _ERASER = QPointingDevice.PointerType.Pen, QPointingDevice.PointerType.Eraser


class PhotoCanvas(SpokenView):
    """The canvas of the editor."""

    # (line: BackgroundLine): a click on a line of the background.
    line_clicked = Signal(object)
    # (face: int, at: QPoint): the menu of a face is wanted, at a position of the screen.
    menu_wanted = Signal(int, QPoint)
    # (notches: float): the wheel turns during a drag that neighbours follow.
    widened = Signal(float)
    # (dx: int, dy: int): an arrow key moves the selected point, px of the photo.
    nudged = Signal(int, int)
    # (): the arrow key is released.
    nudge_ended = Signal()
    # (on: bool): the eraser end of a pen is near the photo, or another pointer again.
    turned = Signal(bool)

    def __init__(self, view: ViewState) -> None:
        super().__init__(view)
        self.setAccessibleName(tr("Photo"))
        self.setAccessibleDescription(
            tr(
                "A list of the faces, and of the points of the selected face. “Next point” selects "
                "a point; arrow keys move the point. With a tool, arrow keys move the tool; Enter "
                "starts and ends a stroke"
            )
        )
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self._space = self._ringed = False
        # What begins at a press: by name of the selected tool, "mark" while marking, "fetch" with
        # Ctrl. Features add these.
        self.tools: dict[str, Tool] = {}
        self._gesture: Gesture | None = None
        self._dragged: Handle | None = None
        self._moved: PointerEvent | None = None  # the last move of the gesture
        self._wiping = False
        # Position of a press beside all handles: a click, until dragged beyond the drag distance.
        self._clicked: QPointF | None = None
        self._doubled = False
        self._pointer: QPointF | None = None
        self._pressure = 1.0  # pen pressure, 0 to 1
        self._is_turned = False  # whether the last pointer was the eraser end of a pen
        view.watch(self._take_tool, "brush")
        view.watch(self._repeat, "following")
        view.document.aborted.connect(self._let_go)
        view.document.opened.connect(self._let_go)

    @property
    def in_hand(self) -> bool:
        """True during a gesture of a tool."""
        return self._gesture is not None

    def begin(self, name: str, handle: Handle | None, point_px: Array) -> None:
        """Begin a gesture of a tool at (x, y), px of the photo."""
        self._dragged, self._moved = handle, None
        self._gesture = self.tools[name](handle, PointerEvent(point_px, pressure=self._pressure))
        self._go_on(None)

    def move(self, point_px: Array, *, straight: bool = False) -> None:
        """Go on to (x, y), px of the photo; `straight` makes a line horizontal or vertical."""
        self._moved = PointerEvent(point_px, straight, self._pressure)
        self._go_on(self._moved)

    def end(self, point_px: Array) -> None:
        """End the gesture of a tool at (x, y), px of the photo."""
        self._go_on(PointerEvent(point_px, released=True))
        self._let_go()

    def _go_on(self, event: PointerEvent | None) -> None:
        """Tell the gesture of an event; None starts the gesture."""
        if self._gesture is not None:
            try:
                self._gesture.send(event)  # type: ignore[arg-type]
            except StopIteration:
                self._gesture = None

    def _repeat(self) -> None:
        """Follow a changed range during a drag."""
        if self._moved is not None:
            self._go_on(self._moved)

    def _let_go(self) -> None:
        """Cancel the current gesture or click. The button may still be down."""
        self._gesture = self._dragged = self._moved = self._clicked = None

    def set_space_down(self, down: bool) -> None:
        """Pan with the left button while Space is held."""
        self._space = down
        self._point_at(None)

    def _take_tool(self) -> None:
        """Show the cursor of the selected tool. Keyboard pointing starts at the centre."""
        self._pointer = None
        self._point_at(None)

    def handle_at(self, at: QPointF) -> Handle | None:
        """Return the nearest handle within reach of a point of the viewport.

        Inside an unselected face, handles of the selected face react only on their marks.
        A face without visible points has no handles.
        """
        view = self.shown
        if view.original or view.brush.paints:
            return None
        here, elsewhere = self.to_photo(at), self.face_at(at) not in (None, view.face)
        reach_px = _BESIDE_A_CURVE_PX if self.curve_at(here) else GRAB_RADIUS_PX
        nearest, least = None, self.in_photo(_MARK_PX if elsewhere else reach_px)
        for handle, position in handles(view.state, kinds(view.visible), view.placing):
            distance = float(np.hypot(*(position - here)))
            if distance < least and view.answers(handle) and self._shows(handle):
                nearest, least = handle, distance
        if nearest is None and view.marking and view.placing is None:
            return Handle("mark", 0, 0)
        return nearest or self._body_at(at)

    def curve_at(self, point_px: Array) -> tuple[ShapeCurve, int] | None:
        """Return the shape curve at (x, y), px of the photo, and the number of its point."""
        if self.shown.original or self.shown.busy_hands:
            return None
        return nearest(self.shown, self._place(), point_px)

    def _place(self) -> Place:
        return Place(affine(self._to_screen()), self.viewport().rect().toRectF())

    def shows_points(self, face: int) -> bool:
        """Return whether the points of a face are shown at the current zoom."""
        return apart(self.shown.state.faces[face], 1.0 / self.in_photo(1.0))

    def _shows(self, handle: Handle) -> bool:
        marked = self.shown.marks(handle.face) and self.shows_points(handle.face)
        return handle.kind == "corner" or marked

    def outline_near(self, at: QPointF) -> Handle | None:
        """Return the outline landmark within `NEAR` spacings of a viewport point, or None."""
        view, here = self.shown, self.to_photo(at)
        if view.original or view.busy_hands:
            return None
        nearest, least = None, NEAR
        for handle, position in handles(view.state, kinds(view.switched) & {"outline"}):
            spacing_px = view.state.faces[handle.face].anchor.spacing_px
            distance = float(np.hypot(*(position - here))) / spacing_px
            if distance < least and view.answers(handle) and self.shows_points(handle.face):
                nearest, least = handle, distance
        return nearest

    def face_at(self, at: QPointF) -> int | None:
        """Return the face at a point of the viewport, by number badge or skin; None for others."""
        view = self.shown
        if len(view.state.faces) < 2 or view.busy_hands:
            return None
        for badge in reversed(list(badges(view, self._place(), self.viewport().font()))):
            if badge.plate.contains(at):
                return badge.face
        return face_at(view.state.faces, self.to_photo(at), self.in_photo(_MARK_PX))

    def line_at(self, at: QPointF) -> BackgroundLine | None:
        """Return the nearest clickable line at a point of the viewport, or None."""
        view = self.shown
        if view.original or view.busy_hands or "straight" not in view.visible:
            return None
        (x, y), nearest, least = self.to_photo(at).tolist(), None, self.in_photo(_MARK_PX)
        for line in view.lines:
            ends = np.array([line.start_px, line.end_px], np.float32)
            distance = abs(cv2.pointPolygonTest(ends, (x, y), measureDist=True))
            if line.holding and distance < least:
                nearest, least = line, distance
        return nearest

    def in_photo(self, screen_px: float) -> float:
        """Return a length on the screen in px of the photo."""
        return screen_px * float(self.devicePixelRatioF()) / self.zoom

    def on_divider(self, at: QPointF) -> bool:
        """Return whether a point of the viewport is within reach of the divider."""
        if self.shown.compare != "wipe":
            return False
        away_px: float = abs(at.x() - self.shown.wipe * self.viewport().width())
        return away_px <= GRAB_RADIUS_PX

    def _body_at(self, at: QPointF) -> Handle | None:
        placing = self.shown.placing
        if placing is None:
            return None
        low, high = corners(self.shown.state.faces[placing])[[0, 2]]
        here = self.to_photo(at)
        return Handle("body", placing, 0) if ((low <= here) & (here <= high)).all() else None

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Grab a handle, start a stroke, or start to pan; other buttons don't disturb a drag."""
        if event.buttons() != event.button():
            return
        self._ring(False)
        self._sense(event)
        self.setFocus(Qt.FocusReason.MouseFocusReason)
        at = event.position()
        left = event.button() == Qt.MouseButton.LeftButton
        takes = left and not self._space
        control = event.modifiers() & Qt.KeyboardModifier.ControlModifier
        # Pens and fingers send no move events first, and marks appear only under the pointer.
        self._look_at(at)
        if takes and self.on_divider(at):
            self._wiping = True
        elif takes and control and not self.shown.busy_hands:
            self.begin("fetch", self.outline_near(at), self.to_photo(at))
        elif takes and not self._set_down(at):
            self._clicked = at
        elif not takes and (left or event.button() == Qt.MouseButton.MiddleButton):
            self.start_pan(at)
        event.accept()

    def tabletEvent(self, event: QTabletEvent) -> None:
        """Store the pen pressure. Qt also sends the pen event as a mouse event."""
        # A release has pressure 0, and one more mouse move to the place of the release follows.
        if event.type() != QEvent.Type.TabletRelease:
            self._pressure = min(max(event.pressure(), 0.0), 1.0)
        event.ignore()

    def _sense(self, event: QMouseEvent) -> None:
        """Follow a switch between pen tip, eraser and mouse; a mouse has full pressure."""
        if event.pointerType() not in (_PEN, _ERASER):
            self._pressure = 1.0
        turned = event.pointerType() == _ERASER
        if turned != self._is_turned and not self.in_hand:
            self._is_turned = turned
            self.turned.emit(turned)

    def pinch(self, pinch: QPinchGesture) -> None:
        """Zoom and pan with two fingers, and call off what the first finger began."""
        self._wiping = False
        self.shown.document.abort()
        super().pinch(pinch)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Handle a press; on release without a drag, toggle between 1:1 and fit."""
        self.mousePressEvent(event)
        self._doubled = self._clicked is not None

    def _set_down(self, at: QPointF) -> bool:
        """Start a stroke or grab a handle; return whether a drag or a stroke is active."""
        handle = self.handle_at(at)
        if handle is None and self.curve_at(self.to_photo(at)):
            self.begin("shape", None, self.to_photo(at))
        elif handle is not None or self.shown.brush.paints:
            marks = handle is not None and handle.kind == "mark"
            self.begin("mark" if marks else self.shown.brush.tool, handle, self.to_photo(at))
        return self.in_hand

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Continue the current drag, stroke or pan, or update the hovered handle."""
        self._sense(event)
        self._pointer = at = event.position()
        if self._wiping:
            self.shown.set(wipe=min(max(at.x() / self.viewport().width(), 0.0), 1.0))
        elif self.in_hand:
            shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
            self._move_to(at, straight=bool(shift))
        elif self._clicked is not None:
            self._pan_once_dragged(self._clicked, at)
        elif self.panning:
            self.pan_to(at)
        elif event.buttons() == Qt.MouseButton.NoButton:
            self._look_at(at)
        event.accept()

    def _look_at(self, at: QPointF) -> None:
        handle = None if self._space or self.on_divider(at) else self.handle_at(at)
        self._point_at(handle)
        if self.on_divider(at):
            self.viewport().setCursor(Qt.CursorShape.SplitHCursor)
        elif handle is None and (self._answers_a_click(at) or self.curve_at(self.to_photo(at))):
            self.viewport().setCursor(Qt.CursorShape.PointingHandCursor)
        self._show_pointer(at, handle)

    def _show_pointer(self, at: QPointF, hovered: Handle | None) -> None:
        x, y = self.to_photo(at).tolist()
        is_point = hovered is not None and hovered.kind != "mark"
        curve = None if hovered or self.in_hand else self.curve_at(np.array([x, y]))
        shaping = self.shown.shaping if self.in_hand else curve and curve[0].field
        self.shown.set(cursor=(x, y), hovered=hovered if is_point else None, shaping=shaping)

    def _answers_a_click(self, at: QPointF) -> bool:
        return self.line_at(at) is not None or self.face_at(at) not in (None, self.shown.face)

    def _pan_once_dragged(self, start: QPointF, at: QPointF) -> None:
        if (at - start).manhattanLength() >= QApplication.startDragDistance():
            self._clicked = None
            self.start_pan(start)
            self.pan_to(at)

    def _move_to(self, at: QPointF, *, straight: bool) -> None:
        self._show_pointer(at, self.shown.hovered)
        self.move(self.to_photo(at), straight=straight)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End the drag once no button is down, or handle a click on a line or face."""
        if event.buttons() != Qt.MouseButton.NoButton:
            return
        self._wiping = False
        if self._clicked is not None and self._doubled:
            if abs(self.zoom - 1.0) < _SAME_ZOOM:
                self.fit()
            else:
                self.zoom_to(1.0, self._clicked)
        elif self._clicked is not None:
            if (line := self.line_at(self._clicked)) is not None:
                self.line_clicked.emit(line)
            elif (face := self.face_at(self._clicked)) is not None:
                self.picked.emit(face)
        self._doubled = False
        self.end(self.to_photo(event.position()))
        self.end_pan()
        self.set_space_down(self._space)
        event.accept()

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Request the menu of the face under the cursor, or by keyboard of the selected face."""
        by_key = event.reason() == QContextMenuEvent.Reason.Keyboard
        face = self.shown.face if by_key else self.face_at(event.pos().toPointF())
        if face is not None and not self.in_hand and not self.panning:
            middle = self.to_screen(self.shown.state.faces[face].eye_center).toPoint()
            at = self.viewport().mapToGlobal(middle) if by_key else event.globalPos()
            self.menu_wanted.emit(face, at)
        event.accept()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom; during an outline drag with soft following, change the follow range."""
        follows = self.shown.following.soft and self.in_hand
        if follows and self._dragged is not None and self._dragged.kind in ON_OUTLINE:
            self.widened.emit(notches(event))
            event.accept()
        else:
            super().wheelEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.shown.set(cursor=None, hovered=None, shaping=None)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Nudge the selected point with the arrow keys, or move the tool by keyboard."""
        key, step = Qt.Key(event.key()), ARROWS.get(Qt.Key(event.key()))
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        times = _MANY_STEPS if shift else 1
        marks = self.shown.marking and self.shown.selected is None
        if (step is not None or key in _ENTER) and (self.shown.brush.paints or marks):
            self._point_by_key(step, times)
        elif step is not None and self.shown.selected is not None:
            self.nudged.emit(step[0] * times, step[1] * times)
        else:
            event.ignore()

    def _point_by_key(self, step: tuple[int, int] | None, times: int) -> None:
        area = self.viewport().rect().toRectF()
        at = area.center() if self._pointer is None else self._pointer
        if step is not None:
            at += QPointF(*step) * _POINTER_STEP_PX * times
            at = QPointF(
                min(max(at.x(), area.left()), area.right()),
                min(max(at.y(), area.top()), area.bottom()),
            )
        self._pointer = at
        self._show_pointer(at, None)
        place = place_name(self.to_photo(at))
        if step is not None and self.in_hand:
            self._move_to(at, straight=False)
        elif step is None and self.in_hand:
            self.end(self.to_photo(at))
            place = tr("Stroke ends, {place}", place=place)
        elif step is None and self._set_down(at):
            place = tr("Stroke begins, {place}", place=place)
        announce(self, place)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        nudges = Qt.Key(event.key()) in ARROWS and not self.in_hand
        if nudges and not event.isAutoRepeat():
            self.nudge_ended.emit()
        else:
            event.ignore()

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show a focus ring after Tab."""
        super().focusInEvent(event)
        self._ring(event.reason() in _BY_TAB)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self._ringed:
            painter, area = QPainter(self.viewport()), self.viewport().rect()
            for colour, inset in ((glyphs.HALO, 0), (glyphs.CASE, 2)):
                painter.setPen(QPen(colour, 2.0))
                painter.drawRect(area.adjusted(inset + 1, inset + 1, -inset - 1, -inset - 1))

    def _ring(self, wanted: bool) -> None:
        if wanted != self._ringed:
            self._ringed = wanted
            self.viewport().update()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """End a nudge: the key release may reach another widget."""
        super().focusOutEvent(event)
        self._ring(False)
        self.nudge_ended.emit()

    def _point_at(self, handle: Handle | None) -> None:
        idle = Qt.CursorShape.CrossCursor if self.shown.brush.paints else Qt.CursorShape.ArrowCursor
        shape = Qt.CursorShape.OpenHandCursor if self._space else idle
        if handle is not None and handle.kind == "mark":
            shape = Qt.CursorShape.CrossCursor
        elif handle is not None:
            shape = Qt.CursorShape.SizeAllCursor
            if not handle.movable:
                shape = Qt.CursorShape.PointingHandCursor
        self.viewport().setCursor(shape)
