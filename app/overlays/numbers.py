"""Which face is which: their numbers, once there is more than one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QFont, QPainter

from ..i18n import tr
from ..scene import Scene
from . import glyphs
from .base import Overlay, Place


class Badge(NamedTuple):
    """A face's number: what it says, whether the face is chosen, its plate in px of the screen."""

    face: int
    text: str
    chosen: bool
    plate: QRectF


def badges(scene: Scene, place: Place, font: QFont) -> Iterator[Badge]:
    """Yield the numbers above the faces' topmost landmarks, the topmost badge last."""
    if "landmarks" not in scene.visible or len(scene.state.faces) < 2:
        return
    for index, face in enumerate(scene.state.faces):
        left, top, width, _ = face.box
        (at,) = place.points([(left + width / 2, top)])
        chosen = index == scene.face
        text = tr("● Face {n}", n=index + 1) if chosen else str(index + 1)
        within = place.viewport if place.viewport.contains(at) else None
        above = at - QPointF(8, 20)
        yield Badge(
            index, text, chosen, glyphs.plate(font, above, text, bold=chosen, within=within)
        )


class FaceNumbers(Overlay):
    """A number over each face; the one whose settings are edited is bold and has a dot."""

    def wanted(self) -> bool:
        """Show it together with the landmarks, where there is something to tell apart."""
        return "landmarks" in self.shown.visible

    def draw(self, painter: QPainter, place: Place) -> None:
        """Write the numbers."""
        for badge in badges(self.shown, place, painter.font()):
            glyphs.on_plate(painter, badge.plate, badge.text, bold=badge.chosen)
