"""Marks in screen px, each told by shape as well as colour, light in a dark case on any photo."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import starmap
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt
from PySide6.QtCore import QLine, QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import (
    QBrush,
    QColor,
    QFont,
    QFontMetricsF,
    QPainter,
    QPainterPath,
    QPen,
    QPixmap,
    QPolygonF,
)

from kogao_core.base.geometry import Affine, Array

from ...theme import OKABE_ITO

_BESIDE_PX: Final = 14.0
SWATCH_PX: Final = 18
# Dark enough that a mark with something light in it differs from any grey by 3 : 1 at least.
CASE: Final = QColor(0, 0, 0, 230)
_CASE_PX: Final = 1.1  # on either side of a line
WIDTH_PX: Final = 1.4
_FINE_PX: Final = 1.0
_HEAD_TURN: Final = np.deg2rad(28.0)
PLATE: Final = QColor(0, 0, 0, 170)
HALO: Final = QColor(255, 255, 255, 230)
LANDMARK: Final = QColor(OKABE_ITO["sky"])
TARGET: Final = QColor(OKABE_ITO["vermilion"])
CENTRE: Final = QColor(OKABE_ITO["yellow"])
CHECK: Final = QColor(OKABE_ITO["orange"])
FOLD: Final = QColor(OKABE_ITO["vermilion"])
# The reduced domain is filled so softly that the photo stays visible.
DOMAIN: Final = QColor(0, 158, 115, 40)


def translucent(colour: QColor, alpha: int) -> QColor:
    """Return a colour with an opacity of 0 to 255."""
    return QColor(colour.red(), colour.green(), colour.blue(), alpha)


# Lines have no room for a halo: the palette's colours, mixed with white to a luminance of 0.5.
OUTLINE: Final = QColor("#7dc5ee")
WAY: Final = QColor("#eab082")
DISPLACEMENT: Final = QColor("#ebb336")
LATTICE: Final = QColor("#e0afca")
STRAIGHT: Final = OUTLINE
TURNED: Final = WAY
READ: Final = QColor("#78ccb5")
DOMAIN_EDGES: Final = {
    "image": (QColor("#bcbcbc"), Qt.PenStyle.DotLine),
    "control-points": (QColor("#94c4df"), Qt.PenStyle.DashLine),
    "threshold": (READ, Qt.PenStyle.SolidLine),
}


def _cased(colour: QColor, width: float, style: Qt.PenStyle) -> tuple[QPen, QPen]:
    """Return two pens for a line: the dark case, then the coloured line."""
    return QPen(CASE, width + 2 * _CASE_PX), QPen(colour, width, style)


def on_rows(painter: QPainter, points: npt.ArrayLike, width: float = WIDTH_PX) -> Array:
    """Move points so that a line between them ends at device pixel edges.

    `points` (..., 2) px. Result (..., 2).
    """
    device = painter.deviceTransform()
    scale, shift = np.array([(device.m11(), device.m22()), (device.dx(), device.dy())])
    edges = (np.asarray(points) + width / 2) * scale + shift
    return np.asarray((np.rint(edges) - shift) / scale - width / 2)


def _seen(painter: QPainter, segments: npt.ArrayLike, width: float) -> Array:
    """Return segments; horizontal and vertical segments (within 1 px) are aligned `on_rows`."""
    ends = np.asarray(segments, float).reshape(-1, 2, 2)
    crosses = np.ptp(ends, axis=1, keepdims=True) >= 1.0
    return np.where(crosses, ends, on_rows(painter, ends, width))


def _draw(painter: QPainter, pen: QPen, segments: Array) -> None:
    pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    painter.setPen(pen)
    painter.drawLines(list(starmap(QLineF, segments.reshape(-1, 4).tolist())))


def lines(
    painter: QPainter,
    segments: npt.ArrayLike,
    colour: QColor,
    width: float = WIDTH_PX,
    *,
    style: Qt.PenStyle = Qt.PenStyle.SolidLine,
) -> None:
    """Draw segments, shape (N, 2, 2), in a light `colour` with a dark outline."""
    seen = _seen(painter, segments, width)
    for pen in _cased(colour, width, style):
        _draw(painter, pen, seen)


def fine_lines(painter: QPainter, segments: npt.ArrayLike, colour: QColor) -> None:
    """Draw many nearly horizontal or vertical segments in a light `colour`, each with a shadow.

    A case on both sides would hide too much of the photo.
    """
    seen = _seen(painter, segments, _FINE_PX)
    _draw(painter, QPen(CASE, _FINE_PX), seen + _FINE_PX)
    _draw(painter, QPen(colour, _FINE_PX), seen)


def ticks(line: Array, at: npt.ArrayLike, half_px: float) -> Array:
    """Return segments of shape (N, 2, 2) across a line, shape (2, 2), at points of shape (N, 2)."""
    x, y = line[1] - line[0]
    step = half_px * np.array([-y, x]) / max(np.hypot(x, y), 1e-9)
    return np.stack([at - step, at + step], axis=1)


def polyline(
    painter: QPainter, points: Sequence[QPointF], colour: QColor, width: float, *, dotted: bool
) -> None:
    """Draw an outline through points in a light `colour`, with a dark outline."""
    style = Qt.PenStyle.DotLine if dotted else Qt.PenStyle.SolidLine
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in _cased(colour, width, style):
        painter.setPen(pen)
        painter.drawPolyline(list(points))


def _circle(painter: QPainter, at: QPointF, radius: float, *pens: QPen) -> None:
    for pen in pens:
        painter.setPen(pen)
        painter.drawEllipse(at, radius, radius)


def dot(painter: QPainter, at: QPointF, colour: QColor, size: float = 1.0) -> None:
    """Draw a filled dot with a light halo in a dark case: a landmark."""
    painter.setBrush(colour)
    _circle(painter, at, 3.5 * size, QPen(CASE, 4.2 * size), QPen(HALO, 1.4 * size))


def hollow(painter: QPainter, at: QPointF, colour: QColor, size: float = 1.0) -> None:
    """Draw a dashed circle: a landmark of low confidence."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    dots = QPen(colour, 1.6, Qt.PenStyle.DotLine)
    _circle(painter, at, 4.0 * size, QPen(CASE, 4.6 * size), QPen(HALO, 3.0 * size), dots)


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
    width = min(1.8, 2.4 * size)
    pens = QPen(CASE, 3.2 * width), QPen(HALO, 2.2 * width), QPen(colour, width)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    _circle(painter, at, 4.5 * size, *pens)


