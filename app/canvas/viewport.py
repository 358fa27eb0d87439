"""The photo view: visible part, zoom and panning."""

from __future__ import annotations

from typing import Final

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QLineF, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QMouseEvent,
    QNativeGestureEvent,
    QResizeEvent,
    QShowEvent,
    QTransform,
    QWheelEvent,
)
from PySide6.QtWidgets import QGestureEvent, QGraphicsView, QLabel, QPinchGesture

from kogao_core.base.geometry import Array

from ..i18n import tr
from ..view_state import DRAWN, ViewState, VisiblePart
from .overlays.overlay import Layers
from .overlays.unlisted import Loupe, stack
from .photo_layer import PhotoItem, pixels_in

_LARGEST_ZOOM: Final = 32.0
_LEAST_SEEN_PX: Final = 16.0
_ZOOM_PER_NOTCH: Final = 1.25
_NOTCH: Final = 120.0
_LEAST_APART: Final = 0.1
_FIT_PADDING: Final = 0.02
# Margin of a preview: pixels outside the view may move in during a gesture.
_PREVIEW_MARGIN_PX: Final = 48
_NAME_PX: Final = 12


class Viewport(pg.GraphicsView):
    """Shows the photo with overlays. The wheel and a pinch zoom, a drag pans.

    Signals
    -------
    view_changed
        The visible part or the zoom changed.
    """

    view_changed = Signal()
    _fitted = False  # class attribute: the base class calls resizeEvent in its constructor

    def __init__(self, view: ViewState) -> None:
        super().__init__(useOpenGL=False)
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.grabGesture(Qt.GestureType.PinchGesture)
        self.shown = view
        self.photo = PhotoItem(view)
        self._fitted = True
        self._pan_from: QPointF | None = None
        self._apart = 1.0  # distance of two fingers in a pinch
        self._box = pg.ViewBox(
            lockAspect=True, invertY=True, enableMenu=False, enableMouse=False, defaultPadding=0.0
        )
        self.setCentralItem(self._box)
        self._box.addItem(self.photo, ignoreBounds=True)
        layers = Layers(view, [*stack(view), Loupe(view, self.photo)])
        self._box.addItem(layers, ignoreBounds=True)
        self._box.sigRangeChanged.connect(self.view_changed)
        view.document.opened.connect(self._open)
        view.document.recoloured.connect(self.photo.open)
        view.document.watch(self._draw_marks, "faces", "off")
        view.watch(self._redraw, *DRAWN)
        view.watch(self._draw_cursor, "cursor")

    def _open(self) -> None:
        """Show another photo, fitted to the view."""
        self.photo.open()
        self.fit()

    def fit(self) -> None:
        """Fit the photo to the view, also after later resizes."""
        self._fitted = True
        if self.photo.pyramid is not None:
            self._box.setRange(self.photo.boundingRect(), padding=_FIT_PADDING)

    def zoom_to(self, zoom: float, about: QPointF | None = None) -> None:
        """Zoom to `zoom` device px per photo px; the point `about` of the viewport is fixed."""
        if self.photo.pyramid is None:
            return
        self._fitted = False
        least = _LEAST_SEEN_PX / max(self.photo.pyramid.levels[0].shape[:2])
        factor = self.zoom / min(max(zoom, least), _LARGEST_ZOOM)
        center = self.to_photo(about or QPointF(self.viewport().rect().center())).tolist()
        self._box.scaleBy((factor, factor), center=pg.Point(*center))

    def look_at(self, area: QRectF) -> None:
        """Zoom to an area of the photo, px."""
        self._fitted = False
        self._box.setRange(area, padding=0.0)

    def look_like(self, other: Viewport) -> None:
        """Copy centre and zoom of another view."""
        scale = self.devicePixelRatioF() / other.zoom
        width, height = scale * self._box.width(), scale * self._box.height()
        x, y = other.to_photo(QPointF(other.viewport().rect().toRectF().center())).tolist()
        self.look_at(QRectF(x - width / 2, y - height / 2, width, height))

    @property
    def zoom(self) -> float:
        """Device px per photo px."""
        return float(self._to_screen().m11() * self.devicePixelRatioF())

    def visible_part(self) -> VisiblePart | None:
        """Return the visible part of the photo with a margin, at the level for the zoom."""
        if (pyramid := self.photo.pyramid) is None:
            return None
        level = pyramid.level_for(self.zoom)
        box = pixels_in(self._box.viewRect(), pyramid.levels[level], level, _PREVIEW_MARGIN_PX)
        return VisiblePart(level, box) if box.area else None

    def _redraw(self) -> None:
        self.viewport().update()

    def _draw_marks(self) -> None:
        # Otherwise the overlays are drawn with the next frame. Drawing the overlays now, too,
        # would delay the frame.
        if self.shown.marks_only:
            self._redraw()

    def _draw_cursor(self) -> None:
        if self.shown.brush.paints or self.shown.loupe or self.shown.marking:
            self._redraw()

    def to_photo(self, at: QPointF) -> Array:
        """Convert a viewport point to photo px, shape (2,)."""
        there = self._to_screen().inverted()[0].map(at)
        return np.array([there.x(), there.y()])

    def to_screen(self, position: Array) -> QPointF:
        """Convert a photo point, shape (2,), to viewport px."""
        x, y = position.tolist()
        return self._to_screen().map(QPointF(x, y))

    def _to_screen(self) -> QTransform:
        self._box.updateMatrix()
        transform: QTransform = self._box.childGroup.sceneTransform() * self.viewportTransform()
        return transform

    def start_pan(self, at: QPointF) -> None:
        self._pan_from = at
        self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)

    @property
    def panning(self) -> bool:
        return self._pan_from is not None

    def pan_to(self, at: QPointF) -> None:
        if self._pan_from is not None:
            self.pan(self._pan_from, at)
            self._pan_from = at

    def pan(self, start: QPointF, end: QPointF) -> None:
        """Move the photo from one point of the viewport to another."""
        self._fitted = False
        x, y = (self.to_photo(start) - self.to_photo(end)).tolist()
        self._box.translateBy(x=x, y=y)

    def end_pan(self) -> None:
        self._pan_from = None

    def event(self, event: QEvent) -> bool:
        """Zoom by a pinch: on the touchpad at the pointer, on the screen between two fingers."""
        kinds = Qt.NativeGestureType
        if isinstance(event, QNativeGestureEvent):
            if event.gestureType() == kinds.BeginNativeGesture:
                self._apart = 1.0
            elif event.gestureType() == kinds.ZoomNativeGesture:
                self._spread(self._apart + event.value(), event.position())
            return True
        if isinstance(event, QGestureEvent):
            pinch = event.gesture(Qt.GestureType.PinchGesture)
            assert isinstance(pinch, QPinchGesture)
            self.pinch(pinch)
            return True
        return bool(super().event(event))

    def pinch(self, pinch: QPinchGesture) -> None:
        """Zoom and pan with two fingers, so that the photo stays below the fingers."""
        ends = pinch.lastCenterPoint(), pinch.centerPoint()
        before, now = (self.viewport().mapFromGlobal(end) for end in ends)
        # Qt's own factor is too large (6.11): twice as far apart count as 3.6 times. One of the
        # fingers is at the hot spot.
        apart_px = QLineF(pinch.hotSpot(), pinch.centerPoint()).length()
        if pinch.state() == Qt.GestureState.GestureStarted:
            self._apart = apart_px
        self._spread(apart_px, before)
        self.pan(before, now)

    def _spread(self, apart: float, about: QPointF) -> None:
        """Zoom as two fingers move apart; any unit of length."""
        before, self._apart = self._apart, max(apart, _LEAST_APART)
        self.zoom_to(self.zoom * self._apart / before, about)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Fit again after a resize, if fitted."""
        super().resizeEvent(event)
        if self._fitted:
            self.fit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        self.zoom_to(self.zoom * _ZOOM_PER_NOTCH ** notches(event), event.position())
        event.accept()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Start to pan."""
        self.start_pan(event.position())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Pan while the button is down."""
        if self.panning:
            self.pan_to(event.position())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: ARG002
        """End the pan."""
        self.end_pan()
        self.viewport().setCursor(Qt.CursorShape.ArrowCursor)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Handle a second click like the first: two quick drags are two drags."""
        self.mousePressEvent(event)


