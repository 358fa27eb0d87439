"""Base classes of overlays. Overlays draw in screen px, so line widths ignore the zoom."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
import numpy.typing as npt
import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPainter, QTransform
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from kogao_core.base.geometry import Affine, Array, Box
from kogao_core.base.language import Text

from ...view_state import Kind, RenderedFrame, ViewState

_EVERYWHERE: Final = QRectF(-1e7, -1e7, 2e7, 2e7)


@dataclass(frozen=True, eq=False)
class Place:
    """Position of the photo on screen."""

    to_screen: Affine  # from px of the photo to px of the viewport
    viewport: QRectF  # visible area, px of the viewport

    @property
    def zoom(self) -> float:
        """Screen px per photo px."""
        return self.to_screen.scale

    def points(self, positions: npt.ArrayLike) -> list[QPointF]:
        """Return positions of shape (N, 2) on screen."""
        return [QPointF(x, y) for x, y in self.to_screen(positions).reshape(-1, 2).tolist()]

    def rect(self, left: float, top: float, right: float, bottom: float) -> QRectF:
        """Return a rectangle of the photo on screen."""
        first, last = self.points([(left, top), (right, bottom)])
        return QRectF(first, last)

    def box(self, pixels: Box) -> QRectF:
        """Return the pixels of a box on screen, to their outer edges."""
        left, top, right, bottom = pixels.left, pixels.top, pixels.right, pixels.bottom
        return self.rect(left - 0.5, top - 0.5, right - 0.5, bottom - 0.5)

    @property
    def seen(self) -> Array:
        """Corners of the viewport in px of the photo, shape (2, 2): top left, bottom right."""
        return self.to_screen.inverse(np.array(self.viewport.getCoords()).reshape(2, 2))


class Overlay:
    """One layer over the photo.

    Overlays with a switch also have a name, a title, a key and a swatch, and are part of
    `listed.LISTED`. Panel, menu and screenshots use that list. Each workspace defines the overlays
    that are on at first.

    Attributes
    ----------
    height : int
        Stacking order: larger values are drawn later, on top.
    name : str
        Entry in `ViewState.switched` that enables the overlay.
    title : Text
        Visible name.
    key : str
        Shortcut; empty for an overlay without a switch.
    handles : frozenset of Kind
        Handles that are draggable while the overlay is on.
    """

    height: ClassVar[int]
    name: ClassVar[str]
    title: ClassVar[Text]
    key: ClassVar[str] = ""
    handles: ClassVar[frozenset[Kind]] = frozenset()

    def __init__(self, view: ViewState) -> None:
        self.shown = view

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        """Draw the overlay's symbol into a small square, for the legend."""
        raise NotImplementedError

    @classmethod
    def is_there(cls, view: ViewState) -> bool:
        """Return whether the overlay has content to explain in the legend."""
        return bool(view.state.faces) or not cls.handles

    def wanted(self, visible: AbstractSet[str]) -> bool:
        """Return whether the overlay is enabled; always True without a switch."""
        return not self.key or self.name in visible

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the overlay, in px of the screen."""
        raise NotImplementedError


class Layers(pg.GraphicsObject):
    """All overlays as one scene item: a scene notifies each item of every move and zoom."""

    def __init__(self, view: ViewState, overlays: Sequence[Overlay]) -> None:
        super().__init__()
        self._shown, self._overlays = view, overlays

    def boundingRect(self) -> QRectF:
        """Return an unlimited rectangle: the drawn area depends on the screen, not on the photo."""
        return _EVERYWHERE

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionGraphicsItem,  # noqa: ARG002
        widget: QWidget | None = None,
    ) -> None:
        if not self._shown.image.area:
            return
        place = Place(affine(painter.worldTransform()), viewport_of(painter, widget))
        painter.setWorldTransform(QTransform())
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        visible = self._shown.visible
        for overlay in self._overlays:
            if overlay.wanted(visible):
                painter.save()
                overlay.draw(painter, place)
                painter.restore()


def affine(transform: QTransform) -> Affine:
    """Convert a QTransform to an Affine."""
    matrix = np.array([[transform.m11(), transform.m21()], [transform.m12(), transform.m22()]])
    return Affine(matrix, np.array([transform.dx(), transform.dy()]))


def viewport_of(painter: QPainter, widget: QWidget | None) -> QRectF:
    """Return the paintable area in logical px of the screen."""
    return QRectF(widget.rect() if widget is not None else painter.viewport())


class FrameOverlay(Overlay):
    """Base class of overlays that show the newest frame."""

    def draw(self, painter: QPainter, place: Place) -> None:
        if self.shown.frame is not None:
            self.draw_frame(painter, place, self.shown.frame)

    def draw_frame(self, painter: QPainter, place: Place, frame: RenderedFrame) -> None:
        """Draw one frame; the frame's px may differ from the photo's px."""
        raise NotImplementedError
