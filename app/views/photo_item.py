"""The photo on the canvas: painted straight from the pixel buffers, without a copy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from ..pyramid import Pyramid, Rgb8
from ..surfaces import Frame

# Larger than this, a picture's pixels are shown as squares.
_SQUARES_FROM: Final = 3.0
_EPSILON: Final = 1e-3  # px; far below what can be seen, far above rounding


class PhotoItem(pg.GraphicsObject):
    """Shows the original or the newest result: a whole one, and a gesture's preview over it."""

    def __init__(self) -> None:
        super().__init__()
        self._photo: Pyramid | None = None
        self._full: Frame | None = None
        self._preview: Frame | None = None
        self._original = False

    def open(self, photo: Pyramid) -> None:
        """Show another photo."""
        self.prepareGeometryChange()
        self._photo, self._full, self._preview = photo, None, None
        self.update()

    def show_full(self, frame: Frame) -> None:
        """Show a whole result, unless a newer preview covers it."""
        self._full = frame
        if self._preview is not None and self._preview.revision <= frame.revision:
            self._preview = None
        self.update()

    def show_preview(self, frame: Frame) -> None:
        """Show a gesture's preview, unless a newer whole result is here."""
        if self._full is None or frame.revision > self._full.revision:
            self._preview = frame
            self.update()

    def show_original(self, original: bool) -> None:
        """Show the photo as it was, or the result again."""
        self._original = original
        self.update()

    def boundingRect(self) -> QRectF:
        """Return the photo's rectangle; pixel centres lie at whole numbers."""
        if self._photo is None:
            return QRectF()
        return _rect(self._photo.levels[0], 1.0)

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionGraphicsItem,  # noqa: ARG002
        widget: QWidget | None = None,  # noqa: ARG002
    ) -> None:
        """Paint the level that fits the zoom."""
        if self._photo is None:
            return
        zoom = painter.worldTransform().m11() * painter.device().devicePixelRatioF()
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, zoom < _SQUARES_FROM)
        levels: Sequence[Rgb8] = self._photo.levels
        if self._full is not None and not self._original:
            levels = self._full.levels
        level = self._photo.level_for(zoom)
        whole = _rect(levels[level], 2.0**level)
        preview = None if self._original else self._preview
        seen = (_seen(painter) & whole).adjusted(_EPSILON, _EPSILON, -_EPSILON, -_EPSILON)
        if preview is None or not _area(preview).contains(seen):
            painter.drawImage(whole, _image(levels[level]))
        if preview is not None:
            painter.drawImage(_area(preview), _image(preview.levels[0]))


def _area(frame: Frame) -> QRectF:
    """Return where a preview lies in the photo."""
    height, width = frame.levels[0].shape[:2]
    left, top = frame.to_photo([-0.5, -0.5]).tolist()
    return QRectF(left, top, width * frame.scale, height * frame.scale)


def _seen(painter: QPainter) -> QRectF:
    """Return the part of the photo's plane that the painter can reach."""
    to_photo, _ = painter.worldTransform().inverted()
    return to_photo.mapRect(QRectF(painter.viewport()))


def _rect(pixels: Rgb8, scale: float) -> QRectF:
    return QRectF(-0.5, -0.5, pixels.shape[1] * scale, pixels.shape[0] * scale)


def _image(pixels: Rgb8) -> QImage:
    height, width = pixels.shape[:2]
    return QImage(pixels.data, width, height, pixels.strides[0], QImage.Format.Format_RGB888)