def cross(painter: QPainter, at: QPointF, colour: QColor, size: float = 1.0) -> None:
    """Draw an upright cross: the centre."""
    radius = 7.0 * size
    reach = np.array([[(-radius, 0.0), (radius, 0.0)], [(0.0, -radius), (0.0, radius)]])
    lines(painter, reach + at.toTuple(), colour, 2.2 * size)


def arrow(painter: QPainter, shafts: npt.ArrayLike, colour: QColor) -> None:
    """Draw arrows from the first to the second point of each segment, shape (N, 2, 2)."""
    starts, tips = np.moveaxis(np.asarray(shafts, float), 1, 0)
    back = starts - tips
    length = np.hypot(back[:, 0], back[:, 1])[:, np.newaxis]
    back *= np.minimum(5.0 / length, 0.6)
    across = np.sin(_HEAD_TURN) * back[:, ::-1] * (1.0, -1.0)
    along = tips + np.cos(_HEAD_TURN) * back
    barbs = [np.stack([tips, along + side * across], axis=1) for side in (-1.0, 1.0)]
    lines(painter, np.concatenate([np.asarray(shafts), *barbs]), colour)


def plate(
    font: QFont, at: QPointF, text: str, *, bold: bool = False, within: QRectF | None = None
) -> QRectF:
    """Return the rectangle of a label, moved inside `within` if given."""
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
    """Return the rectangle of a label at a point of a ring, on the side away from `middle`."""
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


