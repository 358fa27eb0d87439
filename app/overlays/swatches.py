"""The mark of each overlay and domain as a small picture, for lists and legends."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import pyqtgraph as pg
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QPainter, QPen, QPixmap

from . import glyphs, maps

SIZE_PX: Final = 18
_Draw = Callable[[QPainter, QRectF], None]


def pixmap(name: str, ratio: float) -> QPixmap:
    """Return the mark of an overlay or domain at the screen's pixel `ratio`."""
    side = round(SIZE_PX * ratio)
    picture = QPixmap(side, side)
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    _MARKS[name](painter, QRectF(0, 0, SIZE_PX, SIZE_PX))
    painter.end()
    return picture


def _arrow(painter: QPainter, box: QRectF) -> None:
    y = box.center().y()
    shaft = QLineF(box.left() + 2, y, box.right() - 2, y)
    glyphs.arrow(painter, [shaft], glyphs.DISPLACEMENT)


def _lattice(painter: QPainter, box: QRectF) -> None:
    places = (box.left() + 4, box.center().x(), box.right() - 4)
    rungs = [QLineF(box.left() + 2, y, box.right() - 2, y) for y in places]
    rails = [QLineF(x, box.top() + 2, x, box.bottom() - 2) for x in places]
    glyphs.lines(painter, [*rungs, *rails], glyphs.LATTICE, 0.9)


def _domain(name: str) -> _Draw:
    return lambda painter, box: glyphs.hatched(painter, box.adjusted(2, 2, -2, -2), name)


def _domains(painter: QPainter, box: QRectF) -> None:
    for name, inset in (("control-points", 2), ("threshold", 6)):
        glyphs.hatched(painter, box.adjusted(inset, inset, -inset, -inset), name)


def _protection(painter: QPainter, box: QRectF) -> None:
    painter.setPen(QPen(glyphs.HALO, 1.4))
    painter.setBrush(glyphs.protected())
    painter.drawRoundedRect(box.adjusted(2, 4, -2, -4), 5, 5)


def _map(name: str) -> _Draw:
    def draw(painter: QPainter, box: QRectF) -> None:
        gradient = pg.colormap.get(name).getGradient(box.topLeft(), box.topRight())
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QBrush(gradient))
        painter.drawRoundedRect(box.adjusted(2, 4, -2, -4), 2, 2)

    return draw


def _straight(painter: QPainter, box: QRectF) -> None:
    slant = QLineF(box.left() + 3, box.bottom() - 4, box.right() - 3, box.top() + 4)
    glyphs.lines(painter, [slant], glyphs.BENT, 2.4)


_MARKS: Final[dict[str, _Draw]] = {
    "landmarks": lambda painter, box: glyphs.dot(painter, box.center(), glyphs.LANDMARK),
    "targets": lambda painter, box: glyphs.ring(painter, box.center(), glyphs.TARGET),
    "centre": lambda painter, box: glyphs.cross(painter, box.center(), glyphs.CENTRE, 0.9),
    "displacement": _arrow,
    "lattice": _lattice,
    "domains": _domains,
    "heat": _map(maps.HEAT),
    "jacobian": _map(maps.JACOBIAN),
    "straight": _straight,
    "protection": _protection,
    "folds": lambda painter, box: glyphs.warning(painter, box.center() + QPointF(0, 0.5)),
    **{name: _domain(name) for name in glyphs.DOMAINS},
}
