"""Dragging points on the canvas, and soft selection."""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np
from PySide6.QtCore import QSettings, Qt, Signal

from ..canvas import handles
from ..canvas.tools import points
from ..canvas.tools.gesture import Gesture, PointerEvent
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

    # (): Escape without a gesture, a message or a selected point.
    escaped = Signal()
    # (face: int): a press on a point of a face.
    took = Signal(int)
    # (face: int, center: int): a click on a centre candidate, from 1.
    center_taken = Signal(int, int)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.document.watch(self._follow, "faces", "off", "mode")
        self.document.opened.connect(self._forget)
        self.steps = (
            self.bind("next-point", lambda: self._walk(1)),
            self.bind("previous-point", lambda: self._walk(-1)),
        )
        self.bind("fetch-point", self.fetch_to_cursor)
        self.bind("abort", self.abort)
        self.view.watch(self._name_hovered, "hovered")
        canvas = self.window.canvas
        canvas.tools |= {"points": self._drag, "fetch": self._fetch}
        canvas.taken.connect(self.take)
        canvas.nudged.connect(self.nudge)
        canvas.nudge_ended.connect(self.document.commit)

    def abort(self) -> None:
        """Cancel the current gesture, else close the message.

        Without either, deselect the point, then the face.
        """
        in_gesture = self.document.in_gesture
        self.document.abort()
        if in_gesture or self.window.bar.dismiss():
            return
        if self.view.selected is not None:
            self.view.set(selected=None)
        else:
            self.escaped.emit()

    def _drag(self, handle: Handle | None, event: PointerEvent) -> Gesture:
        """Drag a handle, or select a centre."""
        assert handle is not None
        self._begin(handle)
        offset_px = handles.position(self.document.committed, handle) - event.point_px
        yield from points.drag(self.view, handle, offset_px)
        if handle.kind == "centre":
            self.center_taken.emit(handle.face, handle.index + 1)

    def _fetch(self, handle: Handle | None, event: PointerEvent) -> Gesture:
        """Move a landmark to the pointer, and drag on; None: no landmark is near."""
        if handle is None:
            self.say(
                tr(
                    "No landmark of the selected face is near there. Select the face, show its "
                    "landmarks, and click with Ctrl closer to its outline."
                )
            )
            return
        self._begin(handle)
        yield from points.drag(self.view, handle, np.zeros(2), event)

    def _begin(self, handle: Handle) -> None:
        self.document.commit()
        self.view.set(selected=handle if handle.kind not in ("corner", "body") else None)
        self.took.emit(handle.face)

    def fetch_to_cursor(self) -> None:
        """Move the nearest landmark to the cursor, as Ctrl+click does."""
        canvas, at = self.window.canvas, self.view.cursor
        if not canvas.in_hand and at is not None:
            at_px = np.array(at)
            canvas.begin("fetch", canvas.outline_near(canvas.to_screen(at_px)), at_px)
            canvas.end(at_px)

    def nudge(self, dx: int, dy: int) -> None:
        """Move the selected point by whole px of the photo."""
        handle, state = self.view.selected, self.document.state
        if handle is not None and handle.movable:
            at = handles.position(state, handle)
            to = at + np.array([dx, dy])
            moved = handles.moved(state, handle, at, to, self.view.following)
            points.preview(self.document, handle, moved)

    def take(self, handle: Handle) -> None:
        """Select a point and focus the canvas for the arrow keys."""
        self.document.commit()
        self.window.canvas.setFocus(Qt.FocusReason.OtherFocusReason)
        self._take_up(handle)

    def _take_up(self, handle: Handle) -> None:
        self.view.set(selected=handle)
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

    def _name_hovered(self) -> None:
        hovered = self.view.hovered
        self.window.status.name_point("" if hovered is None else self.name_of(hovered))

    def name_of(self, handle: Handle) -> str:
        return points.name_of(self.document, handle)

    def _follow(self) -> None:
        """Forget points and faces that no longer exist."""
        state, view = self.document.state, self.view
        gone = {
            name: None
            for name in ("selected", "hovered")
            if (handle := getattr(view, name)) is not None and not handles.exists(state, handle)
        }
        if view.placing is not None and view.placing >= len(state.faces):
            gone["placing"] = None
        view.set(**gone)

    def _forget(self) -> None:
        self.view.set(placing=None, selected=None, hovered=None)


class SoftSelection(Feature):
    """Toggles soft and symmetric drags, and sets the follow range."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.view.set(following=_remembered(self.settings))
        self.bind("soft", toggled=lambda on: self._take(soft=on), checked=self.view.following.soft)
        self.bind(
            "symmetric",
            toggled=lambda on: self._take(symmetric=on),
            checked=self.view.following.symmetric,
        )
        self.bind("reach-wider", lambda: self.widen(1.0))
        self.bind("reach-narrower", lambda: self.widen(-1.0))
        self.window.canvas.widened.connect(self.widen)
        self.view.watch(self._show, "following")

    def widen(self, notches: float) -> None:
        """Change the follow range by wheel notches, also during a drag."""
        self._take(reach=_bounded(self.view.following.reach * _PER_NOTCH**notches))
        text = tr("Neighbours follow over {n:.1f} landmark spacings", n=self.view.following.reach)
        self.window.status.name_point(text)

    def _take(self, **changes: object) -> None:
        following = dataclasses.replace(self.view.following, **changes)  # type: ignore[arg-type]
        self.view.set(following=following)
        for name, value in changes.items():
            self.settings.setValue(f"{_GROUP}/{name}", value)

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
