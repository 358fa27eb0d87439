"""Sync settings of the open photo to the photos selected on the film strip, with a preview."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QTimer
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from kogao_core.base.geometry import Box
from kogao_core.base.wording import printable
from kogao_core.faces.face import Face
from kogao_core.photo import read
from kogao_core.projects import sidecar
from kogao_core.projects.edits import Edits, SavedEdits
from kogao_core.projects.project import Project, load
from kogao_core.recipe.recipe import SETTINGS, SHAPE, Recipe

from ..ahead import FaceSearch
from ..document import State, UndoSteps
from ..i18n import reason, tr, tr_count
from .faces import Faces
from .feature import Context, Feature
from .files import history
from .files.history import project_of, state_of
from .files.saver import Saver
from .projects import Keeping, Projects
from .strip import Strip
from .strip.facts import Preview, Sample

_GROUPS: Final = "sync/groups"


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

    Each photo gets one undo step. While photos are selected, each change of the open photo's
    settings is drawn into their thumbnails; photos with a warning get a ring.
    """

    def __init__(
        self, context: Context, strip: Strip, faces: Faces, projects: Projects, saver: Saver
    ) -> None:
        super().__init__(context)
        self._strip, self._faces, self._projects = strip, faces, projects
        self._waiting: list[Path] = []
        self._total = self._failed = self._edited = 0
        self._settings = Settings(Recipe(), frozenset())
        # On the thread that saves edits: a photo that was just left is saved before.
        self._syncing = self.lane(self._synced, self._not_synced, saver.edits_thread)
        self._samples: dict[Path, Sample | None] = {}
        self._undrawn: dict[Path, None] = {}
        self._selected: list[Path] = []
        self._last = Recipe()  # of the open photo, when a preview was last drawn
        self._drawing = self.lane(self._drawn, self._not_drawn)
        self.action = self.bind("give-settings", self.start)
        strip.film.addAction(self.action)
        self.menu = QMenu(tr("Settings to sync"), self.window)
        self._groups = {name: self._group(name, title) for name, (title, _) in groups().items()}
        strip.panel.offer_sync(self.action, self.menu)
        strip.film.itemSelectionChanged.connect(self._select)
        self.document.opened.connect(self._select)
        self.view.watch(self._preview, "frame")

    def _group(self, name: str, title: str) -> QAction:
        action = self.menu.addAction(title)
        action.setCheckable(True)
        off = str(self.settings.value(_GROUPS, "")).split(",")
        action.setChecked(name not in off)
        action.toggled.connect(self._choose_groups)
        return action

    def _choose_groups(self) -> None:
        off = [name for name, action in self._groups.items() if not action.isChecked()]
        self.settings.setValue(_GROUPS, ",".join(off))
        self._last = Recipe()
        self._preview()

    @property
    def _chosen(self) -> Settings:
        on = (names for name, (_, names) in groups().items() if self._groups[name].isChecked())
        return Settings(self.document.state.recipe, frozenset[str]().union(*on))

    @property
    def busy(self) -> bool:
        """True while photos are synced or drawn."""
        return super().busy or bool(self._waiting or self._undrawn)

    def stop(self) -> None:
        """Skip the remaining photos."""
        self._waiting, self._undrawn = [], {}
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
        if self._waiting or self._syncing.busy:
            self._waiting = []
            return
        self._waiting = list(self._selected)
        self._total, self._failed, self._edited = len(self._waiting), 0, 0
        self._settings = self._chosen
        if self._waiting:
            self._next()
        else:
            self.say(tr("Select other photos on the film strip first, with Shift or Ctrl."))

    def _next(self) -> None:
        if not self._waiting:
            self._end()
            return
        path, settings = self._waiting.pop(0), self._settings
        sample, first = self._samples.get(path), self.document.first_recipe
        keeping, search = self._projects.keeping(path), self._faces.search()
        done = self._total - len(self._waiting)
        self.working.emit(tr("Settings: {n} of {total}…", n=done, total=self._total))
        self._strip.panel.show_running(tr("{n} of {total}", n=done, total=self._total), self.start)
        faces = None if sample is None else sample.project.automatic.faces
        self._syncing.submit(partial(synced, path, settings, keeping, search, first, faces))

    def _synced(self, synced: tuple[Path, bool]) -> None:
        path, was_edited = synced
        self._edited += was_edited
        self._samples.pop(path, None)
        if path == self.document.path and self._projects.adopt(path):
            # The photo was opened before its file was written.
            self.document.step(self._settings.of_state(self.document.state), tr("Sync settings"))
        self._strip.look_again(path)
        self._next()

    def _not_synced(self, problem: Exception) -> None:
        self._failed += 1
        self.say(tr("The settings can't be applied: {problem}", problem=reason(problem)))
        self._next()

    def _end(self) -> None:
        self._strip.panel.show_running("")
        self.working.emit("")
        count = self._total - self._failed
        text = tr_count(count, "Settings applied to {n} photo", "Settings applied to {n} photos")
        had = tr("{n} had edits", n=self._edited)
        self.did.emit(tr("{text} ({had}); undo works in each", text=text, had=had))


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


def synced(
    path: Path,
    settings: Settings,
    keeping: Keeping,
    search: FaceSearch,
    first: Recipe,
    faces: Collection[Face] | None = None,
) -> tuple[Path, bool]:
    """Apply settings to a photo as one undo step; return whether the photo had edits.

    Raises UnreadablePhoto, BadFile, OSError.
    """
    project, kept = loaded(path, keeping.edits, search, first, faces)
    after = settings.of_project(project)
    state, size_px = state_of(project), (project.original.width, project.original.height)
    steps = kept and history.find(keeping.edits, kept, project)
    steps = steps or UndoSteps((state,), (), 0)
    recipes = (after.automatic.recipe, after.manual and after.manual.recipe)
    if recipes == (project.automatic.recipe, project.manual and project.manual.recipe):
        if kept is not None:
            return path, True
    else:
        states = (*steps.states[: steps.index + 1], state_of(after))
        texts = (*steps.texts[: steps.index], tr("Sync settings"))
        steps = UndoSteps(states, texts, steps.index + 1)
    after = replace(after, original=replace(after.original, path=printable(path.name)))
    keeping.edits.keep(after, path, history.packed(steps, size_px), beside=keeping.beside)
    return path, kept is not None
