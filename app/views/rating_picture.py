"""The picture of a rating session."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent, QPixmap
from PySide6.QtWidgets import QSizePolicy, QWidget

from ..i18n import tr

_LEAST_PX: Final = QSize(240, 240)


class Picture(QWidget):
    """The picture as large as fits, at most at its own size.

    Signals
    -------
    painted
        A new picture is on the screen for the first time.
    """

    painted = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._pixmap, self._fresh = QPixmap(), False
        self.setMinimumSize(_LEAST_PX)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName(tr("The face to judge"))
        # The keyboard rests here: on a button it would suggest an answer.
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def show_picture(self, pixmap: QPixmap) -> None:
        """Show another picture."""
        self._pixmap, self._fresh = pixmap, True
        self.update()

    def done_with(self) -> None:
        """Say nothing more of this picture, should it only now be painted."""
        self._fresh = False

    def paintEvent(self, _: QPaintEvent) -> None:
        """Paint it in the middle."""
        if self._pixmap.isNull():
            return
        ratio = self.devicePixelRatioF()
        room = self.size() * ratio
        size = self._pixmap.size()
        if size.width() > room.width() or size.height() > room.height():
            size = size.scaled(room, Qt.AspectRatioMode.KeepAspectRatio)
        shown = self._pixmap.scaled(
            size, Qt.AspectRatioMode.IgnoreAspectRatio, Qt.TransformationMode.SmoothTransformation
        )
        shown.setDevicePixelRatio(ratio)
        left = (self.width() - size.width() / ratio) / 2
        top = (self.height() - size.height() / ratio) / 2
        with QPainter(self) as painter:
            painter.drawPixmap(round(left), round(top), shown)
        if self._fresh:
            self._fresh = False
            self.painted.emit()
