"""The view of the photo: what is seen, at which zoom, with panning."""

from __future__ import annotations

from typing import Final

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QResizeEvent, QTransform, QWheelEvent
from PySide6.QtWidgets import QGraphicsView, QLabel

from kogao_core.base.geometry import Array

from ..i18n import tr
from ..render.pictures import PicturePyramid
from ..view_state import RenderedFrame, ViewState, VisiblePart
from .overlays.overlay import Layers
from .overlays.unlisted import Loupe, stack
from .photo_layer import PhotoItem, pixels_in

_LARGEST_ZOOM: Final = 32.0
_LEAST_SEEN_PX: Final = 16.0
_ZOOM_PER_NOTCH: Final = 1.25
_NOTCH: Final = 120.0
_FIT_PADDING: Final = 0.02
# Pixels a little outside the view may be pulled in while a gesture moves.
_PREVIEW_MARGIN_PX: Final = 48
_NAME_PX: Final = 12


class Viewport(pg.GraphicsView):
    """Shows the photo with its overlays; the wheel zooms at the cursor, a drag pans.

    Signals
    -------
    view_changed
        Another part or another zoom.
    redrawn
        The overlays are drawn again.
    """

    view_changed = Signal()
    redrawn = Signal()
    _fitted = False  # here, as the base class resizes before there is anything to fit

    def __init__(self, view: ViewState) -> None:
        super().__init__(useOpenGL=False)
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.shown = view
        self.photo = PhotoItem(view)
        self._fitted = True
        self._pan_from: QPointF | None = None
        self._box = pg.ViewBox(
            lockAspect=True, invertY=True, enableMenu=False, enableMouse=False, defaultPadding=0.0
        )
        self.setCentralItem(self._box)
        self._box.addItem(self.photo, ignoreBounds=True)
        layers = Layers(view, [*stack(view), Loupe(view, self.photo)])
        self._box.addItem(layers, ignoreBounds=True)
        self._box.sigRangeChanged.connect(self.view_changed)

    def open(self, photo: PicturePyramid) -> None:
        """Show another photo, whole."""
        self.photo.open(photo)
        self.fit()

    def fit(self) -> None:
        """Show the whole photo, also after the window changes its size."""
        self._fitted = True
        if self.photo.pyramid is not None:
            self._box.setRange(self.photo.boundingRect(), padding=_FIT_PADDING)

    def zoom_to(self, zoom: float, about: QPointF | None = None) -> None:
        """Show `zoom` device px per photo px; the point `about` of the viewport stays in place."""
        if self.photo.pyramid is None:
            return
        self._fitted = False
        least = _LEAST_SEEN_PX / max(self.photo.pyramid.levels[0].shape[:2])
        factor = self.zoom / min(max(zoom, least), _LARGEST_ZOOM)
        center = self.to_photo(about or QPointF(self.viewport().rect().center())).tolist()
        self._box.scaleBy((factor, factor), center=pg.Point(*center))

    def look_at(self, area: QRectF) -> None:
        """Show a part of the photo, px, as large as it fits."""
        self._fitted = False
        self._box.setRange(area, padding=0.0)

    def look_like(self, other: Viewport) -> None:
        """Show the same place at the same zoom as another view."""
        scale = self.devicePixelRatioF() / other.zoom
        width, height = scale * self._box.width(), scale * self._box.height()
        x, y = other.to_photo(QPointF(other.viewport().rect().toRectF().center())).tolist()
        self.look_at(QRectF(x - width / 2, y - height / 2, width, height))

    @property
    def zoom(self) -> float:
        """Device px per photo px."""
        return float(self._to_screen().m11() * self.devicePixelRatioF())

    def visible_part(self) -> VisiblePart | None:
        """Return the part of the photo on screen, with a margin, at the level that fits."""
        if self.photo.pyramid is None:
            return None
        level = self.photo.pyramid.level_for(self.zoom)
        pixels = self.photo.pyramid.levels[level]
        box = pixels_in(self._box.viewRect(), pixels, level, _PREVIEW_MARGIN_PX)
        return VisiblePart(level, box) if box.area else None

    def show_original(self, original: bool) -> None:
        """Show the photo as it was, under the same overlays, or the result again."""
        self.shown.original = original
        self.redraw()

    def show_overlay(self, name: str, on: bool) -> None:
        """Switch an overlay on or off."""
        (self.shown.switched.add if on else self.shown.switched.discard)(name)
        self.redraw()

    def redraw(self) -> None:
        """Draw the overlays again."""
        self.viewport().update()
        self.redrawn.emit()

    def to_photo(self, at: QPointF) -> Array:
        """Return where a point of the viewport lies in the photo, px, shape (2,)."""
        there = self._to_screen().inverted()[0].map(at)
        return np.array([there.x(), there.y()])

    def to_screen(self, position: Array) -> QPointF:
        """Return where a point of the photo, shape (2,), lies in the viewport."""
        x, y = position.tolist()
        return self._to_screen().map(QPointF(x, y))

    def _to_screen(self) -> QTransform:
        self._box.updateMatrix()
        transform: QTransform = self._box.childGroup.sceneTransform() * self.viewportTransform()
        return transform

    def start_pan(self, at: QPointF) -> None:
        """Begin to drag the photo under the cursor."""
        self._pan_from = at
        self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)

    @property
    def panning(self) -> bool:
        """True while the photo is dragged."""
        return self._pan_from is not None

    def pan_to(self, at: QPointF) -> None:
        """Move the photo along with the cursor."""
        if self._pan_from is not None:
            self._fitted = False
            x, y = (self.to_photo(self._pan_from) - self.to_photo(at)).tolist()
            self._box.translateBy(x=x, y=y)
            self._pan_from = at

    def end_pan(self) -> None:
        """Let the photo go."""
        self._pan_from = None

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep a fitted photo fitted."""
        super().resizeEvent(event)
        if self._fitted:
            self.fit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom at the cursor."""
        self.zoom_to(self.zoom * _ZOOM_PER_NOTCH ** notches(event), event.position())
        event.accept()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Treat a second click like a first one: two quick drags are two drags."""
        self.mousePressEvent(event)


def notches(event: QWheelEvent) -> float:
    """Return how far a wheel was turned; fine wheels turn by parts of a notch."""
    return event.angleDelta().y() / _NOTCH


class SecondView(Viewport):
    """A second view that leads and follows the first one, under the same overlays.

    Parameters
    ----------
    main : Viewport
        The first one.
    shown : ViewState
        What it shows; overlays and the like it takes from the first one.
    name : str
        What it shows, for screen readers.
    """

    # What both show alike, fields of `ViewState`.
    alike: tuple[str, ...] = ("switched", "explained")

    def __init__(self, main: Viewport, shown: ViewState, name: str) -> None:
        super().__init__(shown)
        self.setAccessibleName(name)
        self.plate = QLabel(self)
        self.plate.setProperty("plate", "true")
        self.plate.move(_NAME_PX, _NAME_PX)
        self._main = main
        self.setBackground(main.backgroundBrush())
        main.view_changed.connect(self._follow)
        main.redrawn.connect(self._look_alike)
        self.hide()

    def open(self, photo: PicturePyramid) -> None:
        """Show another photo."""
        super().open(photo)
        self._follow()

    def zoom_to(self, zoom: float, about: QPointF | None = None) -> None:
        """Zoom, and take the other view along."""
        super().zoom_to(zoom, about)
        self._main.look_like(self)

    def pan_to(self, at: QPointF) -> None:
        """Pan, and take the other view along."""
        super().pan_to(at)
        self._main.look_like(self)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take hold of the photo."""
        self.start_pan(event.position())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Pan while it is held."""
        if self.panning:
            self.pan_to(event.position())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: ARG002
        """Let go."""
        self.end_pan()
        self.viewport().setCursor(Qt.CursorShape.ArrowCursor)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Stay where the other view is."""
        super().resizeEvent(event)
        # The base class resizes before this one's attributes exist.
        if hasattr(self, "_main"):
            self._follow()

    def _follow(self) -> None:
        if self.isVisible():
            self.look_like(self._main)

    def _look_alike(self) -> None:
        if self.isVisible():
            for name in self.alike:
                setattr(self.shown, name, getattr(self._main.shown, name))
            self.redraw()


class OriginalView(SecondView):
    """The photo as it was."""

    alike = (
        *SecondView.alike,
        *("frame", "pointed", "face", "hovered", "selected", "lines", "people", "following"),
    )

    def __init__(self, main: Viewport) -> None:
        shown = ViewState(main.shown.document, original=True)
        super().__init__(main, shown, tr("Photo as it was"))
        self.plate.setText(tr("before"))


class OtherModeView(SecondView):
    """What the mode that isn't at work makes of the photo."""

    def __init__(self, main: Viewport) -> None:
        shown = ViewState(main.shown.document, other_mode=True)
        super().__init__(main, shown, tr("The other way to set points"))

    def show_frame(self, frame: RenderedFrame) -> None:
        """Show a whole result."""
        self.photo.show_full(frame)
        self.shown.frame = frame
        self.redraw()
