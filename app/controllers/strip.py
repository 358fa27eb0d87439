"""Fills the film strip in a worker, and keeps it up with its folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QFileSystemWatcher, QObject, QSize, Qt, QThreadPool, QTimer, Signal
from PySide6.QtGui import QColorSpace, QImage, QImageReader

from kogao_core.photo import READABLE

from ..i18n import reason, tr
from ..panels.strip import THUMBNAIL_PX, FilmStrip
from ..views.bar import Message
from ..workers import Lane

_MOST = 2000
_SETTLE_MS = 300


class Strip(QObject):
    """Lists photos, and makes their thumbnails one after the other.

    Signals
    -------
    filled(list of Path)
        These photos are on the strip now.
    said(Message)
        For the bar over the canvas.
    """

    filled = Signal(object)
    said = Signal(object)

    def __init__(self, view: FilmStrip, pool: QThreadPool, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._view = view
        self._places: list[Path] = []
        self._paths: list[Path] | None = None  # none listed yet
        self._next = 0
        self._listing = Lane(pool, self._not_listed, self)
        self._listing.done.connect(self._fill)
        # A photo without a thumbnail keeps its blank place, whatever the reason.
        self._drawing = Lane(pool, lambda _: self._draw_next(), self)
        self._drawing.done.connect(self._show)
        self._watcher = QFileSystemWatcher(self)
        self._again = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._again.timeout.connect(self._list_again)
        self._watcher.directoryChanged.connect(lambda _: self._again.start())

    @property
    def busy(self) -> bool:
        """True while photos are listed or drawn."""
        return self._listing.busy or self._drawing.busy

    def stop(self) -> None:
        """Start nothing more."""
        self._again.stop()
        self._listing.drop()
        self._drawing.drop()

    def show(self, places: Sequence[Path]) -> None:
        """Show these photos, and those in these folders."""
        if self._watcher.directories():
            self._watcher.removePaths(self._watcher.directories())
        for folder in (place for place in places if place.is_dir()):
            self._watcher.addPath(str(folder))
        self._places, self._paths = list(places), None
        self._list_again()

    def _list_again(self) -> None:
        places = self._places
        self._listing.submit(lambda: photos_in(places))

    def _fill(self, paths: list[Path]) -> None:
        if paths == self._paths:
            return
        self._drawing.drop()
        self._paths, self._next = paths, 0
        self._view.show_paths(paths)
        self.filled.emit(paths)
        self._draw_next()

    def _not_listed(self, problem: Exception) -> None:
        text = tr("The photos can't be listed ({why}); open one by its name.", why=reason(problem))
        self.said.emit(Message(text))

    def _draw_next(self) -> None:
        paths = self._paths or []
        if self._next < len(paths):
            index, path = self._next, paths[self._next]
            self._next += 1
            self._drawing.submit(lambda: (index, thumbnail(path)))

    def _show(self, drawn: tuple[int, QImage]) -> None:
        self._view.show_thumbnail(*drawn)
        self._draw_next()


def photos_in(places: Sequence[Path]) -> list[Path]:
    """Return the photos among `places` and in the folders among them, in order of their names."""
    found: list[Path] = []
    for place in places:
        try:
            inside = sorted(place.iterdir()) if place.is_dir() else [place]
        except OSError:  # a folder that can't be read has nothing to show
            continue
        found += [path for path in inside if path.suffix.lower() in READABLE and path.is_file()]
    return list(dict.fromkeys(found))[:_MOST]


def thumbnail(path: Path) -> QImage:
    """Return a small upright picture of a photo; a null one where Qt can't read it."""
    reader = QImageReader(str(path))
    reader.setAutoTransform(True)
    size = reader.size()
    if size.isValid():
        room = QSize(2 * THUMBNAIL_PX, 2 * THUMBNAIL_PX)
        reader.setScaledSize(size.scaled(room, Qt.AspectRatioMode.KeepAspectRatio))
    picture = reader.read()
    if picture.colorSpace().isValid():
        picture.convertToColorSpace(QColorSpace(QColorSpace.NamedColorSpace.SRgb))
    return picture
