"""Manual mode: points set by hand against a clock, beside the automatic ones, which stay."""

from __future__ import annotations

from PySide6.QtCore import Signal

from kogao_core.project import Mode

from ...canvas.handles import Handle
from ...document import State
from ...i18n import tr
from ..feature import Context, Feature
from ..points import Points
from ..protect import Protect
from . import marking
from .panel import ManualPanel, SettingClock

_TOOLS = ("mark", "mirror", "mirror-side", "snap", "apply")


class Manual(Feature):
    """Switches modes, marks points, and keeps the time.

    Signals
    -------
    changed
        Another mode or tool is in hand, or the clock was stopped or set going.
    applied
        Everything is set, and the clock has stopped.
    """

    name = "manual"
    changed = Signal()
    applied = Signal()

    def __init__(self, context: Context, points: Points, protect: Protect) -> None:
        super().__init__(context)
        self._points = points
        self.clock = SettingClock(self)
        self._start: tuple[float, float] | None = None
        # What is only looked at so far: the clock waits for the first change to it.
        self._seen: State | None = None
        self._setting = False
        self._known: tuple[Mode, bool, bool, bool] | None = None
        self._add_actions()
        self.panel: ManualPanel = ManualPanel(self.actions["mode-automatic"])
        for name in _TOOLS:
            self.panel.add_button(self.actions[name])
        self.document.opened.connect(self._forget)
        self.document.changed.connect(self._follow)
        self.document.aborted.connect(self._drop)
        self.changed.connect(self._show)
        self.changed.connect(self._put_brush_away)
        protect.changed.connect(self._put_marker_away)
        self._join_canvas()
        self.clock.ticked.connect(lambda: self.panel.show_clock(self.clock))
        self.live.drawn.connect(self.clock.show_photo)
        self.window.activated.connect(self.clock.focus)
        # One way back is enough where the toolbar has it.
        self.window.arranged.connect(
            lambda workspace: self.panel.lead_back("mode-automatic" not in workspace.tools)
        )
        self.clock.focus(self.window.isActiveWindow())
        self._show()

    def _add_actions(self) -> None:
        by_hand = tr("Points set by hand, the paper's conventional method (table 2)")
        self.add_action(
            "mode-automatic",
            tr("&Automatic"),
            "F2",
            tr("Points found by the machine"),
            lambda: self.switch("automatic"),
            checked=True,
        )
        self.add_action(
            "mode-manual",
            tr("&Manual"),
            "F3",
            by_hand,
            lambda: self.switch("manual"),
            checked=False,
        )
        self.add_action(
            "mark",
            tr("Mar&k"),
            "M",
            tr("Press to set a landmark, drag to where it goes"),
            lambda: self.take_marker(self.actions["mark"].isChecked()),
            checked=False,
        )
        self.add_action(
            "mirror",
            tr("Mi&rror"),
            "Shift+M",
            tr("The selected point on the other side"),
            self.mirror,
        )
        self.add_action(
            "mirror-side",
            tr("Mirror s&ide"),
            "Ctrl+M",
            tr("Make the other side of the face like the selected point's"),
            self.mirror_side,
        )
        self.add_action(
            "snap",
            tr("S&nap"),
            "Shift+N",
            tr("Put the selected point's target on the line to the centre"),
            self.snap,
        )
        self.add_action(
            "delete",
            tr("&Delete the selected point"),
            "Delete",
            tr("Delete a landmark set by hand; put a target back on its line"),
            self.delete,
        )
        self.add_action(
            "apply",
            tr("A&pply"),
            "Ctrl+Return",
            tr("Everything is set: stop the clock"),
            self.apply,
        )
        self.one_of("mode-automatic", "mode-manual")

    def _join_canvas(self) -> None:
        canvas = self.window.canvas
        canvas.grabbed.connect(self.press)
        canvas.dragged.connect(self.drag)
        canvas.released.connect(self.release)

    def stop(self) -> None:
        """Stop the clock."""
        super().stop()
        self.clock.want(False)

    @property
    def mode(self) -> Mode:
        """The mode at work."""
        return self.document.state.mode

    def switch(self, mode: Mode) -> None:
        """Go on in a mode; the other one's faces and settings are kept."""
        state = self.document.state
        if mode == state.mode or self.document.photo is None:
            self.changed.emit()
            return
        self.document.commit()
        text = tr("Manual mode") if mode == "manual" else tr("Automatic mode")
        self.document.step(state.in_mode(mode), text)
        self.take_marker(mode == "manual" and not self.document.state.faces)

    def take_marker(self, marking_now: bool) -> None:
        """Let a press on the photo mark a landmark, or drag the photo again."""
        self.view.marking = marking_now and self.mode == "manual"
        self.changed.emit()

    def apply(self) -> None:
        """Stop the clock: everything is set."""
        self.document.commit()
        if self.clock.applied:
            return
        self._rest(self.document.state)
        self.clock.apply(True)
        self.changed.emit()
        self.applied.emit()

    # -- a press marks a landmark, the drag its target --------------------------------------------

    def press(self, handle: Handle, x: float, y: float) -> None:
        """Mark a landmark at (x, y), px of the photo."""
        if handle.kind == "mark":
            self._start = (x, y)
            self.drag(x, y)

    def drag(self, x: float, y: float) -> None:
        """Put the target of the landmark in hand at (x, y)."""
        if self._start is not None:
            before = self.document.committed
            face = marking.owner(before, self.view.face, self._start)
            state = marking.marked(before, face, (self._start, (x, y)))
            self.document.preview(state, tr("Mark a landmark"))

    def release(self) -> None:
        """Let go: the landmark is one undo step."""
        if self._start is not None:
            self._start = None
            self.document.commit()

    # -- the selected point ------------------------------------------------------------------------

    def delete(self) -> None:
        """Delete the selected landmark; a target goes back on its line to the centre."""
        handle = self._selected()
        if handle is None or handle.kind == "target":
            self._points.make_automatic()
            return
        state = marking.without_landmark(self.document.state, handle)
        self._points.let_selection_go()
        self.document.step(state, tr("Delete a landmark"))

    def mirror(self) -> None:
        """Put the selected landmark on the other side, too."""
        handle = self._selected()
        if handle is not None:
            state = marking.mirrored(self.document.state, handle)
            self.document.step(state, tr("Mirror a landmark"))

    def mirror_side(self) -> None:
        """Make the other side like the selected landmark's."""
        handle = self._selected()
        if handle is not None:
            state = marking.with_sides_alike(self.document.state, handle)
            self._points.let_selection_go()
            self.document.step(state, tr("Mirror a side"))

    def snap(self) -> None:
        """Put the selected landmark's target on the line to the centre."""
        handle = self._selected()
        if handle is not None:
            state = marking.snapped(self.document.state, handle)
            self.document.step(state, tr("Snap a target"))

    def _selected(self) -> Handle | None:
        handle = self.view.selected
        on_outline = handle is not None and handle.kind in ("outline", "target")
        return handle if on_outline and self.mode == "manual" else None

    def _follow(self) -> None:
        state = self.document.state
        if state.mode != "manual":
            self.view.marking = False
            self._rest(None)
        elif self._seen is None:
            self._rest(state)
        elif not self._setting and _is_set_otherwise(state, self._seen):
            self._setting = True
            # What is set after applying takes time, too.
            self.clock.apply(False)
            self.clock.want(True)
        now = (state.mode, self.view.marking, self.clock.running, self.clock.applied)
        if now != self._known:
            self._known = now
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

    def _put_marker_away(self) -> None:
        if self.view.brush.paints and self.view.marking:
            self.take_marker(False)

    def _put_brush_away(self) -> None:
        if self.view.marking and self.view.brush.paints:
            self.actions["tool-points"].trigger()

    def _show(self) -> None:
        by_hand = self.mode == "manual"
        self.actions[f"mode-{self.mode}"].setChecked(True)
        self.actions["mark"].setChecked(self.view.marking)
        for name in _TOOLS:
            self.actions[name].setEnabled(by_hand)
        self.window.need(self.name, by_hand)
        self.panel.show_clock(self.clock)
        self.window.canvas.redraw()


def _is_set_otherwise(state: State, seen: State) -> bool:
    """Tell whether the user has changed what manual mode holds; faces found meanwhile don't."""
    here, there = state.sheet("manual"), seen.sheet("manual")
    settings = here.recipe != there.recipe or here.off != there.off
    return settings or here.faces != there.faces or state.draft != seen.draft
