"""The photo on the canvas: original, result or comparison, per `ViewState`.

A checkerboard with squares in screen px shows transparency.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QBrush, QColor, QGuiApplication, QPainter, QPixmap, QTransform
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from kogao_core.base.display import Rgb8
from kogao_core.base.geometry import Box

from ..pyramid import PicturePyramid
from ..render.pictures import qt_image
from ..view_state import GAIN, RenderedFrame, ViewState
from .overlays.overlay import viewport_of

# Device px per photo px above which pixels are drawn as squares, without smoothing.
_SQUARES_FROM: Final = 3.0
_COLOURS: Final = 3
_SQUARE_PX: Final = 8
_MORE_PX: Final = 2
_EPSILON: Final = 1e-3  # px; far below what can be seen, far above rounding


class PhotoItem(pg.GraphicsObject):
    """Draws the original, the newest result, or a comparison."""

    def __init__(self, view: ViewState) -> None:
        super().__init__()
        self._view = view
        self.open()

    @property
    def pyramid(self) -> PicturePyramid | None:
        return self._view.document.pyramid

    @property
    def _preview(self) -> RenderedFrame | None:
        """The newest frame, while newer than the full result."""
        return None if self._view.frame is self._view.full else self._view.frame

    def open(self) -> None:
        """Show the photo that was opened or converted to other colours."""
        self.prepareGeometryChange()
        self.update()

    def boundingRect(self) -> QRectF:
        return QRectF() if self.pyramid is None else _in_photo(Box.of(self.pyramid.shown[0]), 1.0)

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionGraphicsItem,  # noqa: ARG002
        widget: QWidget | None = None,
    ) -> None:
        """Paint the original, the difference or the result, per `ViewState`."""
        if self._view.shows_original:
            self.draw_original(painter)
        elif self._view.compare == "difference":
            self._draw_difference(painter)
        else:
            self.draw_result(painter)
            if self._view.compare == "wipe":
                self._draw_before(painter, viewport_of(painter, widget))

    def _draw_before(self, painter: QPainter, left: QRectF) -> None:
        """Paint the original left of the divider, at a whole screen px."""
        painter.save()
        in_photo = painter.worldTransform()
        painter.setWorldTransform(QTransform())
        left.setWidth(round(self._view.wipe * left.width()))
        painter.setClipRect(left)
        painter.setWorldTransform(in_photo)
        copy = self._view.retouched
        if copy is None:
            self.draw_original(painter)
        else:
            _draw_level(painter, copy.picture, copy.picture.shown)
        painter.restore()

    def draw_original(self, painter: QPainter) -> None:
        """Paint the original, from the pyramid level for the zoom."""
        if self.pyramid is not None:
            _draw_level(painter, self.pyramid, self.pyramid.shown)

    def draw_result(self, painter: QPainter) -> None:
        if self.pyramid is None:
            return
        preview, photo = self._preview, self.boundingRect()
        seen = (_seen(painter) & photo).adjusted(_EPSILON, _EPSILON, -_EPSILON, -_EPSILON)
        if preview is None or not _area(preview).contains(seen):
            full = self._view.full
            levels = self.pyramid.shown if full is None else full.levels
            _draw_level(painter, self.pyramid, levels)
        if preview is not None:
            _lay_board(painter, _area(preview), preview.levels[0])
            _draw_pixels(painter, _area(preview), preview.levels[0])

    def _draw_difference(self, painter: QPainter) -> None:
        """Paint the absolute difference times `GAIN`; unchanged pixels are black."""
        if self.pyramid is None:
            return
        painter.fillRect(self.boundingRect(), QColor(0, 0, 0))
        if self._view.full is not None:
            level = self.pyramid.level_for(_zoom(painter))
            before, after = self.pyramid.shown[level], self._view.full.levels[level]
            box = pixels_in(_seen(painter), before, level, _MORE_PX)
            _draw_change(painter, before, after, box, box, 2.0**level)
        preview = self._preview
        if preview is not None and preview.part is not None:
            before, after = self.pyramid.shown[preview.part.level], preview.levels[0]
            there, inside = preview.part.box, Box.of(after)
            _draw_change(painter, before, after, there, inside, preview.scale)


def _draw_level(painter: QPainter, photo: PicturePyramid, levels: Sequence[Rgb8]) -> None:
    _lay_board(painter, _in_photo(Box.of(levels[0]), 1.0), levels[0])
    level = photo.level_for(_zoom(painter))
    _draw_pixels(painter, _in_photo(Box.of(levels[level]), 2.0**level), levels[level])


def _lay_board(painter: QPainter, area: QRectF, pixels: Rgb8) -> None:
    """Paint the checkerboard under pixels with an alpha channel."""
    if pixels.shape[2] > _COLOURS:
        painter.save()
        on_screen = painter.worldTransform().mapRect(area)
        painter.setWorldTransform(QTransform())
        painter.fillRect(on_screen, QBrush(_board()))
        painter.restore()


def _draw_change(
    painter: QPainter, before: Rgb8, after: Rgb8, there: Box, inside: Box, scale: float
) -> None:
    """Paint the difference between `there` of `before` and `inside` of `after`."""
    if not there.area:
        return
    apart = cv2.absdiff(after[inside.slices], before[there.slices])
    if apart.shape[2] > _COLOURS:
        # Show a change of alpha in all colours.
        apart = np.maximum(apart[..., :_COLOURS], apart[..., _COLOURS:])
    shown = np.asarray(cv2.convertScaleAbs(apart, alpha=GAIN), np.uint8)
    _draw_pixels(painter, _in_photo(there, scale), shown)


def _zoom(painter: QPainter) -> float:
    """Return device px per photo px."""
    return painter.worldTransform().m11() * painter.device().devicePixelRatioF()


def _draw_pixels(painter: QPainter, area: QRectF, pixels: Rgb8) -> None:
    # At 100 % each pixel covers one screen pixel: smoothing would only blur.
    smooth = _zoom(painter) < _SQUARES_FROM and abs(_zoom(painter) - 1.0) > _EPSILON
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, smooth)
    painter.drawImage(area, qt_image(pixels))


def pixels_in(area: QRectF, pixels: Rgb8, level: int, margin_px: int) -> Box:
    """Return the pixels of a level in an area of the photo, plus a margin."""
    edges = np.round(np.array(area.getCoords()) / 2**level).astype(int)
    return Box(*edges.tolist()).grown(margin_px).clipped(Box.of(pixels))


def _area(frame: RenderedFrame) -> QRectF:
    """Return the area of a preview in the photo, px."""
    return QRectF() if frame.part is None else _in_photo(frame.part.box, frame.scale)


def _seen(painter: QPainter) -> QRectF:
    """Return the visible part of the photo's plane, px of the photo."""
    to_photo, _ = painter.worldTransform().inverted()
    return to_photo.mapRect(QRectF(painter.viewport()))


def _in_photo(box: Box, scale: float) -> QRectF:
    """Return the photo area of a box of a level. Pixel centres have integer coordinates."""
    left, top = scale * box.left - 0.5, scale * box.top - 0.5
    return QRectF(left, top, scale * box.width, scale * box.height)


def _board() -> QPixmap:
    """Return four squares of the checkerboard, in two greys of the palette."""
    palette, board = QGuiApplication.palette(), QPixmap(2 * _SQUARE_PX, 2 * _SQUARE_PX)
    board.fill(palette.mid().color())
    painter = QPainter(board)
    for corner in (0, _SQUARE_PX):
        painter.fillRect(corner, corner, _SQUARE_PX, _SQUARE_PX, palette.window())
    painter.end()
    return board
