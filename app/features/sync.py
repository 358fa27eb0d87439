"""Sync settings of the open photo to the photos selected on the film strip, with a preview."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Final, Literal

from PySide6.QtCore import QTimer
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from kogao_core.base import json_reader
from kogao_core.base.geometry import Box
from kogao_core.base.index import locked
from kogao_core.base.wording import printable
from kogao_core.faces.face import Face
from kogao_core.photo import read
from kogao_core.photo.picture import sha256_of
from kogao_core.projects import sidecar
from kogao_core.projects.acts import ActPhoto, Acts
from kogao_core.projects.edits import Edits, SavedEdits
from kogao_core.projects.project import Project, from_node, load, to_bytes
from kogao_core.recipe.recipe import SETTINGS, SHAPE, VERSION, Recipe

from ..ahead import FaceSearch
from ..document import ReplaceState, State, UndoSteps
from ..i18n import bare, reason, tr, tr_count
from ..widgets.messages import BarAction
from .faces import Faces
from .feature import Context, Feature
from .files import history
from .files.history import project_of, state_of
from .files.saver import Saver
from .projects import Keeping, Projects
from .strip import Strip
from .strip.facts import Preview, Sample

_GROUPS: Final = "sync/groups"
_NOT_AT_FIRST: Final = "lens"  # groups that are copied only once they are ticked
Outcome = Literal["new", "edited", "newer"]  # a photo without, with, and with newer edits


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


@dataclass(frozen=True, slots=True)
class Settings:
    """A recipe and the fields of it that are copied to other photos."""

    recipe: Recipe
    names: frozenset[str]

    @staticmethod
    def of(values: Mapping[str, Any]) -> Settings:
        """Return the settings that an act stores. Raises ValueError."""
        return Settings(Recipe.from_dict({"version": VERSION, **values}), frozenset(values))

    def onto(self, recipe: Recipe) -> Recipe:
        """Return another photo's recipe with the copied fields."""
        return replace(recipe, **{name: getattr(self.recipe, name) for name in self.names})

    def of_project(self, project: Project) -> Project:
        """Return a project whose two modes have the copied fields."""
        return project_of(self.of_state(state_of(project)), project.original)

    def of_state(self, state: State) -> State:
        """Return a state whose two modes have the copied fields."""
        other = state.kept
        kept = other and replace(other, recipe=self.onto(other.recipe))
        return replace(state, recipe=self.onto(state.recipe), kept=kept)


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
        self._total = self._failed = self._edited = 0
        self._newer: list[str] = []
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
        strip.panel.offer_sync(self.action, self.menu)
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
            self.document.commit()
            text = tr_count(len(self._selected), "Apply to {n} photo", "Apply to {n} photos")
            self._index = self.document.undo.index() + 1  # this step is no redo
            self.document.step(replace(self.document.state), text)
            self._projects.keep(anyway=True)
            self._begin(self._chosen)
        else:
            self.say(tr("Select other photos on the film strip first, with Shift or Ctrl."))

    def _begin(self, settings: Settings) -> None:
        """Apply settings to the selected photos; the act belongs to the last undo step."""
        step, path = self.document.undo.index(), self.document.path
        values = {name: getattr(settings.recipe, name) for name in settings.names}
        text = self.document.undo.text(step - 1)
        if path is not None and self._selected and values:
            act = self._store.begin(path, step, text, values, self._selected)
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
            self._begin(Settings(after, self._chosen.names & names))

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
        self._total, self._failed, self._edited, self._newer = len(self._waiting), 0, 0, []
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
        self._edited += outcome != "new"
        if outcome == "newer":
            self._newer.append(path.name)
        self._samples.pop(path, None)
        if path == self.document.path and self._projects.adopt(path):
            # The photo was opened before its file was written.
            if photo.wanted:
                settings = Settings.of(photo.settings)
                self.document.step(settings.of_state(self.document.state), _step())
            elif undo.undoText() == _step():
                undo.undo()
        self._strip.look_again(path)
        self._next()

    def _not_synced(self, problem: Exception) -> None:
        self._failed += 1
        self.say(tr("The settings can't be applied: {problem}", problem=reason(problem)))
        self._next()

    def _end(self) -> None:
        self._strip.panel.show_running("")
        self.working.emit("")
        if self._act is not None:
            self._store.leave(self._act)
        self._act, count = None, self._total - self._failed - len(self._newer)
        if self._wanted:
            text = tr_count(
                count, "Settings applied to {n} photo", "Settings applied to {n} photos"
            )
            had = tr("{n} had edits", n=self._edited)
            self.did.emit(tr("{text} ({had}); undo is one step", text=text, had=had))
        elif self._total:
            self.did.emit(tr_count(count, "Undone in {n} photo", "Undone in {n} photos"))
        if self._newer:
            names = ", ".join(self._newer)
            self.say(tr("Newer edits stay as they are: {names}.", names=names), wrong=False)
        self._next_act()


