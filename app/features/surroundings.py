"""Looks at the background near the faces: its straight lines, and people before it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import Signal

from kogao_core.background.find import BackgroundFinder, Bends, measure
from kogao_core.background.lines import BentLine
from kogao_core.background.people import PersonFinder, PersonMask
from kogao_core.base.assets import AssetMissing
from kogao_core.base.display import Rgb8
from kogao_core.base.geometry import Affine, Image, Line
from kogao_core.faces.landmarks import ModelRefused
from kogao_core.projects.json import as_line

from ..i18n import reason, sentence, tr
from ..view_state import RenderedFrame
from .feature import Context, Feature
from .overlays import Overlays

_MASK_PX: Final = 1600  # longer side of the people's picture


@dataclass(frozen=True, eq=False)
class BackgroundSeen:
    """What a look at the background brought, as far as anyone asked."""

    bends: Bends  # lines and their bend
    people: Rgb8 | None  # uint8 (H, W): see `ViewState.people`
    note: str  # what is worth knowing of it; empty for nothing


class Surroundings(Feature):
    """Keeps lines and people up with the newest whole photo while their overlays are on."""

    seen = Signal()
    not_seen = Signal(str)

    def __init__(self, context: Context, overlays: Overlays) -> None:
        super().__init__(context)
        self._frame: RenderedFrame | None = None
        self._note = ""
        self._lane = self.lane(self._show, self._fail)
        self.add_action(
            "lines-go",
            tr("Let all lines &go"),
            "Shift+S",
            tr("Let the warp bend every straight line of the background"),
            self.let_all_go,
        )
        self.add_action(
            "lines-hold",
            tr("H&old all lines"),
            "Shift+H",
            tr("Keep every straight line of the background straight where it can be"),
            self.hold_all,
        )
        self.window.canvas.line_clicked.connect(self.toggle)
        self.live.drawn.connect(self._follow)
        self.document.opened.connect(self._forget)
        for name in ("straight", "people"):
            overlays.switches[name].toggled.connect(self._look)

    def toggle(self, line: BentLine) -> None:
        """Let a line go that is held, or hold one that was let go; it is one undo step."""
        seen = self.live.background
        if seen is None:
            return
        text = tr("Hold a line") if line.holding == "let go" else tr("Let a line go")
        self._step(seen.toggled((line.start_px, line.end_px), self.document.state.loose), text)

    def let_all_go(self) -> None:
        """Hold no line, neither those seen now nor those let go before."""
        seen, loose = self.live.background, self.document.state.loose
        if seen is not None:
            more = (as_line(line) for line in seen.lines if not seen.is_loose(line, loose))
            self._step((*loose, *more), tr("Let all lines go"))

    def hold_all(self) -> None:
        """Hold every line, and hold them at all."""
        before = self.document.state
        if before.loose or not before.recipe.hold_background:
            state = before.with_choices(None, hold_background=True)
            self.document.step(dataclasses.replace(state, loose=()), tr("Hold all lines"))

    def _step(self, loose: tuple[Line, ...], text: str) -> None:
        if loose != self.document.state.loose:
            self.document.step(dataclasses.replace(self.document.state, loose=loose), text)

    def _follow(self, frame: RenderedFrame) -> None:
        if frame.whole:
            self._frame = frame
            self._look()

    def _look(self) -> None:
        """Look if one of the overlays is on."""
        photo, frame, finder = self.document.photo, self._frame, self.live.finder
        wanted = self._wanted
        self.window.bar.refresh()
        if photo is not None and frame is not None and wanted:
            self._lane.submit(lambda: look(photo.pixels, frame, finder, wanted))

    @property
    def _wanted(self) -> set[str]:
        return self.view.visible & {"straight", "people"}

    def _show(self, seen: BackgroundSeen) -> None:
        self.view.lines, self.view.people = seen.bends.lines, seen.people
        if seen.note not in ("", self._note):
            self.say(sentence(seen.note), wrong=False)
        self._note = seen.note
        self.window.canvas.redraw()
        self.seen.emit()

    def _fail(self, problem: Exception) -> None:
        text = tr("The background can't be measured ({why}).", why=reason(problem))
        frame = self._frame
        self.say(text, applies=lambda: self._frame is frame and bool(self._wanted))
        self.not_seen.emit(text)

    def _forget(self) -> None:
        self._lane.drop()
        self._frame = None
        self.view.lines, self.view.people = (), None


def look(
    photo: Image, frame: RenderedFrame, finder: BackgroundFinder, wanted: set[str]
) -> BackgroundSeen:
    """Look at the background of a whole result."""
    bends, people, note = Bends(()), None, ""
    if frame.done.faces and "people" in wanted:
        people, note = _people(photo, frame, finder.people)
    if frame.done.faces and "straight" in wanted:
        bends = measure(photo, frame.rendering, frame.done, finder)
        note = bends.note or note
    return BackgroundSeen(bends, people, note)


def _people(photo: Image, frame: RenderedFrame, finder: PersonFinder) -> tuple[Rgb8 | None, str]:
    """Return where people are, and why that isn't all."""
    try:
        found = finder.find(photo, frame.done.faces)
    except (AssetMissing, ModelRefused) as problem:
        return None, str(problem)
    note = tr("Some faces couldn't be told from the background.") if found.missed else ""
    return _picture(found, photo), note


def _picture(people: PersonMask, photo: Image) -> Rgb8:
    sides = [photo.shape[1], photo.shape[0]]
    scale = min(1.0, _MASK_PX / max(sides))
    width, height = (max(1, round(scale * side)) for side in sides)
    smaller = Affine.resize(width / sides[0], height / sides[1])
    return people.mapped(smaller).picture(width, height)
