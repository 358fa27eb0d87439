"""Dragging points on the canvas, and soft selection."""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np
from PySide6.QtCore import QSettings, Qt, Signal

from kogao_core.additions.limits import OutOfBounds, check_faces
from kogao_core.base.geometry import Array

from ..canvas import handles
from ..document import State
from ..i18n import tr
from ..view_state import Following, Handle
from .feature import Context, Feature

# In landmark spacings: from no neighbours to all neighbours.
_LEAST_REACH: Final = 1.5
_MOST_REACH: Final = 12.0
_PER_NOTCH: Final = 1.15
_GROUP: Final = "soft-selection"


class Points(Feature):
    """Drags, nudges and names points; each gesture is one undo step."""

    escaped = Signal()
    restyled = Signal()
    took = Signal(int)
    center_taken = Signal(int, int)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._dragged: Handle | None = None
        self._offset: Array = np.zeros(2)
        self._to: Array | None = None
        self.document.watch(self._follow, "faces", "off", "mode")
        self.document.opened.connect(self._forget)
        self.document.aborted.connect(self._drop)
        self.steps = (
            self.bind("next-point", lambda: self._walk(1)),
            self.bind("previous-point", lambda: self._walk(-1)),
        )
        self.bind("fetch-point", self.fetch_to_cursor)
        self.bind("abort", self.abort)
        canvas = self.window.canvas
        self.document.aborted.connect(canvas.let_go)
        self.restyled.connect(canvas.redraw)
        canvas.grabbed.connect(self.grab)
        canvas.dragged.connect(self.drag)
        canvas.released.connect(self.release)
        canvas.fetched.connect(self.fetch)
        canvas.taken.connect(self.take)
        canvas.nudged.connect(self.nudge)
        canvas.nudge_ended.connect(self.document.commit)
        canvas.hovered.connect(self.hover)

    def abort(self) -> None:
        """Cancel the current gesture, else close the message.

        Without either, deselect the point, then the face.
        """
        in_gesture = self.document.in_gesture
        self.document.abort()
        if in_gesture or self.window.bar.dismiss():
            return
        if self.view.selected is not None:
            self._select(None)
        else:
            self.escaped.emit()

    def grab(self, handle: Handle, x: float, y: float) -> None:
        """Start to drag a handle at (x, y), px of the photo."""
        self.document.commit()
        if handle.kind == "mark":
            return
        self._dragged = handle
        self._offset = handles.position(self.document.committed, handle) - np.array([x, y])
        self._to = None
        self._select(handle if handle.kind not in ("corner", "body") else None)
        self.took.emit(handle.face)

    def drag(self, x: float, y: float) -> None:
        """Move the dragged handle with the cursor, at a constant offset."""
        if self._dragged is not None and self._dragged.movable:
            self._to = self._offset + np.array([x, y])
            self._move_dragged()

    def fetch(self, handle: Handle | None, x: float, y: float) -> None:
        """Move a landmark to (x, y), px of the photo, and drag on; None: no landmark is near."""
        if handle is None:
            self.say(
                tr(
                    "No landmark of the selected face is near there. Select the face, show its "
                    "landmarks, and click with Ctrl closer to its outline."
                )
            )
            return
        self.grab(handle, x, y)
        self._offset = np.zeros(2)
        self.drag(x, y)

    def fetch_to_cursor(self) -> None:
        """Move the nearest landmark to the cursor, as Ctrl+click does."""
        at = self.view.cursor
        if self._dragged is None and at is not None:
            canvas = self.window.canvas
            self.fetch(canvas.outline_near(canvas.to_screen(at)), *at.tolist())
            self.release()

    def follow_anew(self) -> None:
        """Update the drag and the display after a change of the follow range."""
        if self._dragged is not None and self._to is not None:
            self._move_dragged()
        self.restyled.emit()

    def release(self) -> None:
        """End the drag as one undo step, or select a centre."""
        dragged, self._dragged = self._dragged, None
        self.document.commit()
        if dragged is not None and dragged.kind == "centre":
            self.center_taken.emit(dragged.face, dragged.index + 1)

    def nudge(self, dx: int, dy: int) -> None:
        """Move the selected point by whole px of the photo."""
        handle, state = self.view.selected, self.document.state
        if handle is not None and handle.movable:
            at = handles.position(state, handle)
            to = at + np.array([dx, dy])
            self._take(handle, handles.moved(state, handle, at, to, self.view.following))

    def _move_dragged(self) -> None:
        if self._dragged is not None and self._to is not None:
            # Late detections may have been added below the gesture.
            before, dragged = self.document.committed, self._dragged
            start = handles.position(before, dragged)
            state = handles.moved(before, dragged, start, self._to, self.view.following)
            self._take(dragged, state)

    def _take(self, handle: Handle, moved: State) -> None:
        """Preview a moved handle; ignore moves far out of the photo."""
        try:
            check_faces([moved.faces[handle.face]], self.document.image)
        except OutOfBounds:
            return
        away = handles.position(moved, handle) - handles.position(self.document.committed, handle)
        px = tr("{px:.1f} px", px=float(np.hypot(*away)))
        self.document.preview(moved, self.name_of(handle), px)

    def take(self, handle: Handle) -> None:
        """Select a point and focus the canvas for the arrow keys."""
        self.document.commit()
        self.window.canvas.setFocus(Qt.FocusReason.OtherFocusReason)
        self._take_up(handle)

    def _take_up(self, handle: Handle) -> None:
        self._select(handle)
        self.window.status.name_point(self.name_of(handle))

    def _walk(self, step: int) -> None:
        """Select the point `step` positions after the selected point, cyclically."""
        if self._unselected():
            self.say(
                tr("Select a face first: click it, or choose it in the list (Alt+S)."),
                wrong=False,
                applies=self._unselected,
            )
            return
        # Focus the canvas, so that the arrow keys move the point.
        self.window.canvas.setFocus(Qt.FocusReason.ShortcutFocusReason)
        movable = [
            handle
            for handle, _ in handles.handles(self.document.state, handles.MOVABLE)
            if handle.face == self.view.face_in_hand
        ]
        if movable:
            self.document.commit()
            here = self.view.selected
            place = movable.index(here) + step if here in movable else min(0, step)
            self._take_up(movable[place % len(movable)])

    def _unselected(self) -> bool:
        return bool(self.document.state.faces) and self.view.face_in_hand is None

    def make_automatic(self) -> None:
        """Reset the selected target to the automatic position."""
        handle, state = self.view.selected, self.document.state
        if handle is None or handle.kind != "target":
            return
        face = state.faces[handle.face]
        if face.targets is not None and np.isfinite(face.targets[handle.index]).all():
            face = face.with_target(handle.index, None)
            self.document.step(state.with_face(handle.face, face), tr("Automatic target"))

    def let_selection_go(self) -> None:
        """Clear the selection after the numbering of points changed."""
        self.view.hovered = None
        self._select(None)

    def hover(self, handle: Handle | None, x: float, y: float) -> None:
        """Name the point under the cursor and store the position; (-1, -1): outside the canvas."""
        self.view.cursor = None if (x, y) == (-1.0, -1.0) else np.array([x, y])
        if self.view.brush.paints or self.view.loupe or self.view.marking:
            self.restyled.emit()
        if handle is not None and handle.kind == "mark":
            handle = None
        if handle != self.view.hovered:
            self.view.hovered = handle
            self.window.status.name_point("" if handle is None else self.name_of(handle))
            self.restyled.emit()

    def name_of(self, handle: Handle) -> str:
        """Return the name of a point."""
        return handles.name(handle, len(self.document.state.faces[handle.face].outline))

    def _select(self, handle: Handle | None) -> None:
        self.view.selected = handle
        self.restyled.emit()

    def _follow(self) -> None:
        state = self.document.state
        if self.view.placing is not None and self.view.placing >= len(state.faces):
            self.view.placing = None
        for kept in ("selected", "hovered"):
            handle = getattr(self.view, kept)
            if handle is not None and not handles.exists(state, handle):
                setattr(self.view, kept, None)

    def _forget(self) -> None:
        self.view.frame = None
        self.view.placing = self.view.selected = self.view.hovered = None
        self._drop()

    def _drop(self) -> None:
        self._dragged = None


