"""The photo as it was, beside the canvas, always at the same place and zoom."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QResizeEvent
from PySide6.QtWidgets import QLabel, QWidget

from ..i18n import tr
from ..pyramid import Pyramid
from ..scene import Scene
from .viewport import Viewport

_NAME_PX: Final = 12


class Twin(Viewport):
    """A second view that leads and follows the first one.

    Parameters
    ----------
    main : Viewport
        The first one.
    """

    _steered = Signal()

    def __init__(self, main: Viewport, parent: QWidget | None = None) -> None:
        super().__init__(Scene(original=True), parent)
        self.setAccessibleName(tr("Photo as it was"))
        self._main = main
        main.view_changed.connect(self._follow)
        self._steered.connect(lambda: main.look_like(self))
        name = QLabel(tr("before"), self)
        name.setProperty("plate", "true")
        name.move(_NAME_PX, _NAME_PX)
        self.hide()

    def open(self, photo: Pyramid) -> None:
        """Show another photo."""
        super().open(photo)
        self._follow()

    def zoom_to(self, zoom: float, about: QPointF | None = None) -> None:
        """Zoom, and take the other view along."""
        super().zoom_to(zoom, about)
        self._steered.emit()

    def pan_to(self, at: QPointF) -> None:
        """Pan, and take the other view along."""
        super().pan_to(at)
        self._steered.emit()

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
