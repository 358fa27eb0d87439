"""What would go along with the landmark under the cursor, or goes along with the one in hand."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QLineF, QPointF
from PySide6.QtGui import QColor, QPainter, QPen

from kogao_core import reshape
from kogao_core.geometry import Array

from ..handles import Handle, apart, exists, reach_px
from . import glyphs
from .listed import kinds
from .overlay import Overlay, Place

_BAND_PX: Final = 9.0
_BAND: Final = QColor(glyphs.HALO)
_OPAQUE: Final = 0.75


class FollowingBand(Overlay):
    """A band along the outline, as wide as its landmarks follow; a ring where one is mirrored."""

    name = "following"
    height = 105

    def wanted(self) -> bool:
        """Show it while anything follows a landmark that can be seen."""
        follows = self.shown.following.soft or self.shown.following.symmetric
        return follows and "outline" in kinds(self.shown.visible) and self._led() is not None

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the outline between each two landmarks as wide as the nearer one follows."""
        led, view = self._led(), self.shown
        if led is None:
            return
        # What follows is settled where the drag begins.
        face, now = view.document.committed.faces[led.face], view.state.faces[led.face]
        if not apart(face, place.zoom):
            return
        following, at = view.following, place.points(now.outline)
        mirror = reshape.opposite(face, led.index) if following.symmetric else None
        for index in (led.index, mirror):
            if index is not None and following.soft:
                weights = reshape.influence(face.outline, index, reach_px(face, following))
                self._draw_band(painter, at, weights)
        if mirror is not None:
            glyphs.ring(painter, at[mirror], glyphs.HALO, 2.0)

    def _draw_band(self, painter: QPainter, at: list[QPointF], weights: Array) -> None:
        for start, end, weight in zip(
            at[:-1], at[1:], (weights[:-1] + weights[1:]) / 2.0, strict=True
        ):
            if weight > 0.0:
                colour = QColor(_BAND)
                colour.setAlphaF(_OPAQUE * float(weight))
                for one, width in ((glyphs.CASE, 2.0), (colour, 0.0)):
                    painter.setPen(QPen(one, _BAND_PX * float(weight) + width))
                    painter.drawLine(QLineF(start, end))

    def _led(self) -> Handle | None:
        """Return the landmark of the outline in hand, under the cursor, or selected."""
        view = self.shown
        first = view.selected if view.document.in_gesture else view.hovered
        led = first or view.selected
        if led is None or led.kind != "outline":
            return None
        return led if exists(view.document.committed, led) else None
