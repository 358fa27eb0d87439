"""What is done to the photos that are chosen on the film strip, one after the other."""

from __future__ import annotations

import dataclasses
from contextlib import suppress
from pathlib import Path

from kogao_core.base.geometry import Box
from kogao_core.photo import read
from kogao_core.projects import sidecar
from kogao_core.projects.project import Project, load, save
from kogao_core.recipe.recipe import Recipe

from ..ahead import FaceSearch
from ..document import State
from ..i18n import reason, tr, tr_count
from .faces import Faces
from .feature import Context, Feature
from .files.opening import to_keep_beside
from .projects import Projects
from .strip import Strip


class SettingsForMany(Feature):
    """Gives the settings of the open photo to those that are chosen on the strip."""

    def __init__(self, context: Context, strip: Strip, faces: Faces, projects: Projects) -> None:
        super().__init__(context)
        self._strip, self._faces, self._projects = strip, faces, projects
        self._left: list[Path] = []
        self._total = self._failed = 0
        self._recipe = Recipe()
        self._giving = self.lane(self._given, self._not_given)
        self.giving = self.add_action(
            "give-settings",
            tr("Settings to the c&hosen photos"),
            "Ctrl+Alt+V",
            tr("What is set for the open photo, for those chosen on the film strip, too"),
            self.give,
            needs_photo=True,
        )
        strip.film.addAction(self.giving)

    def stop(self) -> None:
        """Go on to no other photo."""
        self._left = []
        super().stop()

    def give(self) -> None:
        """Begin, or stop what was begun."""
        if self._left or self._giving.busy:
            self._left = []
            return
        own = self.document.path
        self._left = [path for path in self._strip.chosen() if path != own]
        self._total, self._failed = len(self._left), 0
        self._recipe = self.document.state.recipe
        if self._left:
            self._next()
        else:
            self.say(tr("Choose other photos on the film strip first, with Shift or Ctrl."))

    def _next(self) -> None:
        if not self._left:
            self._end()
            return
        path, recipe = self._left.pop(0), self._recipe
        places, search = self._projects.places(path), self._faces.search()
        done = self._total - len(self._left)
        self.working.emit(tr("Settings: {n} of {total}…", n=done, total=self._total))
        self._strip.panel.show_running(tr("{n} of {total}", n=done, total=self._total), self.give)
        self._giving.submit(lambda: given(path, recipe, places, search))

    def _given(self, path: Path) -> None:
        self._strip.look_again(path)
        self._next()

    def _not_given(self, problem: Exception) -> None:
        self._failed += 1
        self.say(tr("A photo can't be given the settings: {problem}", problem=reason(problem)))
        self._next()

    def _end(self) -> None:
        self._strip.panel.show_running("")
        self.working.emit("")
        count = self._total - self._failed
        text = tr_count(count, "{n} photo has these settings", "{n} photos have these settings")
        self.did.emit(text)


def given(path: Path, recipe: Recipe, places: list[Path], search: FaceSearch) -> Path:
    """Give a photo settings: in its edits, or in new ones with the faces that are found.

    Raises UnreadablePhoto, BadFile, OSError.
    """
    file = sidecar.kept(path, places[-1].parent)
    if file is not None:
        project = load(file)
        manual = project.manual
        save(
            dataclasses.replace(
                project,
                automatic=dataclasses.replace(project.automatic, recipe=recipe),
                manual=manual and dataclasses.replace(manual, recipe=recipe),
            ),
            file,
        )
        return path
    photo = read(path)
    state = State(recipe=recipe).with_found(search.run(photo), Box.of(photo.pixels))
    _save(to_keep_beside(state, photo), places)
    return path


def _save(project: Project, places: list[Path]) -> None:
    """Save to the first place that can be written; the last one is the user's own."""
    for place in places[:-1]:
        with suppress(OSError):
            save(project, place)
            return
    places[-1].parent.mkdir(parents=True, exist_ok=True)
    save(project, places[-1])
