"""Accessible objects for the photo: the faces, and the points of the selected face."""

from __future__ import annotations

from typing import Any

import numpy as np
from PySide6.QtCore import QObject, QPoint, QPointF, QRect, QRectF, Qt, QTimer, Signal
from PySide6.QtGui import (
    QAccessible,
    QAccessibleEvent,
    QAccessibleInterface,
    QAccessibleObject,
    QFocusEvent,
)
from PySide6.QtWidgets import QAccessibleWidget

from kogao_core.base.geometry import Array
from kogao_core.faces.doubt import SEEN
from kogao_core.faces.targets import matching

from ..accessibility import FOCUS, NOTHING, PRESS, Actions, speak
from ..document import Document, State
from ..i18n import tr
from ..view_state import Handle, ViewState
from . import handles
from .viewport import Viewport

Event = QAccessible.Event
# Shifts along an axis below this limit are not read out, px of the photo.
LEAST_PX = 0.05
# Half the side of a point's rectangle, px of the screen.
_POINT_PX = 8.0
_query = QAccessible.queryAccessibleInterface


class SpokenView(Viewport):
    """A view that screen readers see as a list of faces and points."""

    # (face: int): a click or a screen reader selects a face.
    picked = Signal(int)
    # (handle: Handle): a screen reader selects a point.
    taken = Signal(object)
    # (): the view gets the keyboard focus.
    entered = Signal()

    def __init__(self, view: ViewState) -> None:
        super().__init__(view)
        self.parts: Parts = Parts(self)

    def focusInEvent(self, event: QFocusEvent) -> None:
        super().focusInEvent(event)
        self.entered.emit()


class Part(QObject):
    """A face on the canvas, or a point of a face."""

    def __init__(self, canvas: SpokenView, face: int, handle: Handle | None = None) -> None:
        super().__init__(canvas)
        self.canvas, self.face, self.handle = canvas, face, handle
        self.said = self.name, self.description

    @property
    def name(self) -> str:
        """The spoken name: of a point, or of a face with its state and percentage."""
        view = self.canvas.shown
        if self.handle is not None:
            return handles.name(self.handle, len(view.state.faces[self.face].outline))
        return face_name(view, self.face)

    @property
    def description(self) -> str:
        """Position and origin of a point; empty for a face."""
        if self.handle is None:
            return ""
        return whereabouts(self.canvas.shown.document, self.handle)

    @property
    def chosen(self) -> bool:
        """Whether the face or point is selected."""
        view = self.canvas.shown
        return view.face == self.face if self.handle is None else view.selected == self.handle

    @property
    def rect(self) -> QRectF:
        """Bounding rectangle, px of the viewport; may be outside the viewport."""
        state, seen = self.canvas.shown.state, self.canvas.to_screen
        if self.handle is not None:
            half = QPointF(_POINT_PX, _POINT_PX)
            at = seen(handles.position(state, self.handle))
            return QRectF(at - half, at + half)
        left, top, width, height = state.faces[self.face].box
        corners = (left, top), (left + width, top + height)
        return QRectF(*(seen(np.array(corner)) for corner in corners))

    def take(self) -> None:
        """Select the face or the point, as a click or “Next point” does."""
        if self.handle is None:
            self.canvas.setFocus(Qt.FocusReason.OtherFocusReason)
            self.canvas.picked.emit(self.face)
        else:
            self.canvas.taken.emit(self.handle)


