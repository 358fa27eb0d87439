"""Recent photos and folders: the start page and the menu."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import QPoint, QRect, QSettings, QSize, Qt, Signal, SignalInstance
from PySide6.QtGui import QAction, QImage, QPixmap, QShowEvent
from PySide6.QtWidgets import QApplication, QFrame, QLabel, QMenu, QPushButton, QToolButton

from ..i18n import bare, tr
from ..render.pictures import untinted
from ..theme import GRID_PX, TITLE
from ..widgets.controls import column_of, enlarge, heading, muted_label, row_of
from .feature import Context, Feature
from .files import Files
from .files.opening import is_sample
from .strip import Strip
from .strip.facts import thumbnail

_KEY: Final = "recent"
_MOST: Final = 10
_MOST_RECENT: Final = 4
_MOST_FOLDERS: Final = 3
_WIDTH_PX: Final = 500
_PICTURE_PX: Final = 84
_MARK_PX: Final = 64


def paths(settings: QSettings) -> list[Path]:
    """Return the recent photos, newest first."""
    stored = settings.value(_KEY)
    names = stored if isinstance(stored, list) else [stored]
    return [Path(name) for name in names if isinstance(name, str) and name][:_MOST]


def there(settings: QSettings) -> list[Path]:
    """Return the recent photos that exist now."""
    return [path for path in paths(settings) if os.path.isfile(path)]


def titles(photos: Sequence[Path]) -> list[str]:
    """Return the names of photos; equal names get their folder."""
    found = []
    for photo in photos:
        name, folder = photo.name, photo.parent
        alike = [one.parent for one in photos if one != photo and one.name == name]
        shown = str(folder) if folder.name in [one.name for one in alike] else folder.name
        whole = tr("{name} – {folder}", name=name, folder=shown)  # noqa: RUF001
        found.append(whole if alike else name)
    return found


def add(settings: QSettings, path: Path) -> None:
    """Move a photo to the top of the list."""
    others = [other for other in paths(settings) if other != path]
    settings.setValue(_KEY, [str(p) for p in (path, *others)][:_MOST])


def remove(settings: QSettings, path: Path) -> None:
    """Take a photo off the list."""
    settings.setValue(_KEY, [str(p) for p in paths(settings) if p != path])


class EmptyState(QFrame):
    """The start page: a place to drop, buttons, recent photos and recent folders."""

    # (photo: Path): open a recent photo.
    wanted = Signal(object)
    # (folder: Path): open a recent folder.
    wants_folder = Signal(object)
    # (): the page appears.
    appeared = Signal()

    def __init__(self, begin: Sequence[QAction]) -> None:
        super().__init__()
        self.setProperty("start", "true")
        self.setMinimumWidth(_WIDTH_PX)
        self.setAccessibleName(tr("No photo is open"))
        self.buttons = [_button(action) for action in begin]
        mark, title = QLabel(), heading(tr("Make a face a little smaller"))
        mark.setPixmap(QApplication.windowIcon().pixmap(_MARK_PX))
        enlarge(title, TITLE)
        line = muted_label(tr("Drop photos or a folder here"))
        for label in (mark, title, line):
            label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        for button in self.buttons[:1]:
            button.setProperty("primary", "true")
        self._links: dict[Path, QToolButton] = {}
        self._title = muted_label(tr("Recent"))
        self._rows = row_of(spacing=GRID_PX), row_of(spacing=GRID_PX)
        buttons = row_of(None, *self.buttons, None)
        parts = mark, title, line, buttons, self._title, *self._rows
        column_of(self, *parts, margin=8 * GRID_PX, spacing=3 * GRID_PX)
        self.show_recent([])

    def show_recent(self, paths: Sequence[Path]) -> None:
        for link in self._links.values():
            link.deleteLater()
        photos = paths[:_MOST_RECENT]
        folders = list(dict.fromkeys(path.parent for path in paths))[:_MOST_FOLDERS]
        named = dict(zip(photos, titles(photos), strict=True))
        self._links = {it: self._link(it, name, self.wanted) for it, name in named.items()}
        for link in self._links.values():
            link.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
            link.setIconSize(QSize(_PICTURE_PX, _PICTURE_PX))
            self._rows[0].addWidget(link)
        for it in folders:
            self._links[it] = self._link(it, f"{it.name}{os.sep}", self.wants_folder)
            self._rows[1].addWidget(self._links[it])
        self._title.setVisible(bool(paths))

    def show_pictures(self, pictures: Sequence[tuple[Path, QImage]]) -> None:
        """Show the pictures of recent photos, cut to squares."""
        for path, image in pictures:
            if path in self._links and not image.isNull():
                square = QRect(QPoint(), QSize(1, 1) * min(image.width(), image.height()))
                square.moveCenter(image.rect().center())
                self._links[path].setIcon(untinted(QPixmap.fromImage(image.copy(square))))

    def show_drag(self, over: bool) -> None:
        """Show a solid frame while files are dragged over the window."""
        self.setProperty("dragged", over)
        self.style().polish(self)

    def showEvent(self, event: QShowEvent) -> None:
        """Tell that the page appears."""
        super().showEvent(event)
        self.appeared.emit()

    def _link(self, path: Path, title: str, chosen: SignalInstance) -> QToolButton:
        link = QToolButton()
        link.setProperty("picture", "true")
        link.setText(title)  # elided by Qt
        link.setMaximumWidth(_PICTURE_PX + 8 * GRID_PX)
        link.setToolTip(str(path))
        link.setAccessibleName(tr("Open {name}", name=title))
        link.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        link.clicked.connect(lambda: chosen.emit(path))
        return link


def _button(action: QAction) -> QPushButton:
    button = QPushButton(bare(action.text()))
    button.setToolTip(action.toolTip())
    button.clicked.connect(action.trigger)
    return button


class Recent(Feature):
    """Shows the menu of recent photos, and the start page while no photo is open."""

    def __init__(self, context: Context, files: Files, strip: Strip) -> None:
        super().__init__(context)
        self._open, self._files = strip.open, files
        self.empty = EmptyState([strip.folder, files.opening, files.sampling])
        self.empty.wanted.connect(strip.open)
        self.window.dragged.connect(self.empty.show_drag)
        self.empty.wants_folder.connect(lambda folder: strip.show_places([folder]))
        self._lane = self.lane(self.empty.show_pictures, lambda _: None)
        self.empty.appeared.connect(self._draw)
        self.empty.show_recent(there(self.settings))
        self.window.stage.show_in_middle(self.empty)
        self.menu = self.window.menus["recent"] = QMenu(tr("Open &recent"), self.window)
        self.menu.setToolTipsVisible(True)
        self.menu.aboutToShow.connect(self._fill)
        self.document.opened.connect(self._follow)
        files.began.connect(self.empty.hide)
        files.unreadable.connect(lambda _: self.empty.setVisible(self.document.photo is None))
        self._fill()

    def begin(self) -> None:
        """Start the tour at the very first start."""
        if not self.settings.value("welcomed", False, bool):
            self.settings.setValue("welcomed", True)
            self._files.welcome()

    def _follow(self) -> None:
        path = self.document.path
        if path is not None and not is_sample(path):
            add(self.settings, path)
            self.empty.show_recent(there(self.settings))

    def _draw(self) -> None:
        photos, edits = there(self.settings)[:_MOST_RECENT], self.storage.edits
        side = round(2 * _PICTURE_PX * self.empty.devicePixelRatioF())
        self._lane.submit(lambda: [(path, thumbnail(path, side, edits).picture) for path in photos])

    def _fill(self) -> None:
        photos = there(self.settings)
        self.menu.clear()
        for path, title in zip(photos, titles(photos), strict=True):
            action = self.menu.addAction(title.replace("&", "&&"))
            action.setToolTip(str(path))
            action.triggered.connect(lambda _=False, path=path: self._open(path))
        self.menu.addSeparator()
        forget = self.menu.addAction(tr("&Clear list"))
        forget.setEnabled(bool(paths(self.settings)))
        forget.triggered.connect(lambda: self.settings.remove(_KEY))