def loaded(
    path: Path,
    edits: Edits,
    search: FaceSearch,
    first: Recipe,
    faces: Collection[Face] | None = None,
) -> tuple[Project, SavedEdits | None]:
    """Return the saved project of a photo and its place, or a new project with the faces found.

    `faces` are known faces. Raises UnreadablePhoto, BadFile, OSError.
    """
    kept = edits.find(path, reads=True).edits
    if kept is not None:
        return load(kept.file), kept
    photo = read(path)
    edits.note(photo)
    found = search.run(photo) if faces is None else list(faces)
    image = Box.of(photo.pixels)
    state = State(recipe=first).with_found(found, image)
    return project_of(state, sidecar.original(photo)), None


def _step() -> str:
    """Return the text of the undo step in each photo."""
    return tr("Sync settings")


def synced(
    photo: ActPhoto,
    acts: Acts,
    keeping: Keeping,
    search: FaceSearch,
    first: Recipe,
    faces: Collection[Face] | None = None,
) -> tuple[ActPhoto, Outcome]:
    """Apply the settings of an act to a photo as one undo step, or undo the step.

    A photo that was edited since leaves the act. Raises UnreadablePhoto, BadFile, OSError.
    """
    path, settings = photo.path, Settings.of(photo.settings)
    project, kept = loaded(path, keeping.edits, search, first, faces)
    outcome: Outcome = "new" if kept is None else "edited"
    now = "" if kept is None else sha256_of(kept.file)
    is_as_written = bool(now) and now == photo.wrote
    steps = kept and history.find(keeping.edits, kept, project)
    # A copy of the picture may have steps that lead to the same state.
    is_own = steps and (not photo.applied or steps.texts[: steps.index][-1:] == (_step(),))
    is_half = kept is not None and photo.is_begun and is_as_written and not is_own
    if kept is not None and is_half:  # killed before its undo steps were written
        project = from_node(json_reader.parse(photo.before, len(photo.before)))
        steps = history.find(keeping.edits, kept, project)
    elif photo.is_begun and is_as_written is (photo.applied is photo.wanted):
        acts.note(photo, now)
        return photo, outcome
    state, size_px = state_of(project), (project.original.width, project.original.height)
    steps = steps or UndoSteps((state,), (), 0)
    is_newer = photo.wrote and not (is_as_written or photo.is_begun)
    is_before = is_half and photo.applied and not photo.wanted
    if is_newer or not (photo.wanted or is_before or steps.index):
        acts.drop(photo)
        return photo, "newer"
    after = settings.of_project(project)
    recipes = (after.automatic.recipe, after.manual and after.manual.recipe)
    if is_before:
        after = project
    elif not photo.wanted:
        steps = replace(steps, index=steps.index - 1)
        after = project_of(steps.states[steps.index], project.original)
    elif recipes == (project.automatic.recipe, project.manual and project.manual.recipe):
        acts.drop(photo)
        if kept is not None:
            return photo, outcome
    else:
        states = (*steps.states[: steps.index + 1], state_of(after))
        texts = (*steps.texts[: steps.index], _step())
        steps = UndoSteps(states, texts, steps.index + 1)
    after = replace(after, original=replace(after.original, path=printable(path.name)))
    wrote = hashlib.sha256(to_bytes(after)).hexdigest()
    acts.note(photo, wrote, to_bytes(project))
    keeping.edits.keep(after, path, history.packed(steps, size_px), beside=keeping.beside)
    acts.note(photo, wrote)
    return photo, outcome
