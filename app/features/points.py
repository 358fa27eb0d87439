"""Taking hold of points on the canvas, what goes along with one, and what that makes of it all."""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np
from PySide6.QtCore import QSettings, Qt, Signal

from kogao_core.base.geometry import Array
from kogao_core.warp.limits import OutOfBounds, check_faces

from ..canvas import handles
from ..document import State
from ..i18n import tr
from ..view_state import Following, Handle
from .feature import Context, Feature

# In landmark spacings: nearer than the least nobody follows, beyond the most everybody does.
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
        self.document.changed.connect(self._follow)
        self.document.opened.connect(self._forget)
        self.document.aborted.connect(self._drop)
        tip = tr("Select a point for the arrow keys")
        self.steps = (
            self.add_action("next-point", tr("Ne&xt point"), "Ctrl+.", tip, lambda: self._walk(1)),
            self.add_action(
                "previous-point", tr("Pre&vious point"), "Ctrl+Shift+.", tip, lambda: self._walk(-1)
            ),
        )
        self.add_action(
            "fetch-point",
            tr("Nea&rest point to the mouse"),
            "R",
            tr("Move the nearest landmark of the outline to where the mouse is"),
            self.fetch_to_cursor,
        )
        self.add_action(
            "abort",
            tr("&Abort the gesture"),
            "Escape",
            tr(
                "Leave everything as it was; without a gesture, close the message, "
                "then let the point go, then the face"
            ),
            self.abort,
        )
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
        """End the gesture in hand as if it hadn't been; without one, close the message.

        Without either, let the point, then the face go.
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
        """Take hold of a handle at (x, y), px of the photo."""
        self.document.commit()
        if handle.kind == "mark":
            return
        self._dragged = handle
        self._offset = handles.position(self.document.committed, handle) - np.array([x, y])
        self._to = None
        self._select(handle if handle.kind not in ("corner", "body") else None)
        self.took.emit(handle.face)

    def drag(self, x: float, y: float) -> None:
        """Move the handle in hand; it stays under the cursor where it was taken."""
        if self._dragged is not None and self._dragged.movable:
            self._to = self._offset + np.array([x, y])
            self._move_dragged()

    def fetch(self, handle: Handle | None, x: float, y: float) -> None:
        """Put a landmark at (x, y), px of the photo, and keep it in hand; None is too far away."""
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
        """Put the nearest landmark where the mouse is, as a click with Ctrl does."""
        at = self.view.cursor
        if self._dragged is None and at is not None:
            canvas = self.window.canvas
            self.fetch(canvas.outline_near(canvas.to_screen(at)), *at.tolist())
            self.release()

    def follow_anew(self) -> None:
        """Show what follows the point in hand, or would follow, once that is something else."""
        if self._dragged is not None and self._to is not None:
            self._move_dragged()
        self.restyled.emit()

    def release(self) -> None:
        """Let go: a moved point is one undo step, a centre is chosen."""
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
            # What lies below the gesture can have got faces that were found meanwhile.
            before, dragged = self.document.committed, self._dragged
            start = handles.position(before, dragged)
            state = handles.moved(before, dragged, start, self._to, self.view.following)
            self._take(dragged, state)

    def _take(self, handle: Handle, moved: State) -> None:
        """Show a handle moved; one drawn far out of the photo stays where it was."""
        try:
            check_faces([moved.faces[handle.face]], self.document.image)
        except OutOfBounds:
            return
        away = handles.position(moved, handle) - handles.position(self.document.committed, handle)
        px = tr("{px:.1f} px", px=float(np.hypot(*away)))
        self.document.preview(moved, self.name_of(handle), px)

    def take(self, handle: Handle) -> None:
        """Select a point for the arrow keys, which go to the photo from now on."""
        self.document.commit()
        self.window.canvas.setFocus(Qt.FocusReason.OtherFocusReason)
        self._take_up(handle)

    def _take_up(self, handle: Handle) -> None:
        self._select(handle)
        self.window.status.name_point(self.name_of(handle))

    def _walk(self, step: int) -> None:
        """Select the point that comes `step` places after the selected one, going round."""
        if self._unselected():
            self.say(
                tr("Select a face first: click it, or choose it in the list (Alt+S)."),
                wrong=False,
                applies=self._unselected,
            )
            return
        # Wherever the keys went before, the arrows move the point now.
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
        """Put the selected target back on its line to the centre."""
        handle, state = self.view.selected, self.document.state
        if handle is None or handle.kind != "target":
            return
        face = state.faces[handle.face]
        if face.targets is not None and np.isfinite(face.targets[handle.index]).all():
            face = face.with_target(handle.index, None)
            self.document.step(state.with_face(handle.face, face), tr("Automatic target"))

    def let_selection_go(self) -> None:
        """Select nothing: what the points are numbered by has changed."""
        self.view.hovered = None
        self._select(None)

    def hover(self, handle: Handle | None, x: float, y: float) -> None:
        """Name the point under the cursor, and note where that is; the canvas says -1 for away."""
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
        """Return what a point of the document is called."""
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
    """Switches the soft and the symmetric drag, and says how far neighbours follow."""

    changed = Signal()

    def __init__(self, context: Context, points: Points) -> None:
        super().__init__(context)
        self.view.following = _remembered(self.settings)
        self.add_action(
            "soft",
            tr("Nei&ghbours follow"),
            "Q",
            tr("Neighbours follow a landmark or a target; turn the wheel while dragging"),
            toggled=lambda on: self._take(soft=on),
            checked=self.view.following.soft,
        )
        self.add_action(
            "symmetric",
            tr("&Both sides"),
            "Shift+Q",
            tr("The landmark or target across the face makes the mirrored move"),
            toggled=lambda on: self._take(symmetric=on),
            checked=self.view.following.symmetric,
        )
        self.add_action(
            "reach-wider",
            tr("Follow far&ther"),
            "Ctrl+]",
            tr("More neighbours follow"),
            lambda: self.widen(1.0),
        )
        self.add_action(
            "reach-narrower",
            tr("Follow &less far"),
            "Ctrl+[",
            tr("Fewer neighbours follow"),
            lambda: self.widen(-1.0),
        )
        self.window.canvas.widened.connect(self.widen)
        self.changed.connect(points.follow_anew)
        self._show()

    def widen(self, notches: float) -> None:
        """Let neighbours follow farther along the outline, or less far; a drag in hand, too."""
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
    """Return what followed at the end of the last session; at first, nothing does."""
    first = Following()
    return Following(
        soft=bool(settings.value(f"{_GROUP}/soft", first.soft, bool)),
        reach=_bounded(float(str(settings.value(f"{_GROUP}/reach", first.reach, float)))),
        symmetric=bool(settings.value(f"{_GROUP}/symmetric", first.symmetric, bool)),
    )


def _bounded(reach: float) -> float:
    return min(_MOST_REACH, max(_LEAST_REACH, reach))
