"""Marks in screen px, each told by shape as well as colour, with a dark case on any background."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Final

from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QFont, QFontMetricsF, QPainter, QPen, QPixmap, QPolygonF

from ...theme import OKABE_ITO

_HATCH_PX: Final = 64  # a multiple of the 8 px after which Qt's hatches repeat
_BESIDE_PX: Final = 14.0
SWATCH_PX: Final = 18
# Dark enough that a point with its light halo and case differs from any grey by 3 : 1 at least.
CASE: Final = QColor(0, 0, 0, 200)
HALO: Final = QColor(255, 255, 255, 230)
LANDMARK: Final = QColor(OKABE_ITO["sky"])
TARGET: Final = QColor(OKABE_ITO["vermilion"])
CENTRE: Final = QColor(OKABE_ITO["yellow"])
DISPLACEMENT: Final = QColor(OKABE_ITO["orange"])
LATTICE: Final = QColor(OKABE_ITO["purple"])
FOLD: Final = QColor(OKABE_ITO["vermilion"])
STRAIGHT: Final = QColor(OKABE_ITO["sky"])
BENT: Final = QColor(OKABE_ITO["vermilion"])
PERSON: Final = QColor(OKABE_ITO["green"])
DOMAINS: Final = {
    "image": QColor(150, 150, 150),
    "control-points": QColor(OKABE_ITO["blue"]),
    "threshold": QColor(OKABE_ITO["green"]),
}
HATCHES: Final = {
    "image": Qt.BrushStyle.Dense7Pattern,
    "control-points": Qt.BrushStyle.BDiagPattern,
    "threshold": Qt.BrushStyle.FDiagPattern,
}


def lines(
    painter: QPainter,
    segments: Sequence[QLineF],
    colour: QColor,
    width: float = 1.2,
    *,
    case: bool = True,
    style: Qt.PenStyle = Qt.PenStyle.SolidLine,
) -> None:
    """Draw segments in `colour`, inside a dark case unless they are many."""
    pens = (QPen(CASE, width + 1.6), QPen(colour, width, style))
    for pen in pens if case else pens[1:]:
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
        painter.setPen(pen)
        painter.drawLines(list(segments))


def polyline(
    painter: QPainter, points: Sequence[QPointF], colour: QColor, width: float, *, dotted: bool
) -> None:
    """Draw a line through points inside a dark case: an outline."""
    style = Qt.PenStyle.DotLine if dotted else Qt.PenStyle.SolidLine
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in (QPen(CASE, width + 1.6), QPen(colour, width, style)):
        painter.setPen(pen)
        painter.drawPolyline(list(points))


def dot(painter: QPainter, at: QPointF, colour: QColor, size: float = 1.0) -> None:
    """Draw a filled dot with a light halo in a dark case: a landmark."""
    radius = 3.5 * size
    painter.setBrush(colour)
    for pen in (QPen(CASE, 4.2 * size), QPen(HALO, 1.4 * size)):
        painter.setPen(pen)
        painter.drawEllipse(at, radius, radius)


def hollow(painter: QPainter, at: QPointF, colour: QColor, size: float = 1.0) -> None:
    """Draw a dashed circle: a landmark of low confidence."""
    radius = 4.0 * size
    painter.setBrush(Qt.BrushStyle.NoBrush)
    dots = QPen(colour, 1.6, Qt.PenStyle.DotLine)
    for pen in (QPen(CASE, 4.6 * size), QPen(HALO, 3.0 * size), dots):
        painter.setPen(pen)
        painter.drawEllipse(at, radius, radius)


def diamond(painter: QPainter, at: QPointF, colour: QColor, size: float = 1.0) -> None:
    """Draw a filled diamond with a light halo in a dark case: an eye or mouth corner."""
    radius = 4.5 * size
    steps = ((0.0, -radius), (radius, 0.0), (0.0, radius), (-radius, 0.0))
    painter.setBrush(colour)
    for pen in (QPen(CASE, 4.2 * size), QPen(HALO, 1.4 * size)):
        painter.setPen(pen)
        painter.drawPolygon(QPolygonF([at + QPointF(dx, dy) for dx, dy in steps]))


def ring(painter: QPainter, at: QPointF, colour: QColor, size: float = 1.0) -> None:
    """Draw a ring: a target."""
    radius, width = 4.5 * size, min(1.8, 2.4 * size)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in (QPen(CASE, 3.2 * width), QPen(HALO, 2.2 * width), QPen(colour, width)):
        painter.setPen(pen)
        painter.drawEllipse(at, radius, radius)


def cross(painter: QPainter, at: QPointF, colour: QColor, size: float = 1.0) -> None:
    """Draw an upright cross: the centre."""
    radius = 7.0 * size
    across, down = QPointF(radius, 0.0), QPointF(0.0, radius)
    bars = [QLineF(at - across, at + across), QLineF(at - down, at + down)]
    lines(painter, bars, colour, 2.2 * size)


def arrow(painter: QPainter, shafts: Sequence[QLineF], colour: QColor) -> None:
    """Draw arrows from the first to the second point of each line."""
    heads = []
    for shaft in shafts:
        size = min(5.0, 0.6 * shaft.length())
        for side in (-28.0, 28.0):
            barb = QLineF(shaft.p2(), shaft.p1())
            barb.setLength(size)
            barb.setAngle(barb.angle() + side)
            heads.append(barb)
    lines(painter, [*shafts, *heads], colour, 1.2)


def plate(
    font: QFont, at: QPointF, text: str, *, bold: bool = False, within: QRectF | None = None
) -> QRectF:
    """Return the plate of a label; one whose place is `within` an area lies there as a whole."""
    heavy = QFont(font)
    heavy.setBold(bold)
    metrics = QFontMetricsF(heavy)
    box = QRectF(at.x(), at.y() - metrics.height() / 2 - 1, 0, metrics.height() + 2)
    box.setWidth(metrics.horizontalAdvance(text) + 8)
    if within is not None:
        box.moveRight(min(box.right(), within.right()))
        box.moveLeft(max(box.left(), within.left()))
        box.moveBottom(min(box.bottom(), within.bottom()))
        box.moveTop(max(box.top(), within.top()))
    return box


def outward_plate(font: QFont, at: QPointF, middle: QPointF, text: str, within: QRectF) -> QRectF:
    """Return the plate of a label beside a point of a ring, away from the `middle` of the ring."""
    width = plate(font, at, text).width()
    left, below = at.x() < middle.x(), at.y() > middle.y()
    x = -_BESIDE_PX - width if left else _BESIDE_PX
    y = _BESIDE_PX if below else -_BESIDE_PX
    return plate(font, at + QPointF(x, y), text, within=within)


def label(
    painter: QPainter, at: QPointF, text: str, *, bold: bool = False, within: QRectF | None = None
) -> None:
    """Write light text on a dark plate whose left edge is at `at`, centred in height."""
    on_plate(painter, plate(painter.font(), at, text, bold=bold, within=within), text, bold=bold)


def on_plate(painter: QPainter, box: QRectF, text: str, *, bold: bool = False) -> None:
    """Write light text on a dark plate."""
    font = QFont(painter.font())
    font.setBold(bold)
    painter.setFont(font)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(0, 0, 0, 170))
    painter.drawRoundedRect(box, 3, 3)
    painter.setPen(QColor(255, 255, 255))
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)


def warning(painter: QPainter, at: QPointF, size: float = 14.0) -> None:
    """Draw a warning triangle: a folded cell."""
    half = size / 2
    steps = ((0.0, -half), (half, half * 0.8), (-half, half * 0.8))
    painter.setPen(QPen(QColor(0, 0, 0), 1.2))
    painter.setBrush(QColor(OKABE_ITO["yellow"]))
    painter.drawPolygon(QPolygonF([at + QPointF(dx, dy) for dx, dy in steps]))
    painter.setPen(QPen(QColor(0, 0, 0), 1.8))
    painter.drawLine(at - QPointF(0, half * 0.4), at + QPointF(0, half * 0.25))
    painter.drawPoint(at + QPointF(0, half * 0.58))


def swatch(draw: Callable[[QPainter, QRectF], object], ratio: float) -> QPixmap:
    """Return what `draw` makes of a small square, at the screen's pixel `ratio`."""
    side = round(SWATCH_PX * ratio)
    picture = QPixmap(side, side)
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    draw(painter, QRectF(0, 0, SWATCH_PX, SWATCH_PX))
    painter.end()
    return picture


