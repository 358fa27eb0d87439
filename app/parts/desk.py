"""What lies round the work: film strip, recent photos, palette, keys, layout, empty state."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, QThreadPool, Signal

from .. import actions, recent
from ..controllers.dialogs import Dialogs
from ..controllers.strip import Strip
from ..document import Document
from ..i18n import tr
from ..photos import is_sample
from ..views import shortcuts
from ..views.bar import Message
from ..views.palette import Palette
from ..views.window import Window


class Desk(QObject):
    """Joins all that to the window.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    """

    said = Signal(object)

    def __init__(
        self,
        document: Document,
        dialogs: Dialogs,
        window: Window,
        settings: QSettings,
        pool: QThreadPool,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._document, self._dialogs, self._window = document, dialogs, window
        self._settings = settings
        self.strip = Strip(window.strip, pool, self)
        self.strip.said.connect(window.bar.say)
        self._wanted: Path | None = None
        shortcuts.restore(settings, window.actions_by_name)
        self.size_known = window.docks.restore(settings)
        # It was left with photos; now it is empty.
        window.docks.hide("strip")
        window.history.setStack(document.undo)
        self._join_actions()
        self._join_photos()
        document.opened.connect(self._follow)
        window.empty.show_recent(recent.there(settings))

    @property
    def busy(self) -> bool:
        """True while the strip is filled."""
        return self.strip.busy

    def stop(self) -> None:
        """Start nothing more, and remember the layout."""
        self.strip.stop()
        self._window.docks.save(self._settings)
        self._settings.sync()

    def begin(self, welcome: Callable[[], object]) -> None:
        """Welcome a new user; one who has been here is left to choose."""
        if not self._settings.value("welcomed", False, bool):
            self._settings.setValue("welcomed", True)
            welcome()

    def pass_over(self) -> None:
        """Go on along the strip after a photo that couldn't be opened, or from the beginning."""
        self._window.strip.pass_over(self._wanted)
        self._window.empty.setVisible(self._document.photo is None)

    def _join_actions(self) -> None:
        window, named = self._window, self._window.actions_by_name
        actions.connect(
            named,
            {
                "palette": self._show_palette,
                "keys": self._show_keys,
                "reset-layout": window.docks.reset,
                "next-photo": lambda: window.strip.step(1),
                "previous-photo": lambda: window.strip.step(-1),
                "folder": self._dialogs.ask_folder,
            },
        )
        named["move-panels"].toggled.connect(lambda on: window.docks.fix(not on))
        named["hide-panels"].toggled.connect(window.docks.hide_all)

    def _join_photos(self) -> None:
        window = self._window
        window.dropped.connect(self.show_places)
        self._dialogs.folder_chosen.connect(lambda folder: self.show_places([folder]))
        window.strip.wanted.connect(self._open)
        window.empty.wanted.connect(self._open)
        window.recent.aboutToShow.connect(self._fill_recent)
        self.strip.filled.connect(self._show_strip)
        self._fill_recent()

    def show_places(self, places: list[Path]) -> None:
        """Open one photo at once; of several or a folder make a film strip, and open the first."""
        if len(places) == 1 and not places[0].is_dir():
            self._dialogs.open(places[0])
        else:
            self.strip.show(places)

    def _show_strip(self, paths: list[Path]) -> None:
        if not paths:
            self._window.docks.hide("strip")
            self.said.emit(Message(tr("There is no photo in that folder; choose another one.")))
            return
        self._window.docks.show("strip")
        if self._document.path not in paths:
            self._wanted = paths[0]
            self._dialogs.open(paths[0])
        self._window.strip.mark(self._document.path)

    def _open(self, path: Path) -> None:
        if path != self._document.path:
            self._wanted = path
            self._dialogs.open(path)
        # Until it is open, and should the user keep the other one, that one stays selected.
        self._window.strip.mark(self._document.path)

    def _follow(self) -> None:
        self._wanted = None
        path = self._document.path
        if path is not None and not is_sample(path):
            recent.add(self._settings, path)
            self._window.empty.show_recent(recent.there(self._settings))
        self._window.strip.mark(path)

    def _fill_recent(self) -> None:
        menu, paths = self._window.recent, recent.there(self._settings)
        menu.clear()
        for path, title in zip(paths, recent.titles(paths), strict=True):
            action = menu.addAction(title.replace("&", "&&"))
            action.setToolTip(str(path))
            action.triggered.connect(lambda _=False, path=path: self._open(path))
        menu.addSeparator()
        forget = menu.addAction(tr("&Forget these"))
        forget.setEnabled(bool(recent.paths(self._settings)))
        forget.triggered.connect(lambda: recent.clear(self._settings))

    def _show_palette(self) -> None:
        named = [a for name, a in self._window.actions_by_name.items() if name != "palette"]
        presets = [a for a in self._window.presets.actions() if a.text() and not a.menu()]
        Palette([*named, *(a for a in presets if a not in named)], self._window).open()

    def _show_keys(self) -> None:
        named = self._window.actions_by_name
        shortcuts.ShortcutsDialog(named, self._settings, self._window).open()
