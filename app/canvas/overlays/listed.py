"""Overlays with a switch, in the order of panel and menu, and the legend."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from collections.abc import Set as AbstractSet
from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPen

from kogao_core.base.language import Text
from kogao_core.recipe.settings import DOMAINS

from ...i18n import tr, translated
from ...view_state import Kind
from . import glyphs
from .background import TurnedLines
from .curves import ShapeCurves
from .field import Displacement, DomainRegions, Folds, HeatMap, JacobianMap, LatticeLines
from .marks import Centre, Landmarks, Protected, ReadOutline, Targets
from .overlay import Overlay, Place

Swatch = Callable[[QPainter, QRectF], object]
_MARGIN_PX: Final = 16.0
_PADDING_PX: Final = 8.0
_GAP_PX: Final = 4.0
_SMALL_PX: Final = 600.0  # below this width of the view, symbols stand alone


class Legend(Overlay):
    """A plate in the lower right corner with a symbol and a name for each visible overlay."""

    name = "legend"
    title = Text("Legend")
    height = 175
    key = "F12"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        painter.setPen(QPen(glyphs.HALO, 1.2))
        painter.setBrush(glyphs.PLATE)
        painter.drawRoundedRect(box.adjusted(1.5, 2.5, -1.5, -2.5), 2, 2)
        for y in (6.5, 11.5):
            painter.drawLine(QPointF(box.left() + 5, y), QPointF(box.right() - 5, y))

    def draw(self, painter: QPainter, place: Place) -> None:
        rows = list(self.rows())
        if not rows:
            return
        if place.viewport.width() < _SMALL_PX:
            rows = [(swatch, "") for swatch, _ in rows]
        metrics = painter.fontMetrics()
        line = max(float(metrics.height()), float(glyphs.SWATCH_PX)) + _GAP_PX
        text_at = glyphs.SWATCH_PX + 2 * _GAP_PX
        width = text_at + max(metrics.horizontalAdvance(text) for _, text in rows)
        box = QRectF(0, 0, width + 2 * _PADDING_PX, len(rows) * line + 2 * _PADDING_PX)
        box.moveBottomRight(place.viewport.bottomRight() - QPointF(_MARGIN_PX, _MARGIN_PX))
        glyphs.ground(painter, box, 4)
        for row, (swatch, text) in enumerate(rows):
            top = box.top() + _PADDING_PX + row * line
            mark = QRectF(0, 0, glyphs.SWATCH_PX, glyphs.SWATCH_PX)
            painter.save()
            painter.translate(box.left() + _PADDING_PX, top + (line - mark.height()) / 2)
            swatch(painter, mark)
            painter.restore()
            painter.setPen(glyphs.HALO)
            area = QRectF(box.left() + _PADDING_PX + text_at, top, width - text_at, line)
            painter.drawText(area, Qt.AlignmentFlag.AlignVCenter, text)

    def rows(self) -> Iterator[tuple[Swatch, str]]:
        """Yield symbol and name of each visible overlay, and of each domain."""
        for one in LISTED:
            on = one.name in self.shown.visible and one.is_there(self.shown)
            if one is Legend or not on:
                continue
            if one.name == "domains" and self.shown.counts:
                yield from self._domains()
            else:
                yield one.swatch, translated(one.title)

    def _domains(self) -> Iterator[tuple[Swatch, str]]:
        counts = self.shown.counts
        for domain in reversed(DOMAINS):
            share = 100 * counts[domain.name] / max(1, counts["image"])
            text = tr("{title}: {n:.1f} %", title=translated(domain.title), n=share)
            yield glyphs.domain_mark(domain.name), text


LISTED: Final[tuple[type[Overlay], ...]] = (
    *(Landmarks, Targets, ShapeCurves, ReadOutline, Centre),
    *(Displacement, LatticeLines, DomainRegions, Folds),
    *(HeatMap, JacobianMap),
    *(TurnedLines, Protected, Legend),
)


def kinds(visible: AbstractSet[str]) -> set[Kind]:
    """Return the kinds of handles that the visible overlays show."""
    return {kind for one in LISTED if one.name in visible for kind in one.handles}
