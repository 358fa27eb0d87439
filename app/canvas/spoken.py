"""The photo for a screen reader: its faces, and the points of the one in hand, as objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QObject, QPoint, QPointF, QRect, QRectF, Qt, QTimer
from PySide6.QtGui import (
    QAccessible,
    QAccessibleActionInterface,
    QAccessibleEvent,
    QAccessibleInterface,
    QAccessibleObject,
)
from PySide6.QtWidgets import QAccessibleWidget

from kogao_core.base.geometry import Array
from kogao_core.faces.doubt import SEEN
from kogao_core.faces.targets import matching

from ..accessibility import FOCUS, NOTHING, PRESS, speak
from ..document import Document
from ..i18n import tr
from ..view_state import Handle, ViewState
from . import handles

if TYPE_CHECKING:
    from .photo_canvas import PhotoCanvas

Event = QAccessible.Event
# Shifts along either axis below this are none, px of the photo.
LEAST_PX = 0.05
# Half the side of a point's rectangle, px of the screen.
_POINT_PX = 8.0
_query = QAccessible.queryAccessibleInterface


class Part(QObject):
    """A face on the canvas, or one of its points."""

    def __init__(self, canvas: PhotoCanvas, face: int, handle: Handle | None = None) -> None:
        super().__init__(canvas)
        self.canvas, self.face, self.handle = canvas, face, handle

    @property
    def name(self) -> str:
        """What it is called, and what is set for it."""
        view = self.canvas.shown
        if self.handle is not None:
            return handles.name(self.handle, len(view.state.faces[self.face].outline))
        return face_name(view, self.face)

    @property
    def description(self) -> str:
        """Where a point is and where it came from."""
        if self.handle is None:
            return ""
        return whereabouts(self.canvas.shown.document, self.handle)

    @property
    def chosen(self) -> bool:
        """Whether its settings are edited, or the arrow keys move it."""
        view = self.canvas.shown
        return view.face == self.face if self.handle is None else view.selected == self.handle

    @property
    def rect(self) -> QRectF:
        """Where it is seen, px of the viewport, which it may lie outside of."""
        state, seen = self.canvas.shown.state, self.canvas.to_screen
        if self.handle is not None:
            half = QPointF(_POINT_PX, _POINT_PX)
            at = seen(handles.position(state, self.handle))
            return QRectF(at - half, at + half)
        left, top, width, height = state.faces[self.face].box
        corners = (left, top), (left + width, top + height)
        return QRectF(*(seen(np.array(corner)) for corner in corners))

    @property
    def there(self) -> bool:
        """Whether the document still has it: Qt may ask once more before it ends."""
        state = self.canvas.shown.document.state
        point = self.handle is None or handles.exists(state, self.handle)
        return self.face < len(state.faces) and point

    def take(self) -> None:
        """Do what a click on it does, or the keys that walk from point to point."""
        if self.handle is None:
            self.canvas.setFocus(Qt.FocusReason.OtherFocusReason)
            self.canvas.picked.emit(self.face)
        else:
            self.canvas.taken.emit(self.handle)


class Parts(QObject):
    """Keeps the parts of a canvas up with its document, and tells what becomes of them."""

    def __init__(self, canvas: PhotoCanvas) -> None:
        super().__init__(canvas)
        speak(type(canvas), SpokenCanvas)
        speak(Part, SpokenPart)
        self._canvas, self._view = canvas, canvas.shown
        self._faces: list[Part] = []
        self._points: list[Part] = []
        self._shape: object = None
        self._names: list[str] = []
        self._focused: tuple[Part | None, str] = (None, "")
        self._view.document.changed.connect(self.follow)
        canvas.redrawn.connect(self.follow)
        canvas.entered.connect(self._enter)

    @property
    def faces(self) -> list[Part]:
        """The faces there are now."""
        self._keep_up()
        return self._faces

    @property
    def points(self) -> list[Part]:
        """The points of the face in hand."""
        self._keep_up()
        return self._points

    @property
    def in_focus(self) -> Part | None:
        """What has the focus while the canvas has it: the selected point, else the face."""
        parts = (*self.points, *self.faces)
        return next((part for part in parts if part.chosen), None)

    def follow(self) -> None:
        """Tell of other faces and points, names and choices, if anyone listens."""
        if not QAccessible.isActive():
            return
        self._keep_up()
        if not self._view.document.in_gesture:
            self._tell_names()
            self._tell_place()

    def _keep_up(self) -> None:
        """Make other parts where there are other faces or points."""
        state, hand = self._view.document.state, self._view.face_in_hand
        # The selection may be that of faces that are gone, until those who keep it have heard.
        shown = hand is not None and hand < len(state.faces) and hand not in state.off
        points = len(state.faces[hand].outline) if shown and hand is not None else None
        shape = len(state.faces), hand, points, state.mode
        if shape != self._shape:
            self._shape = shape
            self._take_apart()

    def _enter(self) -> None:
        """Give the focus on to a part, once Qt has told that the canvas has it."""
        self._focused = None, ""
        QTimer.singleShot(0, self, self._tell_place)

    def _take_apart(self) -> None:
        """Make parts of the faces there are now; those of the same faces stay."""
        state, hand = self._view.document.state, self._view.face_in_hand
        if len(self._faces) != len(state.faces):
            self._replace(self._faces, [(face, None) for face in range(len(state.faces))])
        movable = [handle for handle, _ in handles.handles(state, handles.MOVABLE)]
        self._replace(self._points, [(at.face, at) for at in movable if at.face == hand])

    def _replace(self, parts: list[Part], wanted: list[tuple[int, Handle | None]]) -> None:
        for part in parts:
            _tell(part, Event.ObjectDestroyed)
            part.deleteLater()
        parts[:] = [Part(self._canvas, *which) for which in wanted]
        for part in parts:
            _tell(part, Event.ObjectCreated)

    def _tell_names(self) -> None:
        names = [part.name for part in self.faces]
        for part, name, before in zip(self.faces, names, self._names, strict=False):
            if name != before:
                _tell(part, Event.NameChanged)
        self._names = names

    def _tell_place(self) -> None:
        """Tell of another part that has the focus, or of another place of the same one."""
        (before, was), part = self._focused, self.in_focus
        self._focused = part, "" if part is None else part.description
        if part is None:
            return
        if part is before and part.description != was:
            _tell(part, Event.DescriptionChanged)
        elif part is not before and self._canvas.hasFocus():
            _tell(part, Event.Selection)
            _tell(part, Event.Focus)


def _tell(part: Part, event: QAccessible.Event) -> None:
    QAccessible.updateAccessibility(QAccessibleEvent(part, event))


def face_name(view: ViewState, face: int) -> str:
    """Return what a face is called, whether it is selected, and what is set for it."""
    state = view.document.state
    words = [tr("Face {n} of {count}", n=face + 1, count=len(state.faces))]
    if face == view.face:
        words.append(tr("selected"))
    percent = tr("{percent:.4g} %", percent=state.recipe_of(face).percent)
    words.append(tr("left as it is") if face in state.off else percent)
    return ", ".join(words)


def whereabouts(document: Document, handle: Handle) -> str:
    """Return where a point is, how sure it is if not very, and where it was at first."""
    state, at = document.state, handles.position(document.state, handle)
    face = state.faces[handle.face]
    words = [tr("x {x:.0f}, y {y:.0f}", x=at[0], y=at[1])]
    sure = handles.confidence(face, handle)
    if sure is not None and sure < SEEN:
        words.append(tr("{n:.0f} % sure", n=100 * sure))
    if handle.kind == "target":
        by_hand = face.targets is not None and not np.isnan(face.targets[handle.index]).any()
        return ", ".join([*words, tr("set by hand")] if by_hand else words)
    begun = document.base.sheet(state.mode)
    known = matching(face, begun.faces)
    if known is not None and len(begun.faces[known].outline) == len(face.outline):
        index = handles.index_of(face, handle)
        moved = ways(at - begun.faces[known].points[index])
        if moved:
            words.append(tr("{ways} of where it was at first", ways=", ".join(moved)))
    return ", ".join(words)


def ways(away: Array) -> list[str]:
    """Return in words how far something went along either axis, px of the photo, shape (2,)."""
    right_px, down_px = away.tolist()
    x, y = round(abs(right_px), 1), round(abs(down_px), 1)
    across = tr("{px:.4g} px right", px=x) if right_px > 0 else tr("{px:.4g} px left", px=x)
    along = tr("{px:.4g} px down", px=y) if down_px > 0 else tr("{px:.4g} px up", px=y)
    shifts = ((across, right_px), (along, down_px))
    return [words for words, px in shifts if abs(px) >= LEAST_PX]


class _WithParts:
    """An interface whose children are those of some parts."""

    @property
    def _parts(self) -> list[Part]:
        raise NotImplementedError

    def childCount(self) -> int:
        return len(self._parts)

    def child(self, index: int) -> Any:
        parts = self._parts
        return _query(parts[index]) if 0 <= index < len(parts) else None

    def indexOfChild(self, child: QAccessibleInterface) -> int:
        asked = child.object()
        return next((place for place, part in enumerate(self._parts) if part is asked), -1)


class SpokenCanvas(_WithParts, QAccessibleWidget):
    """The photo as a list of its faces."""

    def __init__(self, canvas: PhotoCanvas) -> None:
        super().__init__(canvas, QAccessible.Role.List)
        self._canvas = canvas

    @property
    def _parts(self) -> list[Part]:
        return self._canvas.parts.faces

    def childAt(self, x: int, y: int) -> Any:
        """Return the face at a place of the screen, the selected one before others."""
        faces = sorted(self._canvas.parts.faces, key=lambda part: not part.chosen)
        found = map(_query, faces)
        return next((face for face in found if face.rect().contains(x, y)), None)

    def focusChild(self) -> Any:
        """Return the part that has the focus."""
        part = self._canvas.parts.in_focus if self._canvas.hasFocus() else None
        return super().focusChild() if part is None else _query(part)

    def state(self) -> QAccessible.State:
        """Return what holds of it now: one thing has the focus at a time."""
        state = super().state()
        if self._canvas.parts.in_focus is not None:
            state.focused = False
        return state


class SpokenPart(_WithParts, QAccessibleObject):
    """A face, with its points if it is in hand, or a point."""

    def __init__(self, part: Part) -> None:
        super().__init__(part)
        self._part = part
        self._actions = _PartActions(part)

    @property
    def _parts(self) -> list[Part]:
        points = self._part.canvas.parts.points
        inside = self._part.handle is None and points and points[0].face == self._part.face
        return points if inside else []

    def parent(self) -> QAccessibleInterface:
        """Return the canvas, or the face that a point is of."""
        canvas = self._part.canvas
        faces = canvas.parts.faces
        inside = self._part.handle is not None and self._part.face < len(faces)
        return _query(faces[self._part.face] if inside else canvas)

    def role(self) -> QAccessible.Role:
        """Return that it is one of a list."""
        return QAccessible.Role.ListItem

    def rect(self) -> QRect:
        """Return where it is seen, px of the screen."""
        if not self._part.there:
            return QRect()
        seen, viewport = self._part.rect.toAlignedRect(), self._part.canvas.viewport()
        return seen.translated(viewport.mapToGlobal(QPoint()))

    def state(self) -> QAccessible.State:
        """Return what holds of it now."""
        state, part = QAccessible.State(), self._part
        state.invalid = not part.there
        if part.there:
            state.focusable = state.selectable = True
            state.selected = part.chosen
            state.focused = part.canvas.hasFocus() and part.canvas.parts.in_focus is part
            state.invisible = not part.canvas.isVisible()
            area = part.canvas.viewport().rect().toRectF()
            state.offscreen = not area.intersects(part.rect)
        return state

    def text(self, kind: QAccessible.Text) -> str:
        """Return its name, or where it is."""
        if not self._part.there:
            return ""
        texts = QAccessible.Text
        said = {texts.Name: self._part.name, texts.Description: self._part.description}
        return said.get(kind, "")

    def interface_cast(self, kind: QAccessible.InterfaceType) -> Any:
        """Return what it can be told to do."""
        return self._actions if kind == QAccessible.InterfaceType.ActionInterface else NOTHING


class _PartActions(QAccessibleActionInterface):
    """To choose the face, or to take the point."""

    def __init__(self, part: Part) -> None:
        super().__init__()
        self._part = part

    def actionNames(self) -> list[str]:
        return [PRESS, FOCUS]

    def keyBindingsForAction(self, name: str) -> list[str]:  # noqa: ARG002
        return []

    def doAction(self, name: str) -> None:
        if name in self.actionNames() and self._part.there:
            self._part.take()
