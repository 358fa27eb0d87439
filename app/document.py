"""What is being edited: the photo, its faces and the recipe, with undo."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from PySide6.QtCore import QObject, QSignalBlocker, Signal
from PySide6.QtGui import QUndoCommand, QUndoStack

from kogao_core.base.geometry import Box, Line
from kogao_core.faces.doubt import doubtful
from kogao_core.faces.face import Face
from kogao_core.faces.targets import Pairs, aim
from kogao_core.photo import Photo
from kogao_core.photo.optics import UNKNOWN, Optics, optics_of
from kogao_core.projects.project import Mode, Sheet
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.recipe import FACE_FIELDS, Recipe
from kogao_core.warp.brush import UNTOUCHED, Brushwork
from kogao_core.warp.lens import Heads
from kogao_core.warp.protection import NOTHING, Protection

if TYPE_CHECKING:
    from .render.pictures import PicturePyramid

# A landmark marked by hand and where it goes, px of the photo.
Mark = tuple[tuple[float, float], tuple[float, float]]
# Eye and mouth corners are marked first: they give the face its axis and its centre.
CORNERS: Final = 6
DEFAULT: Final = Recipe()
_NOWHERE: Final = Box(0, 0, 0, 0)


@dataclass(frozen=True, eq=False)
class State(Sheet):
    """Everything that undo brings back."""

    protection: Protection = NOTHING  # places that must not move, px of the photo
    # Straight lines of the background that aren't held, px of the photo.
    loose: tuple[Line, ...] = ()
    brushwork: Brushwork = UNTOUCHED  # strokes of push and restore, px of the photo
    optics: Optics = UNKNOWN  # what the photo tells of its lens
    image: Box = _NOWHERE  # the photo's rectangle
    mode: Mode = "automatic"  # whose faces these are: the machine's, or those marked by hand
    # Faces and recipe of the other mode; None until it is first switched to.
    kept: Sheet | None = None
    draft: tuple[Mark, ...] = ()  # points of a face being marked that aren't a face yet

    @cached_property
    def pairs(self) -> tuple[Pairs, ...]:
        """Landmarks, targets and centre of every face, off ones too."""
        if not (seen := self._lensed):
            return tuple(aim(face, self.recipe) for face in self.faces)
        return tuple(map(aim, self.faces, repeat(self.recipe), seen))

    @property
    def seen(self) -> Sequence[Face]:
        """The faces as the lens' correction alone shows them; as they are without one."""
        return self._lensed or self.faces

    @cached_property
    def _lensed(self) -> list[Face]:
        return Heads.of(self.faces, self.optics.settled(self.recipe), self.image).faces

    @property
    def focal_mm(self) -> float | None:
        """The lens' 35-mm equivalent: what is chosen, or else what the photo tells."""
        lens = self.recipe.lens
        return self.optics.focal_mm if isinstance(lens, str) else lens

    @property
    def done(self) -> Applied:
        """What the mode at work does to the photo."""
        return self.done_by(self.mode)

    def done_by(self, mode: Mode) -> Applied:
        """Return what a mode does to the photo."""
        sheet = self.sheet(mode)
        recipe = self.optics.settled(sheet.recipe)
        return Applied(
            *(sheet.active, recipe, self.protection),
            loose=self.loose,
            others=sheet.inactive,
            brushwork=self.brushwork,
        )

    @property
    def work(self) -> dict[Mode, object]:
        """What would be lost with the state, to compare: the mode at work is no part of it."""
        found, marked = self.sheet("automatic"), self.sheet("manual")
        shared = (self.protection.strokes, self.loose, self.brushwork.strokes)
        by_hand = (marked.faces, marked.off, marked.recipe, self.draft, *shared)
        return {
            "automatic": (found.faces, found.off, found.recipe, *shared),
            # Settings of no face are nothing to lose: manual mode was only looked at.
            "manual": by_hand if marked.faces or self.draft else None,
        }

    def recipe_of(self, face: int | None) -> Recipe:
        """Return what a face goes by; the photo's own recipe for None."""
        return self.recipe if face is None else self.recipe.of_face(self.faces[face].recipe)

    def with_choices(self, face: int | None, **changes: object) -> State:
        """Return the state with fields of a recipe replaced.

        What a face can't choose for itself (all but `FACE_FIELDS`) is changed for the photo.
        """
        if face is None or not changes.keys() <= set(FACE_FIELDS):
            recipe = dataclasses.replace(self.recipe, **changes)  # type: ignore[arg-type]
            return dataclasses.replace(self, recipe=recipe)
        own = dataclasses.replace(self.recipe_of(face), **changes)  # type: ignore[arg-type]
        return self.with_face(face, dataclasses.replace(self.faces[face], recipe=own))

    def sheet(self, mode: Mode) -> Sheet:
        """Return what a mode holds; one never switched to starts with the other's recipe."""
        if mode == self.mode:
            return Sheet(self.faces, self.off, self.recipe)
        return self.kept or Sheet(recipe=self.recipe)

    def in_mode(self, mode: Mode) -> State:
        """Return the state in a mode; the other mode's faces and recipe are kept for later."""
        if mode == self.mode:
            return self
        here, there = self.sheet(self.mode), self.sheet(mode)
        return dataclasses.replace(
            self, mode=mode, kept=here, faces=there.faces, off=there.off, recipe=there.recipe
        )

    @property
    def other_mode(self) -> Mode:
        """The mode that isn't at work."""
        return "automatic" if self.mode == "manual" else "manual"

    def in_other_mode(self) -> State:
        """Return the state in the mode that isn't at work."""
        return self.in_mode(self.other_mode)

    def with_found(self, faces: Sequence[Face], image: Box) -> State:
        """Return the state with what the detector found in a photo; marks made by hand stay.

        Doubtful faces of a group start switched off.
        """
        return self._with_automatic(tuple(faces), doubtful(faces, image))

    def with_more(self, faces: Sequence[Face], image: Box) -> State:
        """Return the state with faces found later behind the others; none where one is already.

        Doubtful ones start switched off, too.
        """
        sheet = self.sheet("automatic")
        new = [face for face in faces if not any(_same_place(face, one) for one in sheet.faces)]
        there, every = len(sheet.faces), (*sheet.faces, *new)
        off = sheet.off | {index for index in doubtful(every, image) if index >= there}
        return self._with_automatic(every, off)

    def _with_automatic(self, faces: tuple[Face, ...], off: frozenset[int]) -> State:
        if self.mode == "automatic":
            return dataclasses.replace(self, faces=faces, off=off)
        kept = dataclasses.replace(self.sheet("automatic"), faces=faces, off=off)
        return dataclasses.replace(self, kept=kept)

    def without_face(self, index: int) -> State:
        """Return the state with one face less."""
        faces = (*self.faces[:index], *self.faces[index + 1 :])
        off = frozenset(i - (i > index) for i in self.off if i != index)
        return dataclasses.replace(self, faces=faces, off=off)

    def with_face(self, index: int, face: Face) -> State:
        """Return the state with one face replaced."""
        faces = (*self.faces[:index], face, *self.faces[index + 1 :])
        return dataclasses.replace(self, faces=faces)


