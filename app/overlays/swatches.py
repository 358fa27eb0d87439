"""The mark of each overlay and domain as a small picture, for lists and legends."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPixmap

from . import glyphs

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


_MARKS: Final[dict[str, _Draw]] = {
    "landmarks": lambda painter, box: glyphs.dot(painter, box.center(), glyphs.LANDMARK),
    "targets": lambda painter, box: glyphs.ring(painter, box.center(), glyphs.TARGET),
    "centre": lambda painter, box: glyphs.cross(painter, box.center(), glyphs.CENTRE, 0.9),
    "displacement": _arrow,
    "lattice": _lattice,
    "domains": _domains,
    "folds": lambda painter, box: glyphs.warning(painter, box.center() + QPointF(0, 0.5)),
    **{name: _domain(name) for name in glyphs.DOMAINS},
}
