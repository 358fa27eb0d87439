"""Recent photos and folders: the start page and the menu."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Final

from PySide6.QtCore import QEvent, QSettings, Qt, Signal, SignalInstance
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QFrame, QLabel, QMenu, QPushButton, QVBoxLayout

from ..i18n import bare, tr
from ..theme import GRID_PX
from ..widgets.controls import column_of, heading, muted_label
from .feature import Context, Feature
from .files import Files
from .files.opening import is_sample
from .strip import Strip

_KEY: Final = "recent"
_MOST: Final = 10
_MOST_RECENT: Final = 5
_MOST_FOLDERS: Final = 3


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
    """The start page: buttons, recent folders and recent photos."""

    # (photo: Path): open a recent photo.
    wanted = Signal(object)
    # (folder: Path): open a recent folder.
    wants_folder = Signal(object)

    def __init__(self, begin: Sequence[QAction]) -> None:
        super().__init__()
        self.setProperty("bar", "hint")
        self.setAccessibleName(tr("No photo is open"))
        self.buttons = [_button(action) for action in begin]
        column = column_of(
            self,
            heading(tr("Make a face a little smaller")),
            muted_label(tr("Drop photos or a folder here")),
            *self.buttons,
            margin=6 * GRID_PX,
            spacing=2 * GRID_PX,
        )
        self._links: list[QLabel] = []
        self._title = muted_label(tr("Recent"))
        column.addSpacing(2 * GRID_PX)
        column.addWidget(self._title)
        self._recent = QVBoxLayout()
        self._recent.setSpacing(GRID_PX)
        column.addLayout(self._recent)
        self.show_recent([])

    def show_recent(self, paths: Sequence[Path]) -> None:
        """Show recent folders, then recent photos."""
        for link in self._links:
            link.deleteLater()
        folders = list(dict.fromkeys(path.parent for path in paths))[:_MOST_FOLDERS]
        photos = paths[:_MOST_RECENT]
        self._links = [
            *(self._link(it, f"{it.name}{os.sep}", self.wants_folder) for it in folders),
            *(self._link(*it, self.wanted) for it in zip(photos, titles(photos), strict=True)),
        ]
        for link in self._links:
            self._recent.addWidget(link)
        self._title.setVisible(bool(paths))

    def changeEvent(self, event: QEvent) -> None:
        """Update the colour of links after a change of the theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            for link in self._links:
                _colour(link)

    def _link(self, path: Path, title: str, chosen: SignalInstance) -> QLabel:
        link = QLabel()
        link.setProperty("title", escape(title, quote=False))
        _colour(link)
        link.setToolTip(str(path))
        link.setAccessibleName(tr("Open {name}", name=title))
        link.setTextInteractionFlags(
            Qt.TextInteractionFlag.LinksAccessibleByMouse
            | Qt.TextInteractionFlag.LinksAccessibleByKeyboard
        )
        link.linkActivated.connect(lambda _: chosen.emit(path))
        return link


def _colour(link: QLabel) -> None:
    colour = QApplication.palette().link().color().name()
    link.setText(f'<a href="#" style="color: {colour}">{link.property("title")}</a>')


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
        self.empty.wants_folder.connect(lambda folder: strip.show_places([folder]))
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