def _same_place(one: Face, other: Face) -> bool:
    apart = float(np.linalg.norm(one.eye_center - other.eye_center))
    return apart < min(one.interocular_px, other.interocular_px)


@dataclass(frozen=True, eq=False)
class UndoSteps:
    """The state below the first undo step and after each, their words, and which is at hand."""

    states: tuple[State, ...]
    texts: tuple[str, ...]
    index: int


@dataclass(frozen=True, eq=False)
class Saving:
    """A save on its way: what its file will hold, and what lay below the first undo step."""

    base: State
    work: dict[Mode, object]


class Document(QObject):
    """One open photo; a gesture previews many states and commits one."""

    opened = Signal()
    recoloured = Signal()
    changed = Signal()
    marked = Signal()
    aborted = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.photo: Photo | None = None
        self.pyramid: PicturePyramid | None = None
        self._optics = UNKNOWN
        self.undo = QUndoStack(self)
        # What a photo begins with.
        self.first_recipe = DEFAULT
        self._state = self._committed = self._base = State()
        # What counted as saved when the photo was opened.
        self._opened_as = self._base
        self._saved = self._begun = self._base.work
        self._savings: list[Saving] = []
        self._text = self._change = ""
        self._watched: list[Callable[[], object]] = []

    def watch(self, value: Callable[[], object], show: Callable[[], object]) -> None:
        """Call `show` now, and after each change that makes `value` another.

        Those who listen to `changed` go first: they mend what is chosen, if its face is gone.
        """
        last = [value()]

        def follow() -> None:
            now = value()
            if now != last[0]:
                last[0] = now
                show()

        self._watched.append(follow)
        show()

    def _tell(self) -> None:
        self.changed.emit()
        if not self.signalsBlocked():
            for follow in self._watched:
                follow()

    @property
    def state(self) -> State:
        """What is shown now, a gesture's preview included."""
        return self._state

    @property
    def committed(self) -> State:
        """What the last whole gesture left."""
        return self._committed

    @property
    def base(self) -> State:
        """What lies below the first undo step: what was found, or what the project held."""
        return self._base

    @property
    def in_gesture(self) -> bool:
        """True between a first preview and its commit or abort."""
        return self._state is not self._committed

    @property
    def saved(self) -> bool:
        """True while the committed state holds only what was opened or last saved.

        A save on its way may write over the file that holds it: it must come to the same.
        """
        work = self._committed.work
        coming = (saving.work for saving in self._savings if saving.base is self._base)
        return work == self._saved and all(it.items() <= work.items() for it in coming)

    @property
    def dirty(self) -> bool:
        """True while something would be lost; a gesture in hand counts."""
        return self.in_gesture or not self.saved

    @property
    def image(self) -> Box:
        """The photo's rectangle; empty while there is none."""
        return _NOWHERE if self.pyramid is None else Box.of(self.pyramid.levels[0])

    @property
    def path(self) -> Path | None:
        """Where the photo came from."""
        return None if self.photo is None else Path(self.photo.path)

    def open(self, photo: Photo, pyramid: PicturePyramid, recipe: Recipe | None = None) -> None:
        """Begin with another photo and a recipe, without one that which photos begin with."""
        self.photo, self.pyramid, self._optics = photo, pyramid, optics_of(photo)
        self._begin(State(recipe=recipe or self.first_recipe))
        self.opened.emit()
        self._tell()

    def recolour(self, pyramid: PicturePyramid) -> None:
        """Take the levels of the open photo as another screen shows them."""
        self.pyramid = pyramid
        self.recoloured.emit()

    def start_with(self, faces: Sequence[Face]) -> None:
        """Take what the detector found, below the first undo step."""
        self.begin_with(self._committed.with_found(faces, self.image))

    def add_found(self, faces: Sequence[Face]) -> None:
        """Add faces that were found late, below the first undo step: every state gets them."""
        more = cache(lambda state: state.with_more(faces, self.image))
        for index in range(self.undo.count()):
            step = self.undo.command(index)
            assert isinstance(step, ReplaceState)
            step.before, step.after = more(step.before), more(step.after)
        self._opened_as = more(self._opened_as)
        if self._saved is self._begun:
            self._saved = self._begun = self._opened_as.work
        self._base, self._committed = more(self._base), more(self._committed)
        self._state = more(self._state)
        self._tell()

    def begin_with(self, state: State, steps: UndoSteps | None = None) -> None:
        """Take a state that counts as saved, and the undo steps that once led to it."""
        self._begin(state if steps is None else steps.states[0])
        if steps is not None:
            with QSignalBlocker(self), QSignalBlocker(self.undo):  # nothing is shown on the way
                for before, after, text in zip(
                    steps.states, steps.states[1:], steps.texts, strict=False
                ):
                    self.undo.push(ReplaceState(self, before, after, text))
                self.undo.setIndex(steps.index)
            self._state = self._committed = self._opened_as = steps.states[steps.index]
            self._saved = self._begun = self._committed.work
            self.undo.indexChanged.emit(steps.index)
        self._tell()

    @property
    def steps(self) -> UndoSteps:
        """What undo and redo lead to."""
        steps = [self.undo.command(index) for index in range(self.undo.count())]
        states = [step.after for step in steps if isinstance(step, ReplaceState)]
        return UndoSteps((self._base, *states), tuple(it.text() for it in steps), self.undo.index())

    def begin_saving(self, state: State, modes: Collection[Mode]) -> Saving:
        """Note that a file is being written that will hold these modes of a state."""
        work = state.work
        saving = Saving(self._base, {mode: work[mode] for mode in modes})
        self._savings.append(saving)
        self.marked.emit()
        return saving

    def end_saving(self, saving: Saving, *, written: bool) -> None:
        """Note that it is over; what it holds is saved, unless another base has been taken."""
        self._savings.remove(saving)
        if written and saving.base is self._base:
            self._saved = {**self._saved, **saving.work}
        self.marked.emit()

    def preview(self, state: State, text: str, change: str = "") -> None:
        """Show a state while a gesture lasts."""
        if text != self._text:
            self.commit()
        self._text, self._change, self._state = text, change, state
        self._tell()

    def commit(self) -> None:
        """End the gesture: what is shown becomes one undo step."""
        if self.in_gesture:
            text = f"{self._text} {self._change}".rstrip()
            self.undo.push(ReplaceState(self, self._committed, self._state, text))

    def step(self, state: State, text: str, change: str = "") -> None:
        """Make a state the next undo step, see `preview`."""
        self.preview(state, text, change)
        self.commit()

    def abort(self) -> None:
        """End the gesture as if it hadn't been."""
        self.aborted.emit()
        if self.in_gesture:
            self.restore(self._committed)

    def _begin(self, state: State) -> None:
        state = dataclasses.replace(state, optics=self._optics, image=self.image)
        self._state = self._committed = self._base = self._opened_as = state
        self._saved = self._begun = state.work
        self.undo.clear()

    def restore(self, state: State) -> None:
        """Make `state` the committed one; undo and redo come through here."""
        self._state = self._committed = state
        self._tell()


class ReplaceState(QUndoCommand):
    """Put one state in place of another."""

    def __init__(self, document: Document, before: State, after: State, text: str) -> None:
        super().__init__(text)
        self._document, self.before, self.after = document, before, after

    def redo(self) -> None:
        """Show the later state."""
        self._document.restore(self.after)

    def undo(self) -> None:
        """Show the earlier state."""
        self._document.restore(self.before)
