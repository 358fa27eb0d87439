"""The middle of the window: the photo, before and after, and what lies over it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np
from PySide6.QtCore import QRectF, QSizeF, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QVBoxLayout, QWidget

from .canvas.photo_canvas import PhotoCanvas
from .canvas.viewport import OriginalView, Viewport
from .theme import GRID_PX
from .widgets.messages import MessageBar

# Of the height from the eyes to the chin: the hair ends about so far above the eyes.
_FOREHEAD: Final = 0.8
_MARGIN_PX: Final = 3 * GRID_PX


class Stage(QWidget):
    """Holds the views of the photo side by side, and lays messages where they hide no face."""

    def __init__(self, canvas: PhotoCanvas, original: OriginalView, bar: MessageBar) -> None:
        super().__init__()
        self._view, self._bar = canvas.shown, bar
        self._views: list[Viewport] = []
        self._below: list[QWidget] = []
        self._place: QRectF | None = None
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._row = QHBoxLayout()
        self._row.setSpacing(GRID_PX // 2)
        self._grid.addLayout(self._row, 0, 0)
        for one in (original, canvas):
            self.add_view(one)
        bar.setParent(self)
        bar.left.connect(canvas.setFocus)
        bar.appeared.connect(self.place_bar)
        canvas.view_changed.connect(self.place_bar)

    def add_view(self, view: Viewport) -> None:
        """Put a view of the photo to the right of the others."""
        self._views.append(view)
        # Equal shares: the same zoom shows the same piece of the photo in all of them.
        self._row.addWidget(view, 1)
        # Whenever it comes, what is said lies over it.
        view.lower()

    def show_below(self, widget: QWidget) -> None:
        """Lay a widget over the lower edge of the views; messages leave it in sight."""
        self._below.append(widget)
        edge = QVBoxLayout()
        edge.setContentsMargins(_MARGIN_PX, 0, _MARGIN_PX, _MARGIN_PX)
        edge.addWidget(widget)
        self._grid.addLayout(edge, 0, 0, Qt.AlignmentFlag.AlignBottom)
        self._bar.raise_()

    def show_in_middle(self, widget: QWidget) -> None:
        """Lay a widget over the middle of the views."""
        self._grid.addWidget(widget, 0, 0, Qt.AlignmentFlag.AlignCenter)

    def place_bar(self) -> None:
        """Lay the message where it hides no head, as far as there is room beside them."""
        if self._bar.isHidden():
            self._place = None
            return
        area = self.rect().toRectF().adjusted(_MARGIN_PX, _MARGIN_PX, -_MARGIN_PX, -_MARGIN_PX)
        size = self._bar.size_in(round(area.width())).toSizeF()
        for one in self._below:
            if one.isVisible():
                area.setBottom(min(area.bottom(), one.y() - _MARGIN_PX))
        self._place = clear_place(size, area, list(self._heads()), self._place)
        self._bar.setGeometry(self._place.toRect())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Find the message another place."""
        super().resizeEvent(event)
        self.place_bar()

    def _heads(self) -> Iterator[QRectF]:
        """Yield where heads are seen, px of the stage."""
        for seen in (view for view in self._views if view.isVisible()):
            for face in self._view.state.faces:
                left, top, width, height = face.box
                corners = np.array([(left, top - _FOREHEAD * height), (left + width, top + height)])
                low, high = (
                    seen.viewport().mapTo(self, seen.to_screen(corner).toPoint()).toPointF()
                    for corner in corners
                )
                yield QRectF(low, high)


def clear_place(
    size: QSizeF, area: QRectF, kept: Sequence[QRectF], now: QRectF | None = None
) -> QRectF:
    """Return the place of `size` in `area` that covers least of what is to be `kept` in sight."""
    places = list(_places(size, area))
    if now is not None and now in places:
        places.insert(0, now)
    return min(places, key=lambda place: sum(_common(place, one) for one in kept))


def _places(size: QSizeF, area: QRectF) -> Iterable[QRectF]:
    right, below = area.width() - size.width(), area.height() - size.height()
    for y in (0.0, below):
        for x in (right / 2, 0.0, right):
            yield QRectF(area.left() + x, area.top() + y, size.width(), size.height())


def _common(one: QRectF, other: QRectF) -> float:
    both = one.intersected(other)
    return both.width() * both.height()
