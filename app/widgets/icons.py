"""Icons of the toolbar: strokes on a grid of 20, in the colour that a theme gives to text."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QImage, QPainter, QPainterPath, QPen, QPixmap

from ..theme import Theme

GRID: Final = 20
_BESIDE: Final = 2  # room to either side, so that a word keeps its distance
SIZE: Final = (GRID + 2 * _BESIDE, GRID)
_STROKE: Final = 1.6
_RATIOS: Final = (1, 2, 3)  # pixels of the screen to one of the window's


def icon(name: str, theme: Theme) -> QIcon:
    """Return an icon of `DRAWN` that suits a theme: plain, switched off, and pressed."""
    made, modes, states = QIcon(), QIcon.Mode, QIcon.State
    for mode, state, colour in (
        (modes.Normal, states.Off, theme.text),
        (modes.Disabled, states.Off, theme.muted),
        (modes.Normal, states.On, theme.on_accent),
    ):
        for ratio in _RATIOS:
            made.addPixmap(QPixmap.fromImage(_drawn(name, colour, ratio)), mode, state)
    return made


@cache
def _drawn(name: str, colour: str, ratio: int) -> QImage:
    width, height = (side * ratio for side in SIZE)
    picture = QImage(width, height, QImage.Format.Format_ARGB32_Premultiplied)
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    pen = QPen(QColor(colour), _STROKE)
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    painter.setPen(pen)
    painter.translate(_BESIDE, 0)
    DRAWN[name](painter)
    painter.end()
    return picture


def _line(painter: QPainter, *points: tuple[float, float]) -> None:
    painter.drawPolyline([QPointF(x, y) for x, y in points])


def _open(painter: QPainter) -> None:
    _line(painter, (2.5, 15.5), (2.5, 4.5), (7.5, 4.5), (9.5, 6.5), (15.5, 6.5), (15.5, 9))
    _line(painter, (2.5, 15.5), (5.5, 9), (18, 9), (15, 15.5), (2.5, 15.5))


def _save(painter: QPainter) -> None:
    _line(painter, (10, 3), (10, 12))
    _line(painter, (6.5, 8.5), (10, 12), (13.5, 8.5))
    _line(painter, (3, 12.5), (3, 16.5), (17, 16.5), (17, 12.5))


def _undo(painter: QPainter) -> None:
    _line(painter, (7, 4), (3, 8), (7, 12))
    path = QPainterPath(QPointF(3, 8))
    path.lineTo(12, 8)
    path.arcTo(QRectF(8, 8, 8.5, 8.5), 90, -180)
    path.lineTo(8, 16.5)
    painter.drawPath(path)


def _redo(painter: QPainter) -> None:
    painter.translate(GRID, 0)
    painter.scale(-1, 1)
    _undo(painter)


def _fit(painter: QPainter) -> None:
    for x, right in ((3.0, 1), (17.0, -1)):
        for y, down in ((4.0, 1), (16.0, -1)):
            _line(painter, (x, y + 4 * down), (x, y), (x + 4 * right, y))


def _actual(painter: QPainter) -> None:
    for x in (5.0, 15.5):
        _line(painter, (x - 2, 6.5), (x, 4.5), (x, 15.5))
    for y in (8.0, 12.5):
        painter.drawPoint(QPointF(9.8, y))


def _before(painter: QPainter) -> None:
    path = QPainterPath(QPointF(2, 10))
    path.quadTo(10, 1.5, 18, 10)
    path.quadTo(10, 18.5, 2, 10)
    painter.drawPath(path)
    painter.drawEllipse(QPointF(10, 10), 2.6, 2.6)


def _hide(painter: QPainter) -> None:
    for x, y in ((3.5, 5), (4.5, 10.5), (8, 15), (12.5, 15), (16, 10.5), (17, 5)):
        painter.drawEllipse(QPointF(x, y), 0.7, 0.7)
    _line(painter, (3.5, 17), (16.5, 3))


def _frame(painter: QPainter, left: float, width: float) -> None:
    painter.drawRoundedRect(QRectF(left, 4, width, 12), 1.5, 1.5)


def _wipe(painter: QPainter) -> None:
    _frame(painter, 2.5, 15)
    _line(painter, (10, 2), (10, 18))
    painter.setBrush(painter.pen().color())
    painter.drawEllipse(QPointF(10, 10), 1.4, 1.4)


def _side(painter: QPainter) -> None:
    _frame(painter, 2, 7)
    _frame(painter, 11, 7)


def _difference(painter: QPainter) -> None:
    left, right = QPainterPath(), QPainterPath()
    left.addEllipse(QPointF(7.5, 10), 5.2, 5.2)
    right.addEllipse(QPointF(12.5, 10), 5.2, 5.2)
    painter.drawPath(left)
    painter.drawPath(right)
    painter.fillPath(left & right, painter.pen().color())


def _loupe(painter: QPainter) -> None:
    painter.drawEllipse(QPointF(8.5, 8.5), 5.2, 5.2)
    _line(painter, (12.4, 12.4), (17, 17))


def _found(painter: QPainter) -> None:
    for x, y, size in ((8.0, 11.5, 5.5), (15.0, 5.0, 3.0)):
        path = QPainterPath(QPointF(x, y - size))
        for dx, dy in ((size, 0), (0, size), (-size, 0), (0, -size)):
            path.quadTo(x, y, x + dx, y + dy)
        painter.drawPath(path)


def _by_hand(painter: QPainter) -> None:
    _line(painter, (3, 17), (4, 13), (13.5, 3.5), (16.5, 6.5), (7, 16), (3, 17))
    _line(painter, (11.5, 5.5), (14.5, 8.5))


def _brush(painter: QPainter) -> None:
    _line(painter, (16.5, 3.5), (9.5, 10.5))
    painter.drawEllipse(QPointF(6.5, 13.5), 3.6, 3.6)


def _push(painter: QPainter) -> None:
    painter.drawEllipse(QPointF(5.5, 10), 3.6, 3.6)
    _line(painter, (9.1, 10), (17.5, 10))
    _line(painter, (14, 6.5), (17.5, 10), (14, 13.5))


def _restore(painter: QPainter) -> None:
    painter.drawArc(QRectF(3.5, 3.5, 13, 13), 150 * 16, 290 * 16)
    _line(painter, (3, 2.5), (4.2, 6.9), (8.6, 5.7))
    painter.drawEllipse(QPointF(10, 10), 1.6, 1.6)


def _more(painter: QPainter) -> None:
    for x in (5.0, 10.5):
        _line(painter, (x, 6), (x + 4, 10), (x, 14))


# By the names of their actions; "more" leads to the tools for which there is no room.
DRAWN: Final[dict[str, Callable[[QPainter], None]]] = {
    "open": _open,
    "save": _save,
    "undo": _undo,
    "redo": _redo,
    "fit": _fit,
    "actual": _actual,
    "hold-original": _before,
    "hide-overlays": _hide,
    "compare-wipe": _wipe,
    "compare-side": _side,
    "compare-difference": _difference,
    "loupe": _loupe,
    "mode-automatic": _found,
    "mode-manual": _by_hand,
    "tool-push": _push,
    "tool-restore": _restore,
    "tool-brush": _brush,
    "more": _more,
}
