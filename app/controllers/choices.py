"""The recipe of the photo and of single faces: one field at a time, or whole from the clipboard."""

from __future__ import annotations

import dataclasses
import json

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QGuiApplication

from kogao_core.recipe import Recipe
from kogao_core.settings import SETTINGS

from ..document import Document
from ..i18n import tr
from ..scene import Scene
from ..views.bar import Message
from .editing import Editing

_LONGEST_TEXT = 10_000


class Choices(QObject):
    """Edits the recipe of the chosen face, or the photo's when none is chosen.

    Signals
    -------
    chosen
        Another face's settings are edited now, or the photo's.
    said(Message)
        What went wrong.
    """

    chosen = Signal()
    said = Signal(object)

    def __init__(
        self, document: Document, scene: Scene, editing: Editing, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._document, self._scene, self._editing = document, scene, editing
        self._mode = document.state.mode
        document.changed.connect(self._follow)
        editing.took.connect(self._take)
        editing.center_taken.connect(self._take_center)
        editing.escaped.connect(lambda: self.choose(None))

    def choose(self, face: int | None) -> None:
        """Edit the settings of a face from now on; None for the photo's."""
        if face != self._scene.face:
            self._editing.commit()
            self._scene.face = face
            selected = self._scene.selected
            if face is not None and selected is not None and selected.face != face:
                self._editing.let_selection_go()
            self.chosen.emit()

    def set_field(self, field: str, value: object) -> None:
        """Preview another value of a field of the recipe; the same one is no gesture."""
        now = getattr(self._document.state.recipe_of(self._scene.face), field)
        if value == now and not self._document.in_gesture:
            return
        state = self._document.state.with_choices(self._scene.face, **{field: value})
        self._editing.preview(state, gesture_name(field))

    def follow_photo(self) -> None:
        """Let the chosen face, or every one, go by the photo's recipe again."""
        state, chosen = self._document.state, self._scene.face
        own = {i for i, face in enumerate(state.faces) if face.recipe and chosen in (None, i)}
        for index in own:
            state = state.with_face(index, dataclasses.replace(state.faces[index], recipe=None))
        if own:
            self._editing.step(state, tr("Use the photo's settings"))

    def use(self, recipe: Recipe, text: str) -> None:
        """Take a whole recipe; a chosen face takes its own part of it."""
        state, chosen = self._document.state, self._scene.face
        if chosen is None:
            state = dataclasses.replace(state, recipe=recipe)
        else:
            own = dataclasses.replace(state.faces[chosen], recipe=recipe)
            state = state.with_face(chosen, own)
        self._editing.step(state, text)

    def copy(self) -> None:
        """Put the settings on the clipboard, as text that another Kogao or an editor can read."""
        recipe = self._document.state.recipe_of(self._scene.face)
        QGuiApplication.clipboard().setText(json.dumps(recipe.to_dict(), indent=1))

    def paste(self) -> None:
        """Take the settings that lie on the clipboard."""
        text = QGuiApplication.clipboard().text()
        try:
            recipe = Recipe.from_dict(json.loads(text[:_LONGEST_TEXT]))
        # Whatever was copied last may lie there, brackets a thousand deep included.
        except (ValueError, TypeError, RecursionError):
            self.said.emit(Message(tr("The clipboard holds no settings; copy some first.")))
            return
        self.use(recipe, tr("Paste settings"))

    def _take(self, face: int) -> None:
        # Someone who edits face by face goes on with the face in hand.
        if self._scene.face is not None:
            self.choose(face)

    def _take_center(self, face: int, number: int) -> None:
        own = self._document.state.faces[face].recipe is not None or self._scene.face == face
        state = self._document.state.with_choices(face if own else None, center=number)
        self._editing.step(state, gesture_name("center"))

    def _follow(self) -> None:
        chosen, state = self._scene.face, self._document.state
        # The other mode's faces are others, whatever their numbers.
        gone = state.mode != self._mode or (chosen is not None and chosen >= len(state.faces))
        self._mode = state.mode
        if gone:
            self._scene.face = None
            self.chosen.emit()


def gesture_name(field: str) -> str:
    """Return what undo calls a change of a field of the recipe."""
    return tr(SETTINGS[field].title)
