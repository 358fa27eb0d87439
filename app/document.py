"""What is being edited: the photo, its faces and the recipe, with undo."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoStack

from kogao_core.face import Face
from kogao_core.geometry import Box
from kogao_core.photo import Photo
from kogao_core.recipe import Recipe
from kogao_core.targets import Pairs, aim

from .commands import ReplaceState
from .pyramid import Pyramid

DEFAULT: Final = Recipe()


@dataclass(frozen=True, eq=False)
class State:
    """Everything that undo brings back.

    Parameters
    ----------
    faces : tuple of Face
        Px of the photo.
    off : frozenset of int
        Indices of the faces left as they are.
    recipe : Recipe
        The choices, for all faces.
    """

    faces: tuple[Face, ...] = ()
    off: frozenset[int] = frozenset()
    recipe: Recipe = DEFAULT

    @property
    def active(self) -> list[Face]:
        """The faces to make smaller."""
        return [face for index, face in enumerate(self.faces) if index not in self.off]

    @cached_property
    def pairs(self) -> tuple[Pairs, ...]:
        """Landmarks, targets and centre of every face, off ones too."""
        return tuple(aim(face, self.recipe) for face in self.faces)

    def with_recipe(self, **changes: object) -> State:
        """Return the state with fields of the recipe replaced."""
        return dataclasses.replace(self, recipe=dataclasses.replace(self.recipe, **changes))  # type: ignore[arg-type]

    def with_face(self, index: int, face: Face) -> State:
        """Return the state with one face replaced."""
        faces = (*self.faces[:index], face, *self.faces[index + 1 :])
        return dataclasses.replace(self, faces=faces)


class Document(QObject):
    """One open photo; a gesture previews many states and commits one.

    Signals
    -------
    opened
        Another photo is here.
    changed
        The state is another one.
    """

    opened = Signal()
    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.photo: Photo | None = None
        self.pyramid: Pyramid | None = None
        self.undo = QUndoStack(self)
        self._state = self._committed = State()

    @property
    def state(self) -> State:
        """What is shown now, a gesture's preview included."""
        return self._state

    @property
    def in_gesture(self) -> bool:
        """True between a first preview and its commit or abort."""
        return self._state is not self._committed

    @property
    def image(self) -> Box:
        """The photo's rectangle; empty while there is none."""
        return Box(0, 0, 0, 0) if self.pyramid is None else Box.of(self.pyramid.levels[0])

    @property
    def path(self) -> Path | None:
        """Where the photo came from."""
        return None if self.photo is None else Path(self.photo.path)

    def open(self, photo: Photo, pyramid: Pyramid) -> None:
        """Begin with another photo and the default recipe."""
        self.photo, self.pyramid = photo, pyramid
        self._state = self._committed = State()
        self.undo.clear()
        self.opened.emit()
        self.changed.emit()

    def start_with(self, faces: list[Face]) -> None:
        """Take what the detector found, below the first undo step."""
        self.undo.clear()
        self.restore(dataclasses.replace(self._committed, faces=tuple(faces), off=frozenset()))

    def preview(self, state: State) -> None:
        """Show a state while a gesture lasts."""
        self._state = state
        self.changed.emit()

    def commit(self, text: str) -> None:
        """End the gesture: what is shown becomes one undo step."""
        if self.in_gesture:
            self.undo.push(ReplaceState(self.restore, self._committed, self._state, text))

    def abort(self) -> None:
        """End the gesture as if it hadn't been."""
        if self.in_gesture:
            self.restore(self._committed)

    def restore(self, state: State) -> None:
        """Make `state` the committed one; undo and redo come through here."""
        self._state = self._committed = state
        self.changed.emit()
