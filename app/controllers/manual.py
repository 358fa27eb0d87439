"""Manual mode: points set by hand against a clock, beside the automatic ones, which stay."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from kogao_core.project import Mode

from .. import marking
from ..clock import SettingClock
from ..document import Document, State
from ..i18n import tr
from ..points import Handle
from ..scene import Scene
from .editing import Editing


class Manual(QObject):
    """Switches modes, marks points, and keeps the time.

    Signals
    -------
    changed
        Another mode or tool is in hand, or the clock was stopped or set going.
    applied
        Everything is set, and the clock has stopped.
    """

    changed = Signal()
    applied = Signal()

    def __init__(
        self, document: Document, scene: Scene, editing: Editing, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._document, self._scene, self._editing = document, scene, editing
        self.clock = SettingClock(self)
        self._start: tuple[float, float] | None = None
        self._before: State = document.state
        # What is only looked at so far: the clock waits for the first change to it.
        self._seen: State | None = None
        self._setting = False
        document.opened.connect(self._forget)
        document.changed.connect(self._follow)
        editing.aborted.connect(self._drop)

    @property
    def mode(self) -> Mode:
        """The mode at work."""
        return self._document.state.mode

    def switch(self, mode: Mode) -> None:
        """Go on in a mode; the other one's faces and settings are kept."""
        state = self._document.state
        if mode == state.mode or self._document.photo is None:
            self.changed.emit()
            return
        self._editing.commit()
        text = tr("Manual mode") if mode == "manual" else tr("Automatic mode")
        self._editing.step(state.in_mode(mode), text)
        self.take_marker(mode == "manual" and not self._document.state.faces)

    def take_marker(self, marking_now: bool) -> None:
        """Let a press on the photo mark a landmark, or drag the photo again."""
        self._scene.marking = marking_now and self.mode == "manual"
        self.changed.emit()

    def apply(self) -> None:
        """Stop the clock: everything is set."""
        self._editing.commit()
        if self.clock.applied:
            return
        self._rest(self._document.state)
        self.clock.apply(True)
        self.changed.emit()
        self.applied.emit()

    # -- a press marks a landmark, the drag its target --------------------------------------------

    def press(self, handle: Handle, x: float, y: float) -> None:
        """Mark a landmark at (x, y), px of the photo."""
        if handle.kind == "mark":
            self._start, self._before = (x, y), self._document.state
            self.drag(x, y)

    def drag(self, x: float, y: float) -> None:
        """Put the target of the landmark in hand at (x, y)."""
        if self._start is not None:
            face = marking.owner(self._before, self._scene.face, self._start)
            state = marking.marked(self._before, face, (self._start, (x, y)))
            self._editing.preview(state, tr("Mark a landmark"))

    def release(self) -> None:
        """Let go: the landmark is one undo step."""
        if self._start is not None:
            self._start = None
            self._editing.commit()

    # -- the selected point ------------------------------------------------------------------------

    def delete(self) -> None:
        """Delete the selected landmark; a target goes back on its line to the centre."""
        handle = self._selected()
        if handle is None or handle.kind == "target":
            self._editing.make_automatic()
            return
        state = marking.without_landmark(self._document.state, handle)
        self._editing.let_selection_go()
        self._editing.step(state, tr("Delete a landmark"))

    def mirror(self) -> None:
        """Put the selected landmark on the other side, too."""
        handle = self._selected()
        if handle is not None:
            state = marking.mirrored(self._document.state, handle)
            self._editing.step(state, tr("Mirror a landmark"))

    def mirror_side(self) -> None:
        """Make the other side like the selected landmark's."""
        handle = self._selected()
        if handle is not None:
            state = marking.with_sides_alike(self._document.state, handle)
            self._editing.let_selection_go()
            self._editing.step(state, tr("Mirror a side"))

    def snap(self) -> None:
        """Put the selected landmark's target on the line to the centre."""
        handle = self._selected()
        if handle is not None:
            state = marking.snapped(self._document.state, handle)
            self._editing.step(state, tr("Snap a target"))

    def _selected(self) -> Handle | None:
        handle = self._scene.selected
        on_outline = handle is not None and handle.kind in ("outline", "target")
        return handle if on_outline and self.mode == "manual" else None

    def _follow(self) -> None:
        state = self._document.state
        if state.mode != "manual":
            self._scene.marking = False
            self._rest(None)
        elif self._seen is None:
            self._rest(state)
        elif not self._setting and _is_set_otherwise(state, self._seen):
            self._setting = True
            # What is set after applying takes time, too.
            self.clock.apply(False)
            self.clock.want(True)
        self.changed.emit()

    def _rest(self, seen: State | None) -> None:
        self._seen, self._setting = seen, False
        self.clock.want(False)

    def _forget(self) -> None:
        self._drop()
        self._rest(None)
        self.clock.reset()

    def _drop(self) -> None:
        self._start = None


def _is_set_otherwise(state: State, seen: State) -> bool:
    """Tell whether the user has changed what manual mode holds; faces found meanwhile don't."""
    here, there = state.sheet("manual"), seen.sheet("manual")
    settings = here.recipe != there.recipe or here.off != there.off
    return settings or here.faces != there.faces or state.draft != seen.draft