class SoftSelection(Feature):
    """Toggles soft and symmetric drags, and sets the follow range."""

    changed = Signal()

    def __init__(self, context: Context, points: Points) -> None:
        super().__init__(context)
        self.view.following = _remembered(self.settings)
        self.bind("soft", toggled=lambda on: self._take(soft=on), checked=self.view.following.soft)
        self.bind(
            "symmetric",
            toggled=lambda on: self._take(symmetric=on),
            checked=self.view.following.symmetric,
        )
        self.bind("reach-wider", lambda: self.widen(1.0))
        self.bind("reach-narrower", lambda: self.widen(-1.0))
        self.window.canvas.widened.connect(self.widen)
        self.changed.connect(points.follow_anew)
        self._show()

    def widen(self, notches: float) -> None:
        """Change the follow range by wheel notches, also during a drag."""
        self._take(reach=_bounded(self.view.following.reach * _PER_NOTCH**notches))
        text = tr("Neighbours follow over {n:.1f} landmark spacings", n=self.view.following.reach)
        self.window.status.name_point(text)

    def _take(self, **changes: object) -> None:
        self.view.following = dataclasses.replace(self.view.following, **changes)  # type: ignore[arg-type]
        for name, value in changes.items():
            self.settings.setValue(f"{_GROUP}/{name}", value)
        self._show()
        self.changed.emit()

    def _show(self) -> None:
        for name in ("reach-wider", "reach-narrower"):
            self.actions[name].setEnabled(self.view.following.soft)


def _remembered(settings: QSettings) -> Following:
    """Return the stored settings; by default no points follow."""
    first = Following()
    return Following(
        soft=bool(settings.value(f"{_GROUP}/soft", first.soft, bool)),
        reach=_bounded(float(str(settings.value(f"{_GROUP}/reach", first.reach, float)))),
        symmetric=bool(settings.value(f"{_GROUP}/symmetric", first.symmetric, bool)),
    )


def _bounded(reach: float) -> float:
    return min(_MOST_REACH, max(_LEAST_REACH, reach))