def ground(painter: QPainter, box: QRectF, radius: float) -> None:
    """Draw a dark plate."""
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(PLATE)
    painter.drawRoundedRect(box, radius, radius)


def on_plate(painter: QPainter, box: QRectF, text: str, *, bold: bool = False) -> None:
    """Write light text on a dark plate."""
    font = QFont(painter.font())
    font.setBold(bold)
    painter.setFont(font)
    ground(painter, box, 3)
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
    """Draw a small square with `draw`, at the screen's pixel `ratio`, and return the picture."""
    side = round(SWATCH_PX * ratio)
    picture = QPixmap(side, side)
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    draw(painter, QRectF(0, 0, SWATCH_PX, SWATCH_PX))
    painter.end()
    return picture


def domain_edge(painter: QPainter, path: QPainterPath, name: str) -> None:
    """Draw the edge of a domain: solid if reduced, dashed for the cells, dotted for the photo."""
    colour, style = DOMAIN_EDGES[name]
    outlined(painter, path, colour, 1.0, style=style)


def domain_mark(name: str) -> Callable[[QPainter, QRectF], None]:
    """Return a function that draws fill and edge of a domain into a small square."""

    def draw(painter: QPainter, box: QRectF) -> None:
        inner = box.adjusted(2.5, 2.5, -2.5, -2.5)
        if name == "threshold":
            painter.fillRect(inner, translucent(DOMAIN, 150))
        domain_edge(painter, framed(painter, inner), name)

    return draw


def framed(painter: QPainter, box: QRectF) -> QPainterPath:
    """Return the edge of a box, `on_rows`."""
    corners = [box.topLeft().toTuple(), box.bottomRight().toTuple()]
    first, last = starmap(QPointF, on_rows(painter, corners).tolist())
    edge = QPainterPath()
    edge.addRect(QRectF(first, last))
    return edge


def outlined(
    painter: QPainter,
    path: QPainterPath,
    colour: QColor,
    width: float = WIDTH_PX,
    *,
    style: Qt.PenStyle = Qt.PenStyle.SolidLine,
) -> None:
    """Draw the edge of a region in a light `colour`, with a dark outline."""
    for pen in _cased(colour, width, style):
        painter.strokePath(path, pen)


@cache
def protected() -> QBrush:
    """Return the hatch of protected regions."""
    crossed = [QLine(0, 0, 11, 11), QLine(0, 11, 11, 0)]
    return _hatch(QColor(0, 0, 0, 70), HALO, 12, crossed)


def _hatch(ground: QColor, colour: QColor, period_px: int, light: Sequence[QLine]) -> QBrush:
    """Return a brush: pixels of `colour` on a translucent `ground`, each next to a dark pixel."""
    tile = QPixmap(period_px, period_px)
    tile.fill(ground)
    painter = QPainter(tile)
    painter.setCompositionMode(QPainter.CompositionMode.CompositionMode_Source)
    for right, shown in ((1, CASE), (1 - period_px, CASE), (0, colour)):
        painter.setPen(shown)
        painter.drawLines([line.translated(right, 0) for line in light])
    painter.end()
    return QBrush(tile)


def mask_outline(painter: QPainter, mask: npt.NDArray[np.bool_], to_screen: Affine) -> QPainterPath:
    """Return the outline of the samples of a mask, on screen."""
    contours, _ = cv2.findContours(mask.view(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    path = QPainterPath()
    for contour in contours:
        smooth = cv2.approxPolyDP(contour, 0.6, closed=True).reshape(-1, 2)
        seen = on_rows(painter, to_screen(smooth))
        path.addPolygon(QPolygonF(list(starmap(QPointF, seen.tolist()))))
        path.closeSubpath()
    return path