def hatched(painter: QPainter, box: QRectF, name: str) -> None:
    """Fill a rectangle with the tint and hatch of a domain."""
    painter.setPen(QPen(DOMAINS[name], 1.4))
    painter.setBrush(brush(name))
    painter.drawRect(box)


@cache
def brush(name: str) -> QBrush:
    """Return the tint and hatch of a domain in one: filling a large region twice takes time."""
    picture = QPixmap(_HATCH_PX, _HATCH_PX)
    picture.fill(_translucent(DOMAINS[name], 26))
    painter = QPainter(picture)
    painter.fillRect(picture.rect(), QBrush(_translucent(DOMAINS[name], 110), HATCHES[name]))
    painter.end()
    return QBrush(picture)


@cache
def protected() -> QBrush:
    """Return the hatch of protected places: light on dark, so that any ground shows it."""
    picture = QPixmap(_HATCH_PX, _HATCH_PX)
    picture.fill(QColor(0, 0, 0, 70))
    painter = QPainter(picture)
    hatch = Qt.BrushStyle.DiagCrossPattern
    painter.fillRect(picture.rect(), QBrush(_translucent(HALO, 200), hatch))
    painter.end()
    return QBrush(picture)


def _translucent(colour: QColor, alpha: int) -> QColor:
    seen_through = QColor(colour)
    seen_through.setAlpha(alpha)
    return seen_through
