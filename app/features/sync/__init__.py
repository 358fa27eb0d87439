"""Sync settings of the open photo to the photos selected on the film strip, with a preview."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QTimer
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from kogao_core.base.index import locked
from kogao_core.faces.names import NobodyNamed
from kogao_core.projects.acts import ActPhoto, Acts
from kogao_core.recipe.recipe import FACE_FIELDS, SETTINGS, SHAPE, Recipe

from ...document import ReplaceState
from ...i18n import bare, reason, tr, tr_count
from ...widgets.messages import BarAction
from ..faces import Faces
from ..feature import Context, Feature
from ..files.saver import Saver
from ..projects import Projects
from ..strip import Strip
from ..strip.facts import Preview, Sample
from .one_photo import Outcome, Settings, loaded, step_text, synced

_GROUPS: Final = "sync/groups"
_SETTLE_MS: Final = 100
_NOT_AT_FIRST: Final = "lens"  # groups that are copied only once they are ticked


def groups() -> dict[str, tuple[str, frozenset[str]]]:
    """Return the title and the recipe fields of each group of settings."""
    parts = set(SHAPE)
    lens = {name for name in SETTINGS if name.startswith("lens")}
    method = {name for name, one in SETTINGS.items() if one.is_method}
    amount = set(SETTINGS) - parts - lens - method
    return {
        "amount": (tr("&Amount and direction"), frozenset(amount)),
        "shape": (tr("&Face shape"), frozenset(parts)),
        "lens": (tr("&Lens correction"), frozenset(lens)),
        "method": (tr("&Method"), frozenset(method)),
    }


class Sync(Feature):
    """Applies settings to the selected photos, and shows their thumbnails with them before.

    Each photo gets one undo step, and the open photo one for all of them. While photos are
    selected, each change of the open photo's settings is drawn into their thumbnails; photos with
    a warning get a ring.
    """

    def __init__(
        self, context: Context, strip: Strip, faces: Faces, projects: Projects, saver: Saver
    ) -> None:
        super().__init__(context)
        self._strip, self._faces, self._projects = strip, faces, projects
        self._store = Acts(self.storage.data)
        self._acts: list[tuple[int, bool]] = []  # that wait, and whether to apply or undo them
        self._act: int | None = None  # under way
        self._wanted, self._waiting = True, list[ActPhoto]()
        self._total, self._went = 0, dict[Outcome, list[str]]()  # names of the photos by outcome
        # The acts of the open photo by index and text of their undo steps.
        self._steps: dict[tuple[int, str], int] = {}
        self._base, self._index = self.document.base, 0
        self._knowing = self.lane(self._known, lambda _: None)
        self._lock, self._lock_place = ExitStack(), (self.storage.data / "locks", "sync")
        self.document.undo.indexChanged.connect(self._cross)
        self.document.opened.connect(self._know)
        # On the thread that saves edits: a photo that was just left is saved before.
        self._syncing = self.lane(self._synced, self._not_synced, saver.edits_thread)
        self._samples: dict[Path, Sample | None] = {}
        self._undrawn: dict[Path, None] = {}
        self._selected: list[Path] = []
        self._last = Recipe()  # of the open photo, when a preview was last drawn
        self._drawing = self.lane(self._drawn, self._not_drawn)
        self.action = self.bind("give-settings", self.start)
        strip.film.addAction(self.action)
        self.auto = self.bind("auto-sync", checked=False)
        self.menu = QMenu(tr("Settings to sync"), self.window)
        self._groups = {name: self._group(name, title) for name, (title, _) in groups().items()}
        self.menu.addSeparator()
        self.menu.addAction(self.auto)
        self.auto.toggled.connect(self._name_groups)
        self._name_groups()
        self.person = self.bind("give-person", self.start_person)
        strip.panel.offer_sync(self.action, self.menu, self.person)
        self.view.watch(self._name_person, "face")
        # Photos and drags come many at a time.
        self._naming = QTimer(self, singleShot=True, interval=_SETTLE_MS)
        self._naming.timeout.connect(self._name_person)
        self.document.watch(self._naming.start, "faces")
        strip.film.counted.connect(self._naming.start)
        strip.film.itemSelectionChanged.connect(self._select)
        self.document.opened.connect(self._select)
        self.view.watch(self._preview, "frame")

    def _group(self, name: str, title: str) -> QAction:
        action = self.menu.addAction(title)
        action.setCheckable(True)
        off = str(self.settings.value(_GROUPS, _NOT_AT_FIRST)).split(",")
        action.setChecked(name not in off)
        action.toggled.connect(self._choose_groups)
        return action

    def _choose_groups(self) -> None:
        off = [name for name, action in self._groups.items() if not action.isChecked()]
        self.settings.setValue(_GROUPS, ",".join(off))
        self._last = Recipe()
        self._preview()
        self._name_groups()

    def _name_groups(self) -> None:
        """Name beside the button what is copied."""
        on = [bare(it.text()) for it in self._groups.values() if it.isChecked()]
        names = ", ".join(on) or tr("nothing is ticked")
        is_auto = self.auto.isChecked()
        self._strip.panel.show_groups(tr("Auto sync: {names}", names=names) if is_auto else names)

    @property
    def _chosen(self) -> Settings:
        on = (names for name, (_, names) in groups().items() if self._groups[name].isChecked())
        return Settings(self.document.state.recipe, frozenset[str]().union(*on))

    @property
    def busy(self) -> bool:
        """True while photos are synced or drawn."""
        return super().busy or self._act is not None or bool(self._undrawn)

    def stop(self) -> None:
        self._waiting, self._acts, self._act, self._undrawn = [], [], None, {}
        self._naming.stop()
        super().stop()

    # -- the preview -------------------------------------------------------------------------------

    def _select(self) -> None:
        """Follow the selection; thumbnails that are no longer selected show saved edits again."""
        own = self.document.path
        selected = [path for path in self._strip.chosen() if path != own]
        for path in self._samples.keys() - set(selected):
            self._strip.look_again(path)
        self._samples = {path: one for path, one in self._samples.items() if path in selected}
        self._undrawn = {path: None for path in self._undrawn if path in selected}
        if selected and not self._selected:
            self._last = self.document.state.recipe
        self._selected = selected
        self._strip.panel.show_selected(len(selected))

    def _preview(self) -> None:
        """Draw the selected thumbnails once the settings of the open photo change."""
        if self._selected and self.document.state.recipe != self._last:
            self._last = self.document.state.recipe
            self._undrawn = dict.fromkeys(self._selected)
            self._draw()

    def _draw(self) -> None:
        path = None if self._drawing.busy else self._strip.film.next_of(self._undrawn)
        if path is None:
            return
        del self._undrawn[path]
        settings, known, first = self._chosen, self._samples.get(path), self.document.first_recipe
        store, search, side_px = self.storage.edits, self._faces.search(), self._strip.side_px

        def draw() -> tuple[Path, Sample, Preview]:
            project = known.project if known else loaded(path, store, search, first)[0]
            sample = known or Sample.of(path, side_px, project)
            return path, sample, sample.drawn(settings.of_project(project))

        self._drawing.submit(draw)

    def _drawn(self, drawn: tuple[Path, Sample, Preview]) -> None:
        path, sample, preview = drawn
        if path in self._selected:
            self._samples[path] = sample
            self._strip.film.show_thumbnail(path, preview)
        QTimer.singleShot(0, self._draw)

    def _not_drawn(self, _: Exception) -> None:
        QTimer.singleShot(0, self._draw)  # an unreadable photo keeps its thumbnail

    # -- the sync ----------------------------------------------------------------------------------

    def start(self) -> None:
        """Apply the settings to the selected photos, or cancel while this is under way."""
        if self._act is not None:
            self._waiting, self._acts = [], []
        elif self._selected and self.document.path is not None:
            text = tr_count(len(self._selected), "Apply to {n} photo", "Apply to {n} photos")
            self._apply(self._chosen, self._selected, text)
        else:
            self.say(tr("Select other photos on the film strip first, with Shift or Ctrl."))

    def start_person(self) -> None:
        """Apply the settings of the selected face to the person's face in all visible photos."""
        face, name, photos = self._person
        if photos and self._act is None:
            names = self._chosen.names & set(FACE_FIELDS)
            settings = Settings(self.document.state.recipe_of(face), names, name)
            # Undo steps are stored without names.
            text = tr_count(len(photos), "Apply to one person in {n} photo",
                            "Apply to one person in {n} photos")  # fmt: skip
            self._apply(settings, photos, text)
        elif not photos:
            self.say(tr("Select a face with a name that other photos of the film strip have, too."))

    @property
    def _person(self) -> tuple[int | None, str, list[Path]]:
        """The selected or only face, the name of the person, and other photos with that name."""
        face, names = self.view.face, self._faces.names
        if face is None and len(names) == 1:
            face = 0
        name = names[face] if face is not None and face < len(names) else ""
        photos = self._strip.film.named(name) if name else []
        return face, name, [path for path in photos if path != self.document.path]

    def _name_person(self) -> None:
        """Show the person of the selected face on the button, with the number of other photos."""
        _, name, photos = self._person
        text = tr_count(len(photos), "{name}, {n} photo", "{name}, {n} photos", name=name)
        self._strip.panel.show_person(text if photos else "")

    def _apply(self, settings: Settings, photos: Sequence[Path], text: str) -> None:
        """Apply settings to other photos by one undo step of the open photo."""
        self.document.commit()
        self._index = self.document.undo.index() + 1  # this step is no redo
        self.document.step(replace(self.document.state), text)
        self._projects.keep(anyway=True)
        self._begin(settings, photos)

    def _begin(self, settings: Settings, photos: Sequence[Path]) -> None:
        """Apply settings to other photos; the act belongs to the last undo step."""
        step, path = self.document.undo.index(), self.document.path
        text = self.document.undo.text(step - 1)
        if path is not None and photos and settings.names:
            act = self._store.begin(path, step, text, settings.values, photos)
            self._steps[step, text] = act
            self._turn(act, True)

    def _know(self) -> None:
        """Find the acts that belong to undo steps of the open photo."""
        path, store = self.document.path, self._store
        self._steps = {}
        if path is not None:
            self._knowing.submit(lambda: (path, store.of(path)))

    def _known(self, found: tuple[Path, dict[tuple[int, str], int]]) -> None:
        path, steps = found
        if path == self.document.path:
            self._steps = steps | self._steps

    def _cross(self, index: int) -> None:
        """Undo and redo the acts of the steps between; with Auto sync, apply a new change."""
        undo, last, self._index = self.document.undo, self._index, index
        if self._base is not self.document.base:  # another photo, or its steps as they were saved
            self._base = self.document.base
            return
        forward = index > last
        crossed = range(last, index) if forward else range(last - 1, index - 1, -1)
        acts = [self._steps.get((at + 1, undo.text(at))) for at in crossed]
        for act in acts:
            if act is not None:
                self._turn(act, forward)
        step = undo.command(index - 1) if forward else None
        is_new = acts == [None] and not undo.canRedo()
        if self.auto.isChecked() and is_new and isinstance(step, ReplaceState):
            before, after = step.before.recipe, step.after.recipe
            names = {it for it in SETTINGS if getattr(before, it) != getattr(after, it)}
            self._begin(Settings(after, self._chosen.names & names), self._selected)

    def look(self) -> None:
        """Ask what becomes of an act that another program left in the middle."""
        left = None
        with suppress(OSError), locked(*self._lock_place):  # held: a window is at work on one
            left = self._store.unfinished()
        if left is None:
            return
        act, wanted, n, total = left
        text = tr(
            "Settings for several photos: {n} of {total} were changed before Kogao ended.",
            n=n,
            total=total,
        )
        self.say(
            text,
            BarAction(tr("Leave it"), lambda: self._store.leave(act)),
            BarAction(tr("Undo"), lambda: self._turn(act, not wanted)),
            BarAction(tr("Finish"), lambda: self._turn(act, bool(wanted))),
            wrong=False,
            applies=lambda: True,
        )

    def _turn(self, act: int, wanted: bool) -> None:
        """Apply or undo an act after those that wait."""
        self._acts.append((act, wanted))
        if self._act is None:
            self._next_act()

    def _next_act(self) -> None:
        if not self._acts:
            self._lock.close()
            return
        with suppress(OSError):  # held, by this window too: go on
            self._lock.enter_context(locked(*self._lock_place))
        self._act, self._wanted = self._acts.pop(0)
        self._waiting = self._store.turn(self._act, self._wanted)
        self._total, self._went = len(self._waiting), {}
        self._next()

    def _next(self) -> None:
        if not self._waiting:
            self._end()
            return
        photo = self._waiting.pop(0)
        path, store, first = photo.path, self._store, self.document.first_recipe
        sample, search = self._samples.get(path), self._faces.search()
        keeping = self._projects.keeping(path)
        n = tr("{n} of {total}", n=self._total - len(self._waiting), total=self._total)
        self.working.emit(tr("Settings: {n}…", n=n))
        self._strip.panel.show_running(n, self.start)
        faces = None if sample is None else sample.project.automatic.faces
        self._syncing.submit(partial(synced, photo, store, keeping, search, first, faces))

    def _synced(self, synced: tuple[ActPhoto, Outcome]) -> None:
        photo, outcome = synced
        path, undo = photo.path, self.document.undo
        self._went.setdefault(outcome, []).append(path.name)
        self._samples.pop(path, None)
        if path == self.document.path and self._projects.adopt(path):
            # The photo was opened before its file was written.
            if photo.wanted:
                self._step(Settings.of(photo.settings), alone=outcome == "new")
            elif undo.undoText() == step_text():
                undo.undo()
        self._strip.look_again(path)
        self._next()

    def _step(self, settings: Settings, *, alone: bool) -> None:
        """Apply settings to the open photo."""
        with suppress(NobodyNamed):  # its faces were edited since
            state = settings.of_state(self.document.state, self.document.photo, alone=alone)
            self.document.step(state, step_text())

    def _not_synced(self, problem: Exception) -> None:
        self.say(tr("The settings can't be applied: {problem}", problem=reason(problem)))
        self._next()

    def _end(self) -> None:
        self._strip.panel.show_running("")
        self.working.emit("")
        if self._act is not None:
            self._store.leave(self._act)
        names = {outcome: ", ".join(one) for outcome, one in self._went.items()}
        edited = len(self._went.get("edited", ()))
        self._act, count = None, len(self._went.get("new", ())) + edited
        if self._wanted:
            text = tr_count(
                count, "Settings applied to {n} photo", "Settings applied to {n} photos"
            )
            had = tr("{n} had edits", n=edited)
            self.did.emit(tr("{text} ({had}); undo is one step", text=text, had=had))
        elif self._total:
            self.did.emit(tr_count(count, "Undone in {n} photo", "Undone in {n} photos"))
        if "newer" in names:
            text = tr("Newer edits stay as they are: {names}.", names=names["newer"])
            self.say(text, wrong=False)
        if "doubtful" in names:
            text = tr("Left alone, since the person's face isn't certain: {names}.",
                      names=names["doubtful"])  # fmt: skip
            self.say(text, wrong=False)
        self._next_act()
