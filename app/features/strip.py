"""Fills the film strip in a worker, and keeps it up with its folder."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import QFileSystemWatcher, QSignalBlocker, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QColorSpace, QIcon, QImage, QImageReader, QPixmap
from PySide6.QtWidgets import QListView, QListWidget, QListWidgetItem

from kogao_core.base.display import preview
from kogao_core.photo import READABLE, UnreadablePhoto, read

from ..i18n import reason, tr
from ..render.pictures import untinted
from ..widgets.dialogs import ask_path
from ..widgets.docks import Dock
from .feature import Context, Feature
from .files import Files

_MOST = 2000
_SETTLE_MS = 300
THUMBNAIL_PX: Final = 72
_RAW: Final = "RAW"  # takes seconds to develop
_PATH: Final = Qt.ItemDataRole.UserRole


class Strip(Feature):
    """Lists photos, makes their thumbnails one after the other, and leads from one to the next."""

    name = "strip"

    def __init__(self, context: Context, files: Files) -> None:
        super().__init__(context)
        self._files = files
        self._places: list[Path] = []
        self._paths: list[Path] | None = None  # none listed yet
        self._next = 0
        self._wanted: Path | None = None
        self._listing = self.lane(self._fill, self._not_listed)
        # A photo without a thumbnail keeps its blank place, whatever the reason.
        self._drawing = self.lane(self._show, lambda _: self._draw_next())
        self._watcher = QFileSystemWatcher(self)
        self._again = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._again.timeout.connect(self._list_again)
        self._watcher.directoryChanged.connect(lambda _: self._again.start())
        self.panel: FilmStrip = FilmStrip()
        self.dock = Dock(tr("Film strip"))
        self.panel.wanted.connect(self.open)
        self.window.dropped.connect(self.show_places)
        self.document.opened.connect(self._follow)
        files.began.connect(self._pass_over)
        files.unreadable.connect(self._pass_over)
        self.add_action(
            "folder",
            tr("Open a &folder…"),
            "Ctrl+Shift+O",
            tr("Photos as a film strip"),
            self._ask_folder,
        )
        self.add_action(
            "next-photo",
            tr("&Next photo"),
            "Ctrl+Right",
            tr("Next on the film strip"),
            lambda: self.panel.step(1),
        )
        self.add_action(
            "previous-photo",
            tr("Pre&vious photo"),
            "Ctrl+Left",
            tr("Previous on the film strip"),
            lambda: self.panel.step(-1),
        )

        self._enable(False)

    def _enable(self, filled: bool) -> None:
        for name in ("next-photo", "previous-photo"):
            self.actions[name].setEnabled(filled)

    def stop(self) -> None:
        """Start nothing more."""
        super().stop()
        self._again.stop()

    def _ask_folder(self) -> None:
        title = tr("Open a folder")
        ask_path(
            self.window, title, lambda it: self.show_places([it]), "folder", at=self._files.folder
        )

    def show_places(self, places: list[Path]) -> None:
        """Open one photo at once; of several or a folder make a film strip, and open the first."""
        if not places:
            self.say(tr("That is no file of this computer; save it here, then open it."))
        elif len(places) == 1 and not os.path.isdir(places[0]):
            self._files.open(places[0])
        else:
            self.show(places)

    def open(self, path: Path) -> None:
        """Open another photo; until it is open, and should the user keep this, this is marked."""
        self.panel.mark(self.document.path)
        if path == self.document.path:
            self._wanted = None
            self._files.stay()
        else:
            self._wanted = path
            self._files.open(path)

    def _follow(self) -> None:
        self._wanted = None
        self.panel.mark(self.document.path)

    def _pass_over(self) -> None:
        """Go on along the strip from a photo that is being opened, or couldn't be."""
        self.panel.pass_over(self._wanted)

    def show(self, places: Sequence[Path]) -> None:
        """Show these photos, and those in these folders."""
        # Photos that are open are known by their whole names.
        places = [place.absolute() for place in places]
        if self._watcher.directories():
            self._watcher.removePaths(self._watcher.directories())
        for folder in (place for place in places if os.path.isdir(place)):
            self._watcher.addPath(str(folder))
        self._places, self._paths = places, None
        self._list_again()

    def _list_again(self) -> None:
        places = self._places
        self._listing.submit(lambda: photos_in(places))

    def _fill(self, paths: list[Path]) -> None:
        if paths == self._paths:
            return
        self._drawing.drop()
        self._paths, self._next = paths, 0
        self.window.bar.refresh()
        self.panel.show_paths(paths)
        self._show_strip(paths)
        self._draw_next()

    def _show_strip(self, paths: list[Path]) -> None:
        self.window.docks.offer("strip", bool(paths))
        self._enable(bool(paths))
        if not paths:
            self.say(tr("There is no photo in that folder; choose another one."))
            return
        self._name_left_out(paths)
        self.window.docks.show("strip")
        if self.document.path not in paths:
            self._wanted = paths[0]
            self._files.open(paths[0])
        self.panel.mark(self.document.path)

    def _name_left_out(self, paths: list[Path]) -> None:
        """Say which of the named files are no photos, until the next photo is opened."""
        places, first = self._places, (None, self.document.path, paths[0])
        left_out = [one.name for one in places if one not in paths and not os.path.isdir(one)]
        if left_out:
            text = tr("Not on the film strip, since no photo: {names}.", names=", ".join(left_out))
            self.say(text, applies=lambda: self._places is places and self.document.path in first)

    def _not_listed(self, problem: Exception) -> None:
        text = tr("The photos can't be listed ({why}); open one by its name.", why=reason(problem))
        path = self.document.path
        self.say(text, applies=lambda: self._paths is None and self.document.path == path)

    def _draw_next(self) -> None:
        paths = self._paths or []
        if self._next < len(paths):
            index, path = self._next, paths[self._next]
            self._next += 1
            self._drawing.submit(lambda: (index, thumbnail(path)))

    def _show(self, drawn: tuple[int, QImage]) -> None:
        self.panel.show_thumbnail(*drawn)
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
    """Return a small upright picture of a photo; a null one of raw and damaged files."""
    reader = QImageReader(str(path))
    reader.setAutoTransform(True)
    size = reader.size()
    if size.isValid():
        room = QSize(2 * THUMBNAIL_PX, 2 * THUMBNAIL_PX)
        reader.setScaledSize(size.scaled(room, Qt.AspectRatioMode.KeepAspectRatio))
    picture = reader.read()
    if picture.isNull() and READABLE.get(path.suffix.lower()) != _RAW:
        picture = _decoded(path)
    if picture.colorSpace().isValid():
        picture.convertToColorSpace(QColorSpace(QColorSpace.NamedColorSpace.SRgb))
    return picture


def _decoded(path: Path) -> QImage:
    """Return a small picture of what the core reads and Qt doesn't, such as HEIC."""
    try:
        photo = read(path, bits=8)
    except UnreadablePhoto:
        return QImage()
    picture = QImage.fromData(preview(photo.pixels, 2 * THUMBNAIL_PX))
    if photo.icc_profile is not None:
        picture.setColorSpace(QColorSpace.fromIccProfile(photo.icc_profile))
    return picture


class FilmStrip(QListWidget):
    """A row of thumbnails."""

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

    def sizeHint(self) -> QSize:
        """Return room for one row: what lies below it is the photo's."""
        return QSize(super().sizeHint().width(), self.minimumHeight())

    def show_paths(self, paths: Sequence[Path]) -> None:
        """Show these photos; their thumbnails come later."""
        self.clear()
        self._passed = None
        picture = QPixmap(THUMBNAIL_PX, THUMBNAIL_PX)
        picture.fill(Qt.GlobalColor.transparent)
        blank = QIcon(picture)
        for path in paths:
            item = QListWidgetItem(blank, path.name)
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
        """Let the next step begin at a photo that isn't open."""
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
