"""The film strip: photos of a folder or a drop, one click away."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QIcon, QImage, QPixmap
from PySide6.QtWidgets import QListView, QListWidget, QListWidgetItem

from ..i18n import tr
from .thumbnails import untinted

THUMBNAIL_PX: Final = 72
_PATH: Final = Qt.ItemDataRole.UserRole


class FilmStrip(QListWidget):
    """A row of thumbnails.

    Signals
    -------
    wanted(Path)
        The user wants to open this photo.
    """

    wanted = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName(tr("Film strip"))
        self.setAccessibleDescription(tr("Photos to open with a click or the Return key"))
        self.setViewMode(QListView.ViewMode.IconMode)
        self.setFlow(QListView.Flow.LeftToRight)
        self.setWrapping(False)
        self.setMovement(QListView.Movement.Static)
        self.setUniformItemSizes(True)
        self.setIconSize(QSize(THUMBNAIL_PX, THUMBNAIL_PX))
        self.setGridSize(QSize(THUMBNAIL_PX + 24, THUMBNAIL_PX + 32))
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.setMinimumHeight(THUMBNAIL_PX + 52)
        self._passed: int | None = None
        self.itemClicked.connect(self._tell)
        self.itemActivated.connect(self._tell)

    def show_paths(self, paths: Sequence[Path]) -> None:
        """Show these photos; their thumbnails come later."""
        self.clear()
        self._passed = None
        for path in paths:
            item = QListWidgetItem(_blank(), path.name)
            item.setData(_PATH, str(path))
            item.setToolTip(str(path))
            self.addItem(item)

    def show_thumbnail(self, index: int, image: QImage) -> None:
        """Show the thumbnail of a photo."""
        item = self.item(index)
        if item is not None and not image.isNull():
            item.setIcon(untinted(QPixmap.fromImage(image)))

    def mark(self, path: Path | None) -> None:
        """Select the photo that is open."""
        self._passed = None
        with QSignalBlocker(self):
            row = self._row_of(path)
            self.setCurrentRow(-1 if row is None else row)

    def pass_over(self, path: Path | None) -> None:
        """Let the next step begin at a photo that couldn't be opened."""
        self._passed = self._row_of(path)

    def path(self, row: int) -> Path:
        """Return which photo stands in a row."""
        return Path(self.item(row).data(_PATH))

    def step(self, by: int) -> None:
        """Ask for the next or an earlier photo."""
        row = (self.currentRow() if self._passed is None else self._passed) + by
        if 0 <= row < self.count():
            self.wanted.emit(self.path(row))

    def _row_of(self, path: Path | None) -> int | None:
        return next((row for row in range(self.count()) if self.path(row) == path), None)

    def _tell(self, item: QListWidgetItem) -> None:
        self.wanted.emit(self.path(self.row(item)))


def _blank() -> QIcon:
    picture = QPixmap(THUMBNAIL_PX, THUMBNAIL_PX)
    picture.fill(Qt.GlobalColor.transparent)
    return QIcon(picture)
