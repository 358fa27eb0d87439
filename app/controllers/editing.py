"""Gestures on the points and faces: many previews, one undo step each."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QObject, Signal

from kogao_core.face import Face
from kogao_core.geometry import Array
from kogao_core.limits import OutOfBounds, check_faces

from .. import points
from ..document import Document, State
from ..i18n import tr
from ..points import Handle
from ..scene import Scene


class Editing(QObject):
    """Turns what the views emit into states of the document.

    Signals
    -------
    aborted
        The gesture in hand is over; views let go of it.
    escaped
        There was nothing to abort and no point to let go.
    named(str)
        What the point under the cursor is called; empty for none.
    restyled
        Something is marked otherwise: the overlays need drawing.
    took(int)
        A point of this face is in hand.
    center_taken(int, int)
        A centre candidate of a face was clicked: face and number.
    """

    aborted = Signal()
    escaped = Signal()
    named = Signal(str)
    restyled = Signal()
    took = Signal(int)
    center_taken = Signal(int, int)

    def __init__(self, document: Document, scene: Scene, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document, self._scene = document, scene
        self._text = ""
        self._held: Handle | None = None
        self._before = State()
        self._offset: Array = np.zeros(2)
        document.changed.connect(self._follow)
        document.opened.connect(self._forget)

    # -- gestures --------------------------------------------------------------------------------

    def preview(self, state: State, text: str) -> None:
        """Show a state while a gesture lasts; another text is another gesture."""
        if self._document.in_gesture and text != self._text:
            self._document.commit(self._text)
        self._text = text
        self._document.preview(state)

    def step(self, state: State, text: str) -> None:
        """Make a state the next undo step."""
        self.preview(state, text)
        self.commit()

    def commit(self) -> None:
        """End the gesture in hand as one undo step."""
        self._document.commit(self._text)

    def abort(self) -> None:
        """End the gesture in hand as if it hadn't been; without one, let point, then face go."""
        self._held = None
        self.aborted.emit()
        if self._document.in_gesture:
            self._document.abort()
        elif self._scene.selected is not None:
            self._select(None)
        else:
            self.escaped.emit()

    def undo(self) -> None:
        """Take the last gesture back; one in hand is only aborted."""
        if self._document.in_gesture:
            self.abort()
        else:
            self._document.undo.undo()

    def redo(self) -> None:
        """Do the gesture again that was taken back."""
        if not self._document.in_gesture:
            self._document.undo.redo()

    # -- points ----------------------------------------------------------------------------------

    def grab(self, handle: Handle, x: float, y: float) -> None:
        """Take hold of a handle at (x, y), px of the photo."""
        self.commit()
        if handle.kind == "mark":
            return
        self._held, self._before = handle, self._document.state
        self._offset = points.position(self._before, handle) - np.array([x, y])
        self._select(handle if handle.kind not in ("corner", "body") else None)
        self.took.emit(handle.face)

    def drag(self, x: float, y: float) -> None:
        """Move the handle in hand; it stays under the cursor where it was taken."""
        if self._held is not None and self._held.movable:
            start = points.position(self._before, self._held)
            to = self._offset + np.array([x, y])
            self._take(self._held, points.moved(self._before, self._held, start, to))

    def release(self) -> None:
        """Let go: a moved point is one undo step, a centre is chosen."""
        held, self._held = self._held, None
        self.commit()
        if held is not None and held.kind == "centre":
            self.center_taken.emit(held.face, held.index + 1)

    def nudge(self, dx: int, dy: int) -> None:
        """Move the selected point by whole px of the photo."""
        handle, state = self._scene.selected, self._document.state
        if handle is not None and handle.movable:
            at = points.position(state, handle)
            self._take(handle, points.moved(state, handle, at, at + np.array([dx, dy])))

    def _take(self, handle: Handle, moved: State) -> None:
        """Show a handle moved; one drawn far out of the photo stays where it was."""
        try:
            check_faces([moved.faces[handle.face]], self._document.image)
        except OutOfBounds:
            return
        self.preview(moved, self._name_of(handle))

    def select_next(self, step: int) -> None:
        """Select the point that comes `step` places after the selected one, going round."""
        movable = [
            handle
            for handle, _ in points.handles(self._document.state, points.MOVABLE)
            if self._scene.face in (None, handle.face)
        ]
        if not movable:
            return
        self.commit()
        here = self._scene.selected
        place = movable.index(here) + step if here in movable else min(0, step)
        handle = movable[place % len(movable)]
        self._select(handle)
        self.named.emit(self._name_of(handle))

    def make_automatic(self) -> None:
        """Put the selected target back on its line to the centre."""
        handle, state = self._scene.selected, self._document.state
        if handle is not None and handle.kind == "target":
            face = state.faces[handle.face].with_target(handle.index, None)
            self.step(state.with_face(handle.face, face), tr("Automatic target"))

    def let_selection_go(self) -> None:
        """Select nothing: what the points are numbered by has changed."""
        self._scene.hovered = None
        self._select(None)

    def hover(self, handle: Handle | None, x: float, y: float) -> None:
        """Name the point under the cursor, and note where that is; the canvas says -1 for away."""
        self._scene.cursor = None if (x, y) == (-1.0, -1.0) else np.array([x, y])
        if self._scene.brush.paints or self._scene.loupe or self._scene.marking:
            self.restyled.emit()
        if handle is not None and handle.kind == "mark":
            handle = None
        if handle != self._scene.hovered:
            self._scene.hovered = handle
            self.named.emit("" if handle is None else self._name_of(handle))
            self.restyled.emit()

    # -- faces -----------------------------------------------------------------------------------

    def switch_face(self, index: int, on: bool) -> None:
        """Make a face smaller, or leave it as it is."""
        state = self._document.state
        off = state.off - {index} if on else state.off | {index}
        self.step(dataclasses.replace(state, off=off), tr("Switch a face"))

    def place(self, make: Callable[[], Face]) -> None:
        """Add a face and let it be dragged into place."""
        state = self._document.state
        self.step(dataclasses.replace(state, faces=(*state.faces, make())), tr("Place a face"))
        self._scene.placing = len(state.faces)
        self.restyled.emit()

    @property
    def placing(self) -> bool:
        """True while a face is dragged into place."""
        return self._scene.placing is not None

    def end_placing(self) -> None:
        """Take the frame away: the face is in place."""
        self._scene.placing = None
        self.restyled.emit()

    def replace_faces(self, faces: list[Face]) -> None:
        """Take newly found faces, as an undo step."""
        self.step(self._document.state.with_found(faces), tr("Find faces"))

    def _name_of(self, handle: Handle) -> str:
        return points.name(handle, len(self._document.state.faces[handle.face].outline))

    def _select(self, handle: Handle | None) -> None:
        self._scene.selected = handle
        self.restyled.emit()

    def _follow(self) -> None:
        self._scene.state = state = self._document.state
        if self._scene.placing is not None and self._scene.placing >= len(state.faces):
            self._scene.placing = None
        for kept in ("selected", "hovered"):
            handle = getattr(self._scene, kept)
            if handle is not None and not points.exists(state, handle):
                setattr(self._scene, kept, None)

    def _forget(self) -> None:
        self._scene.image = self._document.image
        self._scene.frame = None
        self._scene.placing = self._scene.selected = self._scene.hovered = self._held = None
