"""The edited document: photo, faces, recipe and undo steps."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Final

import numpy as np
from PySide6.QtCore import QObject, QSignalBlocker, Signal
from PySide6.QtGui import QUndoCommand, QUndoStack

from kogao_core.additions.brush import UNTOUCHED, Brushwork
from kogao_core.base.geometry import Box, Line
from kogao_core.faces.doubt import doubtful
from kogao_core.faces.face import Face
from kogao_core.faces.targets import FacePairs
from kogao_core.field.protection import NOTHING, Protection
from kogao_core.photo import Photo
from kogao_core.photo.optics import UNKNOWN, Optics, optics_of
from kogao_core.projects.project import Mode, Sheet
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.recipe import FACE_FIELDS, Recipe
from kogao_core.steps import WarpDraft, lens, pivots, targets

from .pyramid import PicturePyramid
from .watching import Watched

# A landmark marked by hand and where it goes, px of the photo.
Mark = tuple[tuple[float, float], tuple[float, float]]
# Eye and mouth corners are marked first: they give the face its axis and its centre.
CORNERS: Final = 6
DEFAULT: Final = Recipe()
_NOWHERE: Final = Box(0, 0, 0, 0)


@dataclass(frozen=True, eq=False)
class State(Sheet):
    """All edits of a photo at one undo step."""

    protection: Protection = NOTHING  # protected areas, px of the photo
    # Straight background lines that may bend, px of the photo.
    loose: tuple[Line, ...] = ()
    brushwork: Brushwork = UNTOUCHED  # strokes of push and restore, px of the photo
    optics: Optics = UNKNOWN  # lens data from the photo's metadata
    image: Box = _NOWHERE  # the photo's rectangle
    mode: Mode = "automatic"  # automatic faces, or faces marked by hand
    # Faces and recipe of the other mode; None until it is first switched to.
    kept: Sheet | None = None
    draft: tuple[Mark, ...] = ()  # landmarks of an incomplete face

    @property
    def pairs(self) -> tuple[FacePairs, ...]:
        """Landmarks, targets and centre of every face, switched off faces included."""
        return self._aimed.requested_pairs

    @property
    def seen(self) -> Sequence[Face]:
        """The faces after lens correction; the faces themselves without lens correction."""
        return self._aimed.corrected_faces

    @cached_property
    def _aimed(self) -> WarpDraft:
        """The first steps of `render`, up to the targets."""
        draft = WarpDraft(
            faces=self.faces,
            recipe=self.optics.settled(self.recipe),
            photo=self.image,
            image=self.image,
            protection=self.protection,
        )
        return pivots(targets(lens(draft)))

    @property
    def focal_mm(self) -> float | None:
        """Focal length (35 mm equivalent): the recipe's value, or else the photo's."""
        focal_mm = self.recipe.lens
        return self.optics.focal_mm if isinstance(focal_mm, str) else focal_mm

    @property
    def done(self) -> Applied:
        """The edits of the current mode, as arguments of `render`."""
        return Applied(
            *(self.active, self.optics.settled(self.recipe), self.protection),
            loose=self.loose,
            others=self.inactive,
            brushwork=self.brushwork,
        )

    @cached_property
    def work(self) -> dict[Mode, object]:
        """The unsaved work of each mode, to compare states; the current mode isn't part of it."""
        found, marked = self.sheet("automatic"), self.sheet("manual")
        shared = (self.protection.strokes, self.loose, self.brushwork.strokes)
        by_hand = (marked.faces, marked.off, marked.recipe, self.draft, *shared)
        return {
            "automatic": (found.faces, found.off, found.recipe, *shared),
            # Without faces, the settings of manual mode needn't be saved.
            "manual": by_hand if marked.faces or self.draft else None,
        }

    def recipe_of(self, face: int | None) -> Recipe:
        """Return the recipe of a face; None, or a face of an earlier photo, is the photo."""
        own = None if face is None or face >= len(self.faces) else self.faces[face].recipe
        return self.recipe.of_face(own)

    def with_choices(self, face: int | None, **changes: object) -> State:
        """Return the state with fields of a recipe replaced.

        Fields that aren't in `FACE_FIELDS` are changed for the whole photo.
        """
        if face is None or not changes.keys() <= set(FACE_FIELDS):
            recipe = dataclasses.replace(self.recipe, **changes)  # type: ignore[arg-type]
            return dataclasses.replace(self, recipe=recipe)
        own = dataclasses.replace(self.recipe_of(face), **changes)  # type: ignore[arg-type]
        return self.with_face(face, dataclasses.replace(self.faces[face], recipe=own))

    def sheet(self, mode: Mode) -> Sheet:
        """Return the sheet of a mode; an unused mode starts with the recipe of the other mode."""
        if mode == self.mode:
            return Sheet(self.faces, self.off, self.recipe)
        return self.kept or Sheet(recipe=self.recipe)

    def in_mode(self, mode: Mode) -> State:
        """Return the state in a mode; store the faces and recipe of the other mode."""
        if mode == self.mode:
            return self
        here, there = self.sheet(self.mode), self.sheet(mode)
        return dataclasses.replace(
            self, mode=mode, kept=here, faces=there.faces, off=there.off, recipe=there.recipe
        )

    @property
    def other_mode(self) -> Mode:
        """The mode that isn't current."""
        return "automatic" if self.mode == "manual" else "manual"

    @cached_property
    def in_other_mode(self) -> State:
        """The state in the other mode; one object, since a state caches pairs."""
        return self.in_mode(self.other_mode)

    def with_found(self, faces: Sequence[Face], image: Box) -> State:
        """Return the state with detected faces; faces marked by hand are unchanged.

        Doubtful faces of a group start switched off.
        """
        return self._with_automatic(tuple(faces), doubtful(faces, image))

    def with_more(self, faces: Sequence[Face], image: Box) -> State:
        """Return the state with more detected faces appended; skip faces at a known position.

        Doubtful faces start switched off.
        """
        sheet = self.sheet("automatic")
        new = [face for face in faces if not any(is_same_place(face, one) for one in sheet.faces)]
        there, every = len(sheet.faces), (*sheet.faces, *new)
        off = sheet.off | {index for index in doubtful(every, image) if index >= there}
        return self._with_automatic(every, off)

    def _with_automatic(self, faces: tuple[Face, ...], off: frozenset[int]) -> State:
        if self.mode == "automatic":
            return dataclasses.replace(self, faces=faces, off=off)
        kept = dataclasses.replace(self.sheet("automatic"), faces=faces, off=off)
        return dataclasses.replace(self, kept=kept)

    def without_face(self, index: int) -> State:
        faces = (*self.faces[:index], *self.faces[index + 1 :])
        off = frozenset(i - (i > index) for i in self.off if i != index)
        return dataclasses.replace(self, faces=faces, off=off)

    def with_face(self, index: int, face: Face) -> State:
        faces = (*self.faces[:index], face, *self.faces[index + 1 :])
        return dataclasses.replace(self, faces=faces)


