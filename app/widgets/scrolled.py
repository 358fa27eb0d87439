"""Areas that scroll what doesn't fit, so that a small window cuts nothing off."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QSize, Qt
from PySide6.QtWidgets import QFrame, QScrollArea, QSizePolicy, QWidget


class ColumnArea(QScrollArea):
    """A column that scrolls up and down and is as wide as its content asks.

    Parameters
    ----------
    content : QWidget
        What it holds.
    least_px : int
        Its width while the content asks for no more.
    """

    def __init__(self, content: QWidget, least_px: int) -> None:
        super().__init__()
        self._least_px, self._content = least_px, content
        _bare(self, content)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        content.installEventFilter(self)
        self.setFixedWidth(least_px)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Follow the content's width."""
        if watched is self._content and event.type() == QEvent.Type.LayoutRequest:
            room = self.verticalScrollBar().sizeHint().width()
            asked = self._content.minimumSizeHint().width() + room
            self.setFixedWidth(max(self._least_px, asked))
        return super().eventFilter(watched, event)


class RowArea(QScrollArea):
    """A strip as high as its content that scrolls sideways where the window is narrow."""

    def __init__(self, content: QWidget) -> None:
        super().__init__()
        self._content = content
        _bare(self, content)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        """Return the content's, and room for the scroll bar below it."""
        return self._content.sizeHint() + QSize(0, self._bar_px)

    def minimumSizeHint(self) -> QSize:
        """Return the content's height, and room for the scroll bar below it."""
        return QSize(0, self._content.minimumSizeHint().height() + self._bar_px)

    @property
    def _bar_px(self) -> int:
        return self.horizontalScrollBar().sizeHint().height()


def _bare(area: QScrollArea, content: QWidget) -> None:
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setWidget(content)
