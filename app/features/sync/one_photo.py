"""Settings applied to one photo as an act demands, by a worker: one undo step, or its undo."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, TypeVar

from kogao_core.base import json_reader
from kogao_core.base.geometry import Box
from kogao_core.base.language import Text
from kogao_core.base.wording import printable
from kogao_core.faces.doubt import doubtful
from kogao_core.faces.face import Face
from kogao_core.faces.names import NobodyNamed, names_of
from kogao_core.photo import Photo, read
from kogao_core.photo.picture import sha256_of
from kogao_core.projects import sidecar
from kogao_core.projects.acts import ActPhoto, Acts
from kogao_core.projects.edits import Edits, SavedEdits
from kogao_core.projects.project import Project, Sheet, from_node, load, to_bytes
from kogao_core.recipe.recipe import VERSION, Recipe

from ...ahead import FaceSearch
from ...document import State, UndoSteps
from ...i18n import tr
from ..files import history
from ..files.history import project_of, state_of
from ..projects import Keeping

_PERSON: Final = "person"  # beside the fields of a recipe in an act
_S = TypeVar("_S", bound=Sheet)
_Left = Literal["", "done", "half", "newer"]
Outcome = Literal["new", "edited", "newer", "doubtful"]
"""A photo without edits, with edits, with newer edits, and without a sure face of the person."""


@dataclass(frozen=True, slots=True)
class Settings:
    """A recipe and the fields of it that are copied to other photos, or to one person's face."""

    recipe: Recipe
    names: frozenset[str]
    person: str = ""  # name of the person as in the photos' metadata; "" for all faces

    @staticmethod
    def of(values: Mapping[str, Any]) -> Settings:
        """Return the settings that an act stores. Raises ValueError."""
        fields = dict(values)
        person = fields.pop(_PERSON, "")
        recipe = Recipe.from_dict({"version": VERSION, **fields})
        return Settings(recipe, frozenset(fields), person)

    @property
    def values(self) -> dict[str, Any]:
        """What an act stores."""
        return {_PERSON: self.person} | {it: getattr(self.recipe, it) for it in self.names}

    def onto(self, recipe: Recipe) -> Recipe:
        """Return another photo's recipe with the copied fields."""
        return replace(recipe, **{name: getattr(self.recipe, name) for name in self.names})

    def of_project(self, project: Project) -> Project:
        """Return a project whose two modes have the copied fields."""
        return project_of(self.of_state(state_of(project)), project.original)

    def of_state(self, state: State, photo: Photo | None = None, *, alone: bool = False) -> State:
        """Return a state whose two modes have the copied fields; the state itself without change.

        For a person, `photo` is needed; with `alone`, all other faces are switched off. Raises
        NobodyNamed.
        """
        here, kept = self._of_sheet(state, photo, alone), state.kept
        with suppress(NobodyNamed):  # the other mode may be without the person
            kept = kept and self._of_sheet(kept, photo, alone)
        return state if here is state and kept is state.kept else replace(here, kept=kept)

    def _of_sheet(self, sheet: _S, photo: Photo | None, alone: bool) -> _S:
        if photo is None or not self.person:
            recipe = self.onto(sheet.recipe)
            return sheet if recipe == sheet.recipe else replace(sheet, recipe=recipe)
        index = names_of(photo, sheet.faces).index(self.person)
        if isinstance(index, Text):
            raise NobodyNamed(index)
        faces, off = list(sheet.faces), frozenset(range(len(sheet.faces))) if alone else sheet.off
        off -= {index} - doubtful(faces, Box.of(photo.pixels))
        own = self.onto(sheet.recipe.of_face(faces[index].recipe))
        if (own, off) == (faces[index].recipe, sheet.off):
            return sheet
        faces[index] = replace(faces[index], recipe=own)
        return replace(sheet, faces=tuple(faces), off=off)


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


def step_text() -> str:
    """Return the text of the undo step in each photo."""
    return tr("Sync settings")