_FIELDS: Final = tuple(field.name for field in dataclasses.fields(State))


def is_same_place(one: Face, other: Face) -> bool:
    """Return whether two faces can only be one."""
    apart = float(np.linalg.norm(one.eye_center - other.eye_center))
    return apart < min(one.interocular_px, other.interocular_px)


@dataclass(frozen=True, eq=False)
class UndoSteps:
    """The states before the first and after each undo step, step texts and current index."""

    states: tuple[State, ...]
    texts: tuple[str, ...]
    index: int


@dataclass(frozen=True, eq=False)
class Saving:
    """A save in progress: the work in its file, and the state before the first undo step."""

    base: State
    work: dict[Mode, object]


class Document(QObject, Watched):
    """One open photo; a gesture previews many states and commits one.

    A part to watch is a field of `State`, ``"photo"`` or ``"in_gesture"``.
    """

    # (): another photo is open; its faces are not known yet.
    opened = Signal()
    # (): `pyramid` has the colours of another screen.
    recoloured = Signal()
    # (): a save has begun or ended.
    marked = Signal()
    # (): the gesture is cancelled; emitted before the committed state returns.
    aborted = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.photo: Photo | None = None
        self.pyramid: PicturePyramid | None = None
        self._optics = UNKNOWN
        self.undo = QUndoStack(self)
        # The recipe of a newly opened photo.
        self.first_recipe = DEFAULT
        # The current state, including the preview of a gesture.
        self.state = State()
        self.committed = self.state  # after the last complete gesture
        # Before the first undo step: the detected faces, or the saved project.
        self.base = self.state
        # The saved state when the photo was opened.
        self.opened_as = self.base
        self._saved = self.base.work
        self._savings: list[Saving] = []
        self._text = self._change = ""
        self._watchers = []
        self._told: dict[str, object] = {}

    def _tell(self) -> None:
        """Call the watchers of the parts that have changed since the last call."""
        if self.signalsBlocked():
            return
        parts = {name: getattr(self.state, name) for name in _FIELDS}
        parts |= {"photo": self.photo, "in_gesture": self.in_gesture}
        changed = {name for name, part in parts.items() if part is not self._told.get(name)}
        self._told = parts
        self._call_watchers(changed)

    @property
    def in_gesture(self) -> bool:
        """True between the first preview of a gesture and commit or abort."""
        return self.state is not self.committed

    @property
    def touched(self) -> bool:
        """True if there are undo steps or a gesture."""
        return bool(self.undo.count()) or self.in_gesture

    @property
    def saved(self) -> bool:
        """True if the committed state equals the opened or last saved state.

        A save in progress may overwrite this file, so the save must contain the same work.
        """
        work = self.committed.work
        for saving in self._savings:
            if saving.base is self.base and not saving.work.items() <= work.items():
                return False
        return work == self._saved

    @property
    def dirty(self) -> bool:
        """True if there is unsaved work, including an unfinished gesture."""
        return self.in_gesture or not self.saved

    @property
    def image(self) -> Box:
        """The photo's rectangle; empty while there is none."""
        return _NOWHERE if self.pyramid is None else Box.of(self.pyramid.levels[0])

    @property
    def path(self) -> Path | None:
        return None if self.photo is None else Path(self.photo.path)

    def open(self, photo: Photo, pyramid: PicturePyramid, recipe: Recipe | None = None) -> None:
        """Open another photo with a recipe; without one, with the recipe for new photos."""
        self.photo, self.pyramid, self._optics = photo, pyramid, optics_of(photo)
        self._begin(State(recipe=recipe or self.first_recipe))
        self.opened.emit()
        self._tell()

    def follow(self, photo: Photo) -> None:
        """Replace path and metadata of the open photo; the pixels are the same."""
        self.photo = photo
        self._tell()

    def recolour(self, pyramid: PicturePyramid) -> None:
        """Replace the pyramid of the open photo after a change of the screen's colours."""
        self.pyramid = pyramid
        self.recoloured.emit()

    def start_with(self, faces: Sequence[Face]) -> None:
        """Set the detected faces, before the first undo step."""
        self.begin_with(self.committed.with_found(faces, self.image))

    def add_found(self, faces: Sequence[Face]) -> None:
        """Add late detected faces to the base state and to every undo step."""
        more = cache(lambda state: state.with_more(faces, self.image))
        for index in range(self.undo.count()):
            step = self.undo.command(index)
            assert isinstance(step, ReplaceState)
            step.before, step.after = more(step.before), more(step.after)
        opened_work, self.opened_as = self.opened_as.work, more(self.opened_as)
        if self._saved is opened_work:
            self._saved = self.opened_as.work
        self.base, self.committed = more(self.base), more(self.committed)
        self.state = more(self.state)
        self._tell()

    def begin_with(self, state: State, steps: UndoSteps | None = None) -> None:
        """Set a state that counts as saved, and the undo steps that led to the state."""
        self._begin(state if steps is None else steps.states[0])
        if steps is not None:
            states = [self.base, *map(self._of_photo, steps.states[1:])]
            with QSignalBlocker(self), QSignalBlocker(self.undo):  # draw the last state only
                for before, after, text in zip(states, states[1:], steps.texts, strict=False):
                    self.undo.push(ReplaceState(self, before, after, text))
                self.undo.setIndex(steps.index)
            self.state = self.committed = self.opened_as = states[steps.index]
            self._saved = self.committed.work
            self.undo.indexChanged.emit(steps.index)
        self._tell()

    @property
    def steps(self) -> UndoSteps:
        """All states that undo and redo can reach."""
        steps = [self.undo.command(index) for index in range(self.undo.count())]
        states = [step.after for step in steps if isinstance(step, ReplaceState)]
        return UndoSteps((self.base, *states), tuple(it.text() for it in steps), self.undo.index())

    def begin_saving(self, state: State, modes: Collection[Mode]) -> Saving:
        """Register a save in progress that contains these modes of a state."""
        work = state.work
        saving = Saving(self.base, {mode: work[mode] for mode in modes})
        self._savings.append(saving)
        self.marked.emit()
        return saving

    def end_saving(self, saving: Saving, *, written: bool) -> None:
        """Finish a save; mark its work as saved unless another photo has been opened."""
        self._savings.remove(saving)
        if written and saving.base is self.base:
            self._saved = {**self._saved, **saving.work}
        self.marked.emit()

    def preview(self, state: State, text: str, change: str = "") -> None:
        """Show a state while a gesture lasts."""
        if text != self._text:
            self.commit()
        self._text, self._change, self.state = text, change, self._of_photo(state)
        self._tell()

    def commit(self) -> None:
        """End the gesture and make the preview one undo step."""
        if self.in_gesture:
            text = f"{self._text} {self._change}".rstrip()
            self.undo.push(ReplaceState(self, self.committed, self.state, text))

    def step(self, state: State, text: str, change: str = "") -> None:
        """Add a state as the next undo step, see `preview`."""
        self.preview(state, text, change)
        self.commit()

    def abort(self) -> None:
        """Cancel the gesture and restore the committed state."""
        self.aborted.emit()
        if self.in_gesture:
            self.restore(self.committed)

    def _of_photo(self, state: State) -> State:
        """Return the state with the open photo's lens data and size, which no file stores."""
        if state.optics is self._optics and state.image == self.image:
            return state
        return dataclasses.replace(state, optics=self._optics, image=self.image)

    def _begin(self, state: State) -> None:
        state = self._of_photo(state)
        self.state = self.committed = self.base = self.opened_as = state
        self._saved = state.work
        self.undo.clear()

    def close(self) -> None:
        """Delete the undo steps. The garbage collector would delete the steps of a stack twice."""
        with QSignalBlocker(self), QSignalBlocker(self.undo):
            self.undo.clear()

    def restore(self, state: State) -> None:
        """Set the committed state; undo and redo call this."""
        self.state = self.committed = state
        self._tell()


class ReplaceState(QUndoCommand):
    """Replace one state by another."""

    def __init__(self, document: Document, before: State, after: State, text: str) -> None:
        super().__init__(text)
        self._document, self.before, self.after = document, before, after

    def redo(self) -> None:
        self._document.restore(self.after)

    def undo(self) -> None:
        self._document.restore(self.before)