class Parts(QObject):
    """Keeps the accessible parts of a canvas up to date and emits accessibility events."""

    def __init__(self, canvas: SpokenView) -> None:
        super().__init__(canvas)
        speak(type(canvas), SpokenCanvas)
        speak(Part, SpokenPart)
        self._canvas, self._view = canvas, canvas.shown
        self._parts: dict[tuple[int, Handle | None], Part] = {}
        self._state: State | None = None
        self._hand: int | None = None
        self._focused: Part | None = None
        self._view.document.watch(self.follow, "faces", "off", "mode", "in_gesture")
        self._view.watch(self.follow, "face", "selected", "full")
        canvas.entered.connect(self._enter)

    def all(self) -> list[Part]:
        """Return parts for all faces, and for the points of the selected face."""
        state, hand = self._view.document.state, self._view.face_in_hand
        if self._state is state and self._hand == hand:
            return list(self._parts.values())
        self._state, self._hand = state, hand
        wanted: list[tuple[int, Handle | None]] = [(face, None) for face in range(len(state.faces))]
        movable = handles.handles(state, handles.MOVABLE)
        wanted += [(at.face, at) for at, _ in movable if at.face == hand]
        for key in self._parts.keys() - wanted:
            gone = self._parts.pop(key)
            _tell(gone, Event.ObjectDestroyed)
            gone.deleteLater()
        known, self._parts = self._parts, {}
        for key in wanted:
            self._parts[key] = known.get(key) or Part(self._canvas, *key)
            if key not in known:
                _tell(self._parts[key], Event.ObjectCreated)
        return list(self._parts.values())

    @property
    def faces(self) -> list[Part]:
        return [part for part in self.all() if part.handle is None]

    @property
    def points(self) -> list[Part]:
        """Parts for the points of the selected face."""
        return [part for part in self.all() if part.handle is not None]

    @property
    def in_focus(self) -> Part | None:
        """The selected point, or the selected face without a point: the focused part."""
        return next((part for part in reversed(self.all()) if part.chosen), None)

    def has(self, part: Part) -> bool:
        """Return whether a part still exists. Qt may query a deleted part once more."""
        return part in self.all()

    def follow(self) -> None:
        """Announce changed faces, points, names and selection, if a screen reader is active."""
        if QAccessible.isActive():
            self.all()
            if not self._view.document.in_gesture:
                self._tell_changes()

    def _enter(self) -> None:
        """Move the focus to a part, after Qt has announced the focus of the canvas."""
        self._focused = None
        QTimer.singleShot(0, self, self._tell_changes)

    def _tell_changes(self) -> None:
        """Announce new names, a newly focused part, or a new description of the focused part."""
        before, self._focused = self._focused, self.in_focus
        for part in self.all():
            name, description = part.said
            part.said = part.name, part.description
            if part.name != name and part.handle is None:
                _tell(part, Event.NameChanged)
            if part is before is self._focused and part.description != description:
                _tell(part, Event.DescriptionChanged)
        if self._focused not in (None, before) and self._canvas.hasFocus():
            _tell(self._focused, Event.Selection)
            _tell(self._focused, Event.Focus)


def _tell(part: Part, event: QAccessible.Event) -> None:
    QAccessible.updateAccessibility(QAccessibleEvent(part, event))


def face_name(view: ViewState, face: int) -> str:
    """Return the spoken name of a face: number, selection and percentage."""
    state = view.document.state
    words = [tr("Face {n} of {count}", n=face + 1, count=len(state.faces))]
    if face == view.face:
        words.append(tr("selected"))
    percent = tr("{percent:.4g} %", percent=state.recipe_of(face).percent)
    words.append(tr("unchanged") if face in state.off else percent)
    return ", ".join(words)


def whereabouts(document: Document, handle: Handle) -> str:
    """Return position, confidence below `SEEN`, and shift since opening, as text."""
    state, at = document.state, handles.position(document.state, handle)
    face = state.faces[handle.face]
    words = [place_name(at)]
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
            words.append(tr("{ways} of the first position", ways=", ".join(moved)))
    return ", ".join(words)


def place_name(at: Array) -> str:
    """Return a position as text. `at` is in px of the photo, shape (2,)."""
    return tr("x {x:.0f}, y {y:.0f}", x=at[0], y=at[1])


