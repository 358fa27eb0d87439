"""The film strip feature: lists a folder and loads thumbnails in workers."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import QFileSystemWatcher, QTimer

from kogao_core.background.find import BackgroundFinder
from kogao_core.faces.doubt import verdicts
from kogao_core.photo.formats import READABLE, suffix_of
from kogao_core.projects.results import Results

from ...i18n import reason, tr
from ...widgets.controls import ChoiceBox
from ...widgets.dialogs import ask_path
from ...widgets.docks import Dock
from ..faces import Faces
from ..feature import Context, Feature
from ..files import Files
from ..projects import Projects
from .facts import Facts, Mark, Preview, facts_of, thumbnail
from .film import StripPanel

_MOST: Final = 2000
_SETTLE_MS: Final = 300
_AT_ONCE: Final = 16  # photos to read before the strip shows marks and stars


class Strip(Feature):
    """Lists photos with edits and stars, and opens the next photo."""

    name = "strip"

    def __init__(self, context: Context, files: Files, projects: Projects, faces: Faces) -> None:
        super().__init__(context)
        self._files = files
        self._places: list[Path] = []
        self._paths: list[Path] | None = None  # no photos listed yet
        self._wanted: Path | None = None
        self._first: Path | None = None
        self._listing = self.lane(self._fill, self._not_listed)
        # A photo without a thumbnail keeps a blank icon.
        self._drawing = self.lane(self._show, lambda _: QTimer.singleShot(0, self._draw))
        self._looking = self.lane(self._show_facts, lambda _: QTimer.singleShot(0, self._look))
        self._undrawn: dict[Path, None] = {}
        # A cache of its own: that of the open photo stays.
        self._finder = BackgroundFinder(self.live.finder.people)
        self._to_look: list[Path] = []
        self._told: dict[Path, Mark] = {}
        self._check: tuple[Path | None, str] = None, ""  # the photo to check that opens, and why
        self._watcher = QFileSystemWatcher(self)
        self._again = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._again.timeout.connect(self._list_again)
        self._watcher.directoryChanged.connect(lambda _: self._again.start())
        self.panel: StripPanel = StripPanel()
        self.film = self.panel.film
        self.dock = Dock(tr("Film strip"), scrolls=True)
        self.film.wanted.connect(self.open)
        self.film.resized.connect(self.draw_again)
        self.window.dropped.connect(self.show_places)
        self.document.opened.connect(self._follow)
        files.photos = lambda: self._paths or ()
        files.began.connect(self._pass_over)
        files.unreadable.connect(self._note_unreadable)
        projects.kept.connect(self.look_again)
        files.saved.connect(lambda request: self.look_again(request.photo.path))
        files.saved.connect(lambda request: self.look_again(request.file))
        faces.found.connect(self._note_doubts)
        self._add_actions()
        self._enable(False)

    def _add_actions(self) -> None:
        self.folder = self.bind("folder", self._ask_folder)
        self.bind("next-photo", lambda: self.film.step(1))
        self.bind("previous-photo", lambda: self.film.step(-1))
        self.bind("next-to-check", self._check_next)
        self.bind("strip-shown", lambda: _open(self.panel.choice))
        self.bind("strip-order", lambda: _open(self.panel.order))

    def _enable(self, filled: bool) -> None:
        for name in ("next-photo", "previous-photo", "next-to-check", "strip-shown", "strip-order"):
            self.actions[name].setEnabled(filled)

    @property
    def busy(self) -> bool:
        """True while a folder, facts, or thumbnails are in work."""
        return super().busy or bool(self._to_look or self._undrawn)

    def stop(self) -> None:
        super().stop()
        self._again.stop()
        self._to_look, self._undrawn = [], {}

    def _ask_folder(self) -> None:
        title = tr("Open a folder")
        ask_path(
            self.window, title, lambda it: self.show_places([it]), "folder", at=self._files.folder
        )

    def show_places(self, places: list[Path]) -> None:
        """Open a single photo; show several photos or a folder as a film strip."""
        if not places:
            self.say(tr("This isn't a file on this computer. Save it here first."))
        elif len(places) == 1 and not os.path.isdir(places[0]):
            self._files.open(places[0])
        else:
            self.show(places)

    def open(self, path: Path) -> None:
        """Open another photo. The strip marks the open photo until then, or after a cancel."""
        self.film.mark(self.document.path)
        if path == self.document.path:
            self._wanted = None
            self._files.stay()
        else:
            self._wanted = path
            self._files.open(path)

    def _check_next(self) -> None:
        found = self.film.next_to_check()
        if found is None:
            self.say(tr("No photo of the strip is left to check."), wrong=False)
            return
        path, why = found
        first, *rest = (why or tr("the list of faces says why")).splitlines()
        text = tr("To check: {name}, {why}", name=path.name, why=first)
        self._check = path, "\n".join([text, *rest])
        self.open(path)
        if path == self.document.path:
            self._follow()

    def _follow(self) -> None:
        self._wanted, path = None, self.document.path
        self.film.mark(path)
        if path == self._check[0]:
            self.say(self._check[1], wrong=False, applies=lambda: self.document.path == path)
        self._check = None, ""

    def _pass_over(self) -> None:
        """Continue along the strip from a photo that is opening or failed to open."""
        self.film.pass_over(self._wanted)

    # -- content ---------------------------------------------------------------------------------

    def show(self, places: Sequence[Path], first: Path | None = None) -> None:
        """Show these photos and the photos in these folders; open one photo."""
        # Open photos are identified by absolute paths.
        places = [place.absolute() for place in places]
        self._list(places, first)

    def chosen(self) -> list[Path]:
        """Return the selected photos, without results."""
        return self.film.listed(chosen=True)

    def photos(self) -> list[Path]:
        """Return the visible photos, without results; without a filter also those not shown."""
        rest = [] if self.panel.choice.currentIndex() else (self._paths or [])[_MOST:]
        return self.film.listed() + rest

    def _list_again(self) -> None:
        self._list(self._places, self._first)

    def _list(self, places: list[Path], first: Path | None) -> None:
        results = self.storage.results
        self._listing.submit(lambda: (places, *_with_first(photos_in(places), results, first)))

    def _fill(self, listed: tuple[list[Path], list[Path], Path | None]) -> None:
        places, paths, first = listed
        if is_new := places is not self._places:
            if self._paths and not paths:
                self.say(tr("No photos in this folder."))
                return
            self._take(places)
        elif paths == self._paths:
            return
        self._first = first
        self._paths = paths
        self.window.bar.refresh()
        shown = paths[:_MOST]
        self.film.show_paths(shown)
        self._to_look, self._undrawn = shown, dict.fromkeys(shown)
        if len(paths) > _MOST:
            text = tr("{n:,} of {count:,} photos are shown. Export takes all.",
                      n=_MOST, count=len(paths))  # fmt: skip
            self.say(text, wrong=False, applies=lambda: self._paths is paths)
        self._show_strip(paths, is_new)
        self._look()
        self._draw()

    def _take(self, places: list[Path]) -> None:
        if self._watcher.directories():
            self._watcher.removePaths(self._watcher.directories())
        for folder in (place for place in places if os.path.isdir(place)):
            self._watcher.addPath(str(folder))
        self._places = places
        self.panel.show_all()

    def follow(self, before: Path, now: Path) -> None:
        """List the folder of a renamed photo again, also under a new name of the folder."""
        renamed = {before: now, before.parent: now.parent}
        places = [renamed.get(place, place) for place in self._places]
        if places != self._places:
            self._take(places)
        if places:
            self._list_again()

    def _show_strip(self, paths: list[Path], is_new: bool) -> None:
        self.window.docks.offer("strip", bool(paths))
        self._enable(bool(paths))
        if not paths:
            self.say(tr("No photos in this folder."))
            return
        self._name_left_out(paths)
        self.window.docks.show("strip")
        if is_new and self.document.path not in paths:
            self._wanted = self._first or paths[0]
            self._files.open(self._wanted)
        self.film.mark(self.document.path)

    def _name_left_out(self, paths: list[Path]) -> None:
        """Show which of the named files are no photos, until the next photo is opened."""
        places, first = self._places, (None, self.document.path, self._first)
        left_out = [one.name for one in places if one not in paths and not os.path.isdir(one)]
        if left_out:
            text = tr("Not photos, so not on the film strip: {names}.", names=", ".join(left_out))
            self.say(text, applies=lambda: self._places is places and self.document.path in first)

    def _not_listed(self, problem: Exception) -> None:
        text = tr("The photos can't be listed ({why}); open one by its name.", why=reason(problem))
        path = self.document.path
        self.say(text, applies=lambda: self._paths is None and self.document.path == path)

    # -- marks and thumbnails --------------------------------------------------------------------

    def look_again(self, path: Path, told: Mark = "") -> None:
        """Read the facts of a photo again and redraw; `told` is a mark that no file records."""
        if path in self.film:
            self._told[path] = told
            self._undrawn[path] = None
            self._draw()
            self._look_at(path)

    def _look_at(self, path: Path) -> None:
        self._to_look.append(path)
        self._look()

    def _look(self) -> None:
        if self._to_look and not self._looking.busy:
            paths, self._to_look = self._to_look[:_AT_ONCE], self._to_look[_AT_ONCE:]
            results, edits = self.storage.results, self.storage.edits
            self._looking.submit(lambda: {path: facts_of(path, results, edits) for path in paths})

    def _show_facts(self, found: dict[Path, Facts]) -> None:
        for path, facts in found.items():
            told = self._told.get(path)
            if told and facts.mark != "result":
                facts = Facts(told, facts.rated)
            self.film.show_facts(path, facts)
        if not self._to_look:
            self.panel.sort()
        # Deferred: the lane is busy until this slot returns.
        QTimer.singleShot(0, self._look)

    def _note_unreadable(self) -> None:
        self._pass_over()
        if self._wanted is not None:
            self.look_again(self._wanted, "failed")

    def _note_doubts(self) -> None:
        path, state = self.document.path, self.document.state
        if path is not None:
            judged = verdicts(state.faces, self.document.image)
            asks = [v.why and (v.reason is None or n in state.off) for n, v in enumerate(judged)]
            self.look_again(path, "doubtful" if any(asks) else "")

    def draw_again(self) -> None:
        """Redraw all thumbnails, after a change of size or of the screen's colours."""
        self._undrawn = dict.fromkeys((self._paths or [])[:_MOST])
        self._draw()

    def _draw(self) -> None:
        if self._drawing.busy or not self._undrawn:  # the strip is gone after `stop`
            return
        path = self.film.next_of(self._undrawn)
        # The lookup may lay out and resize the strip, which calls this method.
        if path in self._undrawn and not self._drawing.busy:
            del self._undrawn[path]
            side_px, edits = self.side_px, self.storage.edits
            finder = self._finder
            self._drawing.submit(lambda: (path, thumbnail(path, side_px, edits, finder)))

    @property
    def side_px(self) -> int:
        """Side of a thumbnail in pixels of the screen."""
        return round(self.film.iconSize().width() * self.film.devicePixelRatioF())

    def _show(self, drawn: tuple[Path, Preview]) -> None:
        self.film.show_thumbnail(*drawn)
        QTimer.singleShot(0, self._draw)


def _open(box: ChoiceBox) -> None:
    box.setFocus()
    box.showPopup()


def _with_first(
    paths: list[Path], results: Results, first: Path | None
) -> tuple[list[Path], Path | None]:
    """Return the photos and the photo to open: `first`, or the first photo that is no result."""
    if first in paths:
        return paths, first
    photos = (path for path in paths if results.origin(path) is None)
    return paths, next(photos, paths[0] if paths else None)


def photos_in(places: Sequence[Path]) -> list[Path]:
    """Return the photos among `places` and inside folders, sorted by name within a folder."""
    found: list[Path] = []
    for place in places:
        try:
            inside = sorted(place.iterdir()) if place.is_dir() else [place]
        except OSError:  # skip unreadable folders
            continue
        found += [path for path in inside if suffix_of(path) in READABLE and path.is_file()]
    return list(dict.fromkeys(found))