def notches(event: QWheelEvent) -> float:
    """Return the wheel rotation in notches; fine wheels send fractions."""
    return event.angleDelta().y() / _NOTCH


def plate_on(view: Viewport) -> QLabel:
    """Return a label at the upper left of a view; the mouse reaches the view below."""
    label = QLabel(view)
    label.setProperty("plate", "true")
    label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    label.move(_NAME_PX, _NAME_PX)
    return label


class SecondView(Viewport):
    """A second view with the zoom, centre and overlays of the main view.

    Parameters
    ----------
    main : Viewport
        The main view.
    shown : ViewState
        State of this view; the fields in `alike` are copied from the main view.
    name : str
        Accessible name.
    """

    # Fields of `ViewState` that are copied from the main view.
    alike: tuple[str, ...] = ("switched", "explained")

    def __init__(self, main: Viewport, shown: ViewState, name: str) -> None:
        super().__init__(shown)
        self.setAccessibleName(name)
        self.plate = plate_on(self)
        self._main = main
        self.setBackground(main.backgroundBrush())
        main.view_changed.connect(self._follow)
        self.hide()
        main.shown.watch(self._look_alike, *DRAWN)

    def _open(self) -> None:
        super()._open()
        self._follow()

    def showEvent(self, event: QShowEvent) -> None:
        """Follow the main view, which may have changed while this view was hidden."""
        super().showEvent(event)
        self._follow()
        self._look_alike()

    def zoom_to(self, zoom: float, about: QPointF | None = None) -> None:
        super().zoom_to(zoom, about)
        self._main.look_like(self)

    def pan(self, start: QPointF, end: QPointF) -> None:
        """Pan, and apply the pan to the main view."""
        super().pan(start, end)
        self._main.look_like(self)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Follow the main view after a resize."""
        super().resizeEvent(event)
        # The base class resizes before the attributes of this class exist.
        if hasattr(self, "_main"):
            self._follow()

    def _follow(self) -> None:
        if self.isVisible():
            self.look_like(self._main)

    def _look_alike(self) -> None:
        if self.isVisible():
            self.shown.set(**{name: getattr(self._main.shown, name) for name in self.alike})
            self._redraw()


class OriginalView(SecondView):
    """The original photo."""

    alike = (
        *SecondView.alike,
        *("frame", "pointed", "face", "hovered", "selected", "lines", "following"),
    )

    def __init__(self, main: Viewport) -> None:
        shown = ViewState(document=main.shown.document, original=True)
        super().__init__(main, shown, tr("Original photo"))
        self.plate.setText(tr("before"))


class OtherModeView(SecondView):
    """The result of the inactive mode."""

    def __init__(self, main: Viewport) -> None:
        shown = ViewState(document=main.shown.document, other_mode=True)
        super().__init__(main, shown, tr("The other way to set points"))
