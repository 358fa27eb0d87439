"""Fills the film strip in a worker, and keeps it up with its folder."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Final, Literal

from PySide6.QtCore import (
    QFileSystemWatcher,
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    QSignalBlocker,
    QSize,
    Qt,
    QTimer,
    Signal,
)
from PySide6.QtGui import QColorSpace, QIcon, QImage, QImageReader, QPainter, QPalette, QPixmap
from PySide6.QtWidgets import (
    QApplication,
    QListView,
    QListWidget,
    QListWidgetItem,
    QStyledItemDelegate,
    QStyleOptionViewItem,
)

from kogao_core.base.display import preview
from kogao_core.photo import READABLE, UnreadablePhoto, read
from kogao_core.projects import sidecar
from kogao_core.projects.project import sha256_of
from kogao_core.projects.results import Results

from ..i18n import reason, tr
from ..render.pictures import untinted
from ..theme import GRID_PX
from ..widgets.dialogs import ask_path
from ..widgets.docks import Dock
from .feature import Context, Feature
from .files import Files
from .projects import Projects

_MOST = 2000
_SETTLE_MS = 300
THUMBNAIL_PX: Final = 72
_RAW: Final = "RAW"  # takes seconds to develop
_PATH: Final = Qt.ItemDataRole.UserRole
_MARK: Final = Qt.ItemDataRole.UserRole + 1
_AT_ONCE: Final = 16  # photos that are looked at before the strip shows what they are
Mark = Literal["", "edited", "saved", "result", "failed"]


class Strip(Feature):
    """Lists photos, makes their thumbnails one after the other, and leads from one to the next."""

    name = "strip"

    def __init__(self, context: Context, files: Files, projects: Projects) -> None:
        super().__init__(context)
        self._files = files
        self._places: list[Path] = []
        self._paths: list[Path] | None = None  # none listed yet
        self._next = 0
        self._wanted: Path | None = None
        self._first: Path | None = None
        self._listing = self.lane(self._fill, self._not_listed)
        # A photo without a thumbnail keeps its blank place, whatever the reason.
        self._drawing = self.lane(self._show, lambda _: self._draw_next())
        self._looking = self.lane(self._show_marks, lambda _: None)
        self._to_look: list[Path] = []
        self._failed: set[Path] = set()
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
        files.unreadable.connect(self._note_unreadable)
        projects.kept.connect(self.look_again)
        files.saved.connect(lambda request: self.look_again(request.photo.path))
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

    def chosen(self) -> list[Path]:
        """Return the photos that are chosen on the strip, results left out."""
        return self.panel.listed(chosen=True)

    def photos(self) -> list[Path]:
        """Return all photos on the strip, results left out."""
        return self.panel.listed()

    def look_again(self, path: Path, *, failed: bool = False) -> None:
        """Look again what was done to a photo."""
        (self._failed.add if failed else self._failed.discard)(path)
        self._to_look.append(path)
        self._look()

    def _look(self) -> None:
        if self._to_look and not self._looking.busy:
            paths, self._to_look = self._to_look[:_AT_ONCE], self._to_look[_AT_ONCE:]
            results, edits = self.storage.results, self.storage.edits
            self._looking.submit(lambda: {path: mark_of(path, results, edits) for path in paths})

    def _show_marks(self, marks: dict[Path, Mark]) -> None:
        for path, mark in marks.items():
            self.panel.show_mark(path, "failed" if path in self._failed else mark)
        # The lane counts as busy until this is over.
        QTimer.singleShot(0, self._look)

    def _note_unreadable(self) -> None:
        self._pass_over()
        if self._wanted is not None:
            self.look_again(self._wanted, failed=True)

    def _list_again(self) -> None:
        places, results = self._places, self.storage.results
        self._listing.submit(lambda: _with_first(photos_in(places), results))

    def _fill(self, listed: tuple[list[Path], Path | None]) -> None:
        paths, self._first = listed
        if paths == self._paths:
            return
        self._drawing.drop()
        self._paths, self._next = paths, 0
        self.window.bar.refresh()
        self.panel.show_paths(paths)
        self._to_look = list(paths)
        self._show_strip(paths)
        self._look()
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
            self._wanted = self._first or paths[0]
            self._files.open(self._wanted)
        self.panel.mark(self.document.path)

    def _name_left_out(self, paths: list[Path]) -> None:
        """Say which of the named files are no photos, until the next photo is opened."""
        places, first = self._places, (None, self.document.path, self._first)
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
            side_px = round(THUMBNAIL_PX * self.panel.devicePixelRatioF())
            self._drawing.submit(lambda: (index, thumbnail(path, side_px)))

    def _show(self, drawn: tuple[int, QImage]) -> None:
        self.panel.show_thumbnail(*drawn)
        self._draw_next()


def mark_of(path: Path, results: Results, edits: Path) -> Mark:
    """Return what was done to a photo: whether it is edited, and a copy of that is there."""
    if results.origin(path) is not None:
        return "result"
    file, made = sidecar.kept(path, edits), results.of(path)
    if file is None:
        return "saved" if made else ""
    digest = sha256_of(file)
    return "saved" if any(one.edit == digest for one in made) else "edited"


def _with_first(paths: list[Path], results: Results) -> tuple[list[Path], Path | None]:
    """Return photos, and the first one that is no result."""
    first = (path for path in paths if results.origin(path) is None)
    return paths, next(first, paths[0] if paths else None)


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


def thumbnail(path: Path, side_px: int = 2 * THUMBNAIL_PX) -> QImage:
    """Return a small upright picture of a photo; a null one of raw and damaged files."""
    reader = QImageReader(str(path))
    reader.setAutoTransform(True)
    size = reader.size()
    if size.isValid():
        room = QSize(side_px, side_px)
        reader.setScaledSize(size.scaled(room, Qt.AspectRatioMode.KeepAspectRatio))
    picture = reader.read()
    if picture.isNull() and READABLE.get(path.suffix.lower()) != _RAW:
        picture = _decoded(path, side_px)
    if picture.colorSpace().isValid():
        picture.convertToColorSpace(QColorSpace(QColorSpace.NamedColorSpace.SRgb))
    return picture


def _decoded(path: Path, side_px: int) -> QImage:
    """Return a small picture of what the core reads and Qt doesn't, such as HEIC."""
    try:
        photo = read(path, bits=8)
    except UnreadablePhoto:
        return QImage()
    picture = QImage.fromData(preview(photo.pixels, side_px))
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
        self.setSelectionMode(QListView.SelectionMode.ExtendedSelection)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.setItemDelegate(_Marked(self))
        self._passed: int | None = None
        self._rows: dict[str, int] = {}
        self.itemClicked.connect(self._tell)
        self.itemActivated.connect(self._tell)

    def sizeHint(self) -> QSize:
        """Return room for one row: what lies below it is the photo's."""
        return QSize(super().sizeHint().width(), self.minimumHeight())

    def show_paths(self, paths: Sequence[Path]) -> None:
        """Show these photos; their thumbnails come later."""
        self.clear()
        self._passed = None
        self._rows = {str(path): row for row, path in enumerate(paths)}
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
        while 0 <= row < self.count() and self.item(row).data(_MARK) == "result":
            row += by
        if 0 <= row < self.count():
            self.wanted.emit(self.path(row))

    def listed(self, *, chosen: bool = False) -> list[Path]:
        """Return the photos on it, or those that are chosen, in their order; no results."""
        items = [self.item(row) for row in range(self.count())]
        wanted = [it for it in items if it.data(_MARK) != "result"]
        return [Path(it.data(_PATH)) for it in wanted if it.isSelected() or not chosen]

    def show_mark(self, path: Path, mark: Mark) -> None:
        """Show what was done to a photo."""
        item = self.item(self._rows.get(str(path), -1))
        if item is not None:
            words = _words().get(mark)
            item.setData(_MARK, mark)
            item.setToolTip(f"{path}\n{words}" if words else str(path))
            name = f"{path.name}, {words}" if words else ""
            item.setData(Qt.ItemDataRole.AccessibleTextRole, name or None)

    def _row_of(self, path: Path | None) -> int | None:
        return self._rows.get(str(path))

    def _tell(self, item: QListWidgetItem) -> None:
        held = QApplication.keyboardModifiers()
        if held & (Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier):
            return  # it is being chosen
        self.wanted.emit(self.path(self.row(item)))


class _Marked(QStyledItemDelegate):
    """Draws what was done to a photo over its thumbnail, as a word on a ground of its own."""

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        """Draw a thumbnail, and its mark."""
        super().paint(painter, option, index)
        words = _words().get(index.data(_MARK) or "")
        if not words:
            return
        colours = option.palette
        space = painter.fontMetrics().boundingRect(words).adjusted(-GRID_PX, -1, GRID_PX, 1)
        space.moveTopRight(option.rect.topRight() + QPoint(-GRID_PX, GRID_PX))
        painter.save()
        painter.fillRect(space, colours.color(QPalette.ColorRole.ToolTipBase))
        painter.setPen(colours.color(QPalette.ColorRole.ToolTipText))
        painter.drawText(space, Qt.AlignmentFlag.AlignCenter, words)
        painter.restore()


def _words() -> dict[str, str]:
    return {
        "edited": tr("edited"),
        "saved": tr("copy saved"),
        "result": tr("result"),
        "failed": tr("not done"),
    }
