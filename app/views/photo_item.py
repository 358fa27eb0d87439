"""The photo on the canvas: before, after, or both, as the scene says."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainter, QTransform
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from ..overlays.base import viewport_of
from ..pyramid import Pyramid
from ..scene import Scene
from ..surfaces import Frame
from .pictures import Pictures


class PhotoItem(pg.GraphicsObject):
    """Shows the original, the newest result, or how they compare.

    Parameters
    ----------
    scene : Scene
        Whether the original is held, and how it is compared.
    """

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self._scene = scene
        self.pictures = Pictures()

    def open(self, photo: Pyramid) -> None:
        """Show another photo."""
        self.prepareGeometryChange()
        self.pictures.open(photo)
        self.update()

    def show_full(self, frame: Frame) -> None:
        """Show a whole result, unless a newer preview covers it."""
        self.pictures.take_full(frame)
        self.update()

    def show_preview(self, frame: Frame) -> bool:
        """Show a gesture's preview; return False when a newer whole result is here."""
        taken = self.pictures.take_preview(frame)
        if taken:
            self.update()
        return taken

    def boundingRect(self) -> QRectF:
        """Return the photo's rectangle."""
        return self.pictures.area

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionGraphicsItem,  # noqa: ARG002
        widget: QWidget | None = None,
    ) -> None:
        """Paint what the scene asks for."""
        if self._scene.original:
            self.pictures.draw_original(painter)
        elif self._scene.compare == "difference":
            self.pictures.draw_difference(painter)
        else:
            self.pictures.draw_result(painter)
            if self._scene.compare == "wipe":
                self._draw_before(painter, viewport_of(painter, widget))

    def _draw_before(self, painter: QPainter, left: QRectF) -> None:
        """Paint the original left of the divider, which stands on screen px."""
        painter.save()
        in_photo = painter.worldTransform()
        painter.setWorldTransform(QTransform())
        left.setWidth(round(self._scene.wipe * left.width()))
        painter.setClipRect(left)
        painter.setWorldTransform(in_photo)
        self.pictures.draw_original(painter)
        painter.restore()