def ways(away: Array) -> list[str]:
    """Return the shift along both axes in words. `away` is in px of the photo, shape (2,)."""
    right_px, down_px = away.tolist()
    x, y = round(abs(right_px), 1), round(abs(down_px), 1)
    across = tr("{px:.4g} px right", px=x) if right_px > 0 else tr("{px:.4g} px left", px=x)
    along = tr("{px:.4g} px down", px=y) if down_px > 0 else tr("{px:.4g} px up", px=y)
    shifts = ((across, right_px), (along, down_px))
    return [words for words, px in shifts if abs(px) >= LEAST_PX]


class _WithParts:
    """An accessible interface whose children are `Part` objects."""

    @property
    def _parts(self) -> list[Part]:
        raise NotImplementedError

    def childCount(self) -> int:
        return len(self._parts)

    def child(self, index: int) -> Any:
        parts = self._parts
        return _query(parts[index]) if 0 <= index < len(parts) else None

    def indexOfChild(self, child: QAccessibleInterface) -> int:
        parts, asked = self._parts, child.object()
        return parts.index(asked) if asked in parts else -1


class SpokenCanvas(_WithParts, QAccessibleWidget):
    """The photo as a list of faces."""

    def __init__(self, canvas: SpokenView) -> None:
        super().__init__(canvas, QAccessible.Role.List)
        self._canvas = canvas

    @property
    def _parts(self) -> list[Part]:
        return self._canvas.parts.faces

    def childAt(self, x: int, y: int) -> Any:
        """Return the face at a screen position; prefer the selected face."""
        faces = sorted(self._parts, key=lambda part: not part.chosen)
        found = map(_query, faces)
        return next((face for face in found if face.rect().contains(x, y)), None)

    def focusChild(self) -> Any:
        part = self._canvas.parts.in_focus if self._canvas.hasFocus() else None
        return super().focusChild() if part is None else _query(part)

    def state(self) -> QAccessible.State:
        """Return the state without focus while a part has the focus."""
        state = super().state()
        if self._canvas.parts.in_focus is not None:
            state.focused = False
        return state


class SpokenPart(_WithParts, QAccessibleObject):
    """A point, or a face with points as children if selected."""

    def __init__(self, part: Part) -> None:
        super().__init__(part)
        self._part, self._all = part, part.canvas.parts
        act = {PRESS: part.take, FOCUS: part.take}
        self._actions = Actions(lambda: act if self._all.has(part) else {})

    @property
    def _parts(self) -> list[Part]:
        if self._part.handle is not None:
            return []
        return [point for point in self._all.points if point.face == self._part.face]

    def parent(self) -> QAccessibleInterface:
        """Return the face of a point, or the canvas."""
        inside = self._part.handle is not None and self._all.has(self._part)
        return _query(self._all.faces[self._part.face] if inside else self._part.canvas)

    def role(self) -> QAccessible.Role:
        return QAccessible.Role.ListItem

    def rect(self) -> QRect:
        if not self._all.has(self._part):
            return QRect()
        seen, viewport = self._part.rect.toAlignedRect(), self._part.canvas.viewport()
        return seen.translated(viewport.mapToGlobal(QPoint()))

    def state(self) -> QAccessible.State:
        state, part = QAccessible.State(), self._part
        state.invalid = not self._all.has(part)
        if not state.invalid:
            state.focusable = state.selectable = True
            state.selected = part.chosen
            state.focused = part.canvas.hasFocus() and self._all.in_focus is part
            state.invisible = not part.canvas.isVisible()
            area = part.canvas.viewport().rect().toRectF()
            state.offscreen = not area.intersects(part.rect)
        return state

    def text(self, kind: QAccessible.Text) -> str:
        """Return the name or the description; empty for a deleted part."""
        if not self._all.has(self._part):
            return ""
        texts = QAccessible.Text
        said = {texts.Name: self._part.name, texts.Description: self._part.description}
        return said.get(kind, "")

    def interface_cast(self, kind: QAccessible.InterfaceType) -> Any:
        """Return the action interface; no other interface is available."""
        return self._actions if kind == QAccessible.InterfaceType.ActionInterface else NOTHING
