"""Manual mode: points set by hand against a clock, beside the automatic ones, which stay."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QSizePolicy, QWidget

from kogao_core.projects.project import Mode

from ...document import State
from ...i18n import tr
from ...theme import GRID_PX
from ...view_state import Handle
from ...widgets.controls import Fold, action_button, column_of, heading, muted_label, row_of
from ..feature import Context, Feature
from ..points import Points
from ..protect import Protect
from . import marking

_COLUMNS: Final = 3
_TICK_MS: Final = 100
_TOOLS: Final = ("mark", "mirror", "mirror-side", "snap", "apply")


class Manual(Feature):
    """Switches modes, marks points, and keeps the time."""

    name = "manual"
    changed = Signal()
    applied = Signal()

    def __init__(self, context: Context, points: Points, protect: Protect) -> None:
        super().__init__(context)
        self._points = points
        self.clock = SettingClock(self)
        self._start: tuple[float, float] | None = None
        # What was there when manual mode was entered, or when it was applied.
        self._seen: State | None = None
        # Whether the photo began without points set by hand: else what comes is no trial.
        self.fresh: bool | None = None
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
        canvas = self.window.canvas
        canvas.grabbed.connect(self.press)
        canvas.dragged.connect(self.drag)
        canvas.released.connect(self.release)
        self.clock.ticked.connect(lambda: self.panel.show_clock(self.clock))
        self.live.drawn.connect(self.clock.show_photo)
        self.window.activated.connect(self.clock.focus)
        # One way back is enough where the toolbar has it.
        self.window.arranged.connect(
            lambda workspace: self.panel.lead_back("mode-automatic" not in workspace.tools)
        )
        self.clock.focus(self.window.isActiveWindow())
        clock, view = self.clock, self.view
        self.watch(
            lambda: (self.mode, view.marking, clock.running, clock.applied), self.changed.emit
        )

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
            lambda: self._change(marking.mirrored, tr("Mirror a landmark")),
        )
        self.add_action(
            "mirror-side",
            tr("Mirror s&ide"),
            "Ctrl+M",
            tr("Make the other side of the face like the selected point's"),
            lambda: self._change(marking.with_sides_alike, tr("Mirror a side"), renumbered=True),
        )
        self.add_action(
            "snap",
            tr("S&nap"),
            "Shift+N",
            tr("Put the selected point's target on the line to the centre"),
            lambda: self._change(marking.snapped, tr("Snap a target")),
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
        self._seen = self.document.state
        self.clock.apply()
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
        else:
            self._change(marking.without_landmark, tr("Delete a landmark"), renumbered=True)

    def _change(
        self, made: Callable[[State, Handle], State], text: str, *, renumbered: bool = False
    ) -> None:
        handle = self._selected()
        if handle is not None:
            state = made(self.document.state, handle)
            if renumbered:
                self._points.let_selection_go()
            self.document.step(state, text)

    def _selected(self) -> Handle | None:
        handle = self.view.selected
        on_outline = handle is not None and handle.kind in ("outline", "target")
        return handle if on_outline and self.mode == "manual" else None

    def _follow(self) -> None:
        state = self.document.state
        if state.mode != "manual":
            self.view.marking = False
            self._seen = None
            self.clock.want(False)
            return
        self._seen = self._seen or state
        if self.fresh is None:
            self.fresh = not (state.faces or state.draft)
        if _is_set_otherwise(state, self._seen):
            self.clock.set_something()
            self.clock.want(True)
        elif self.fresh:
            self.clock.want(True)

    def _forget(self) -> None:
        self._drop()
        self._seen = self.fresh = None
        self.clock.want(False)
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


class ManualPanel(QWidget):
    """Shown in manual mode only."""

    def __init__(self, back: QAction) -> None:
        super().__init__()
        self.time = QLabel()
        self.time.setAccessibleName(tr("Setting time"))
        self.note = muted_label()
        self.back = QPushButton(tr("Back to automatic"))
        self.back.setToolTip(back.toolTip())
        self.back.clicked.connect(back.trigger)
        tools = QWidget()
        self._grid = QGridLayout(tools)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(GRID_PX)
        self.fold = Fold(tr("Tools"), tools, "hand")
        row = row_of(heading(tr("By hand")), None, self.note, self.time, self.back)
        column_of(self, row, self.fold, spacing=2 * GRID_PX)
        self.lead_back(False)

    def lead_back(self, wanted: bool) -> None:
        """Offer the way back, in place of the clock and of tools that lie open."""
        self.back.setVisible(wanted)
        for reading in (self.note, self.time):
            reading.setHidden(wanted)
        self.fold.flatten(not wanted)

    def add_button(self, action: QAction) -> None:
        """Add what can be done with points, or with the time."""
        button = action_button(action)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self._grid.addWidget(button, *divmod(self._grid.count(), _COLUMNS))

    def show_clock(self, clock: SettingClock) -> None:
        """Show the time, and whether it runs."""
        minutes, seconds = divmod(clock.elapsed_s, 60)
        self.time.setText(tr("{m:.0f}:{s:04.1f}", m=minutes, s=seconds))
        paused = tr("applied") if clock.applied else tr("paused")
        self.note.setText(tr("setting") if clock.running else paused)


class SettingClock(QObject):
    """Runs from the moment a photo is seen in manual mode until it is applied, and in corrections.

    It rests while the window hasn't got the focus, and in the other mode.
    """

    ticked = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._before_ms = 0
        self._since = QElapsedTimer()
        self._shown = self._wanted = self._applied = False
        self._focused = True
        # When the first thing was set, and each time it was applied, s on the clock.
        self.looking_s: float | None = None
        self.applied_s: list[float] = []
        self._tick = QTimer(self, interval=_TICK_MS)
        self._tick.timeout.connect(self.ticked)

    @property
    def elapsed_s(self) -> float:
        """Time on the clock, s."""
        running = self._since.elapsed() if self._since.isValid() else 0
        return (self._before_ms + running) / 1e3

    @property
    def running(self) -> bool:
        """True while time is counted."""
        return self._since.isValid()

    @property
    def applied(self) -> bool:
        """True once the time is taken."""
        return self._applied

    def reset(self) -> None:
        """Begin at nought, with the next photo that is shown."""
        self._shown = self._applied = False
        self.looking_s, self.applied_s = None, []
        self._update()
        self._before_ms = 0
        self.ticked.emit()

    def show_photo(self) -> None:
        """Note that the photo is on screen."""
        if not self._shown:
            self._shown = True
            self._update()

    def want(self, manual: bool) -> None:
        """Count in manual mode only."""
        self._wanted = manual
        self._update()

    def focus(self, focused: bool) -> None:
        """Pause while another window has the focus."""
        self._focused = focused
        self._update()

    def set_something(self) -> None:
        """Note that something is set; after applying that is a correction, which counts, too."""
        if self.looking_s is None:
            self.looking_s = self.elapsed_s
        self._applied = False
        self._update()

    def apply(self) -> None:
        """Stop: everything is set."""
        self._applied = True
        self._update()
        self.applied_s.append(self.elapsed_s)

    def _update(self) -> None:
        run = self._shown and self._wanted and self._focused and not self._applied
        if run and not self._since.isValid():
            self._since.start()
            self._tick.start()
            self.ticked.emit()
        elif not run and self._since.isValid():
            self._before_ms += self._since.elapsed()
            self._since.invalidate()
            self._tick.stop()
            self.ticked.emit()