@dataclass(frozen=True, slots=True)
class _Found:
    """The edits of a photo before its turn in an act."""

    project: Project
    saved: SavedEdits | None
    steps: UndoSteps
    # "done": as wanted, except for the note; "half": saved without undo steps; "newer": by others.
    left: _Left


def _found(photo: ActPhoto, edits: Edits, project: Project, saved: SavedEdits | None) -> _Found:
    """Return what an act finds of its photo, also after the program was killed while it wrote."""
    is_as_written = saved is not None and sha256_of(saved.file) == photo.wrote
    steps = None if saved is None else history.find(edits, saved, project)
    left: _Left = ""
    if saved is not None and photo.is_begun and is_as_written and not _has_step(steps, photo):
        left, project = "half", from_node(json_reader.parse(photo.before, len(photo.before)))
        steps = history.find(edits, saved, project)
    elif photo.is_begun and is_as_written is (photo.applied is photo.wanted):
        left = "done"
    elif photo.wrote and not (is_as_written or photo.is_begun):
        left = "newer"
    return _Found(project, saved, steps or UndoSteps((state_of(project),), (), 0), left)


def _has_step(steps: UndoSteps | None, photo: ActPhoto) -> bool:
    """Return whether the last undo step is the act's, or the act is undone.

    A copy of the picture may have other steps that lead to the same state.
    """
    if steps is None:
        return False
    return not photo.applied or steps.texts[: steps.index][-1:] == (step_text(),)


def _turned(found: _Found, photo: ActPhoto, settings: Settings) -> UndoSteps | None:
    """Return the undo steps with the act applied or undone; None if there is nothing to undo."""
    steps = found.steps
    if not photo.wanted:
        if found.left == "half" and photo.applied:
            return steps  # the step was never written
        return replace(steps, index=steps.index - 1) if steps.index else None
    picture = read(photo.path) if settings.person else None
    now = steps.states[steps.index]
    # Undone edits of this kind are none.
    is_new = found.saved is None or (not steps.index and steps.texts[:1] == (step_text(),))
    after = settings.of_state(now, picture, alone=is_new)
    if after is now:
        return steps
    states, texts = steps.states[: steps.index + 1], steps.texts[: steps.index]
    return UndoSteps((*states, after), (*texts, step_text()), steps.index + 1)


def synced(
    photo: ActPhoto,
    acts: Acts,
    keeping: Keeping,
    search: FaceSearch,
    first: Recipe,
    faces: Collection[Face] | None = None,
) -> tuple[ActPhoto, Outcome]:
    """Apply the settings of an act to a photo as one undo step, or undo the step.

    A photo that was edited since, or that shows the person of the act with a doubt, leaves the act.
    Raises UnreadablePhoto, BadFile, OSError.
    """
    found = _found(photo, keeping.edits, *loaded(photo.path, keeping.edits, search, first, faces))
    outcome: Outcome = "new" if found.saved is None else "edited"
    if found.left == "done":
        acts.note(photo, sha256_of(found.saved.file) if found.saved else "")
        return photo, outcome
    try:
        steps = (
            None if found.left == "newer" else _turned(found, photo, Settings.of(photo.settings))
        )
    except NobodyNamed:
        acts.drop(photo)
        return photo, "doubtful"
    if steps is None:
        acts.drop(photo)
        return photo, "newer"
    if photo.wanted and steps is found.steps:  # it has these settings
        acts.drop(photo)
        if found.saved is not None:
            return photo, outcome
    _write(photo, acts, keeping, found.project, steps)
    return photo, outcome


def _write(
    photo: ActPhoto, acts: Acts, keeping: Keeping, before: Project, steps: UndoSteps
) -> None:
    """Save edits and undo steps; the act knows before and after what is written."""
    original = replace(before.original, path=printable(photo.path.name))
    after = project_of(steps.states[steps.index], original)
    wrote = hashlib.sha256(to_bytes(after)).hexdigest()
    acts.note(photo, wrote, to_bytes(before))
    packed = history.packed(steps, (original.width, original.height))
    keeping.edits.keep(after, photo.path, packed, beside=keeping.beside)
    acts.note(photo, wrote)
