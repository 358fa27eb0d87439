"""Manual mode: timed setting of points by hand; the automatic points are preserved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QGridLayout, QLabel, QMessageBox, QPushButton, QSizePolicy, QWidget

from kogao_core.faces.doubt import is_partial
from kogao_core.projects.project import Mode

from ...canvas.tools import marking
from ...document import State
from ...i18n import tr
from ...theme import GRID_PX
from ...view_state import Handle
from ...widgets.controls import Fold, action_button, column_of, heading, muted_label, row_of
from ...widgets.dialogs import ask_choice
from ..feature import Context, Feature
from ..points import Points

_COLUMNS: Final = 3
_TICK_MS: Final = 100
_TOOLS: Final = ("mark", "mirror", "mirror-side", "snap", "apply")


class Manual(Feature):
    """Switches modes, marks points, and measures the setting time."""

    name = "manual"
    # (): the mode, marking or the clock has changed.
    changed = Signal()
    # (): the user has applied manual points.
    applied = Signal()

    def __init__(self, context: Context, points: Points) -> None:
        super().__init__(context)
        self._points = points
        self.clock = SettingClock(self)
        # The state when manual mode was entered or last applied.
        self._seen: State | None = None
        self._applied: tuple[object, ...] = ()  # points at the last `apply`
        # True if the photo opened without manual points; other photos give no valid timing.
        self.fresh: bool | None = None
        self._add_actions()
        tools = [self.actions[name] for name in _TOOLS]
        self.panel: ManualPanel = ManualPanel(self.actions["mode-automatic"], tools)
        self.document.opened.connect(self._forget)
        self.changed.connect(self._show)
        self.window.canvas.tools["mark"] = lambda _, event: marking.mark(self.view, event)
        self.clock.ticked.connect(lambda: self.panel.show_clock(self.clock))
        self.view.watch(self._show_photo, "frame")
        self.window.activated.connect(self.clock.focus)
        # Hide the panel's button if the tool bar has the same command.
        self.window.arranged.connect(
            lambda workspace: self.panel.lead_back("mode-automatic" not in workspace.tools)
        )
        self.clock.focus(self.window.isActiveWindow())
        self._told: tuple[object, ...] = ()
        self.document.watch(self._follow, "faces", "off", "recipe", "mode", "kept", "draft")
        self.view.watch(self._put_brush_away, "marking")
        self.view.watch(self._put_marker_away, "brush")

    def _add_actions(self) -> None:
        self.bind("mode-automatic", lambda: self.switch("automatic"), checked=True)
        self.bind("mode-manual", lambda: self.switch("manual"), checked=False)
        self.bind("mark", lambda: self.take_marker(self.actions["mark"].isChecked()), checked=False)
        self.bind("mirror", lambda: self._change(marking.mirrored, tr("Mirror a landmark")))
        self.bind(
            "mirror-side",
            lambda: self._change(marking.with_sides_alike, tr("Mirror a side"), renumbered=True),
        )
        self.bind("snap", lambda: self._change(marking.snapped, tr("Snap a target")))
        self.bind("delete", self.delete)
        self.bind("apply", self.apply)
        self.one_of("mode-automatic", "mode-manual")

    def stop(self) -> None:
        super().stop()
        self.clock.want(False)

    @property
    def mode(self) -> Mode:
        return self.document.state.mode

    def switch(self, mode: Mode) -> None:
        """Switch the mode; the other mode keeps faces and settings."""
        state = self.document.state
        if mode == state.mode or self.document.photo is None:
            self.changed.emit()
            return
        self.document.commit()
        text = tr("Manual mode") if mode == "manual" else tr("Automatic mode")
        self.document.step(state.in_mode(mode), text)
        self.take_marker(mode == "manual" and not self.document.state.faces)

    def take_marker(self, marking_now: bool) -> None:
        """Start or end marking; while marking, a press on the photo adds a landmark."""
        self.view.set(marking=marking_now and self.mode == "manual")
        self._show_photo_as_marked()
        self.changed.emit()

    def apply(self) -> None:
        """Stop the clock: all points are set."""
        self.document.commit()
        if self.clock.applied:
            return
        self._seen = self.document.state
        self._applied = _points(self._seen)
        if not self._seen.draft:
            self.take_marker(False)
        self.clock.apply()
        self._show_photo_as_marked()
        self.changed.emit()
        self.applied.emit()

    # -- the selected point ------------------------------------------------------------------------

    def delete(self) -> None:
        """Delete the selected landmark; for a target, restore the automatic position."""
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
                self.view.set(selected=None, hovered=None)
            self.document.step(state, text)

    def _selected(self) -> Handle | None:
        handle = self.view.selected
        on_outline = handle is not None and handle.kind in ("outline", "target")
        return handle if on_outline and self.mode == "manual" else None

    def settle(self, then: Callable[[], object]) -> None:
        """Apply the points and call `then`; ask before if a face is marked only in part."""
        state = self.document.committed
        if state.mode != "manual" or not (state.draft or any(map(is_partial, state.active))):
            if self.view.unapplied:
                self.apply()
            then()
            return
        text, about = tr("A face is marked only in part."), tr("Which points make the result?")
        answers: dict[str, Callable[[], object]] = {
            tr("&Automatic points"): lambda: self.switch("automatic"),
            tr("Points so &far"): self.apply,
        }
        box = ask_choice(self.window, text, about, answers)
        box.setDefaultButton(QMessageBox.StandardButton.Cancel)
        box.accepted.connect(then)
        self.document.opened.connect(box.reject)  # the question is about the open photo
        box.open()

    def _show_photo_as_marked(self) -> None:
        """Show the original while points wait for *Apply*: they are set on the photo as it was."""
        state, known = self.document.state, (self._applied, _points(self.document.opened_as))
        is_waiting = self.view.marking or _points(state) not in known
        self.view.set(unapplied=state.mode == "manual" and is_waiting)

    def _follow(self) -> None:
        self._measure()
        self._show_photo_as_marked()
        now = (self.mode, self.view.marking, self.clock.running, self.clock.applied)
        if now != self._told:
            self._told = now
            self.changed.emit()

    def _measure(self) -> None:
        """Run the clock while the user sets points."""
        state = self.document.state
        if state.mode != "manual":
            self.view.set(marking=False)
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
        self._seen, self.fresh, self._applied = None, None, ()
        self.clock.want(False)
        self.clock.reset()

    def _show_photo(self) -> None:
        if self.view.frame is not None:
            self.clock.show_photo()

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


def _is_set_otherwise(state: State, seen: State) -> bool:
    """Return whether the user has changed the manual sheet; late detections don't count."""
    here, there = state.sheet("manual"), seen.sheet("manual")
    settings = here.recipe != there.recipe or here.off != there.off
    return settings or here.faces != there.faces or state.draft != seen.draft


def _points(state: State) -> tuple[object, ...]:
    """Return the points set by hand, to compare states."""
    return state.draft, *(face.points.tobytes() for face in state.sheet("manual").faces)


class ManualPanel(QWidget):
    """Panel of manual mode, hidden in automatic mode."""

    def __init__(self, back: QAction, actions: list[QAction]) -> None:
        super().__init__()
        self.time = QLabel()
        self.time.setAccessibleName(tr("Setting time"))
        self.note = muted_label()
        self.back = QPushButton(tr("Back to automatic"))
        self.back.setToolTip(back.toolTip())
        self.back.clicked.connect(back.trigger)
        tools = QWidget()
        grid = QGridLayout(tools)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(GRID_PX)
        for place, action in enumerate(actions):
            button = action_button(action)
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            grid.addWidget(button, *divmod(place, _COLUMNS))
        self.fold = Fold(tr("Tools"), tools, "hand")
        row = row_of(heading(tr("By hand")), None, self.note, self.time, self.back)
        column_of(self, row, self.fold, spacing=2 * GRID_PX)
        self.lead_back(False)

    def lead_back(self, wanted: bool) -> None:
        """Show the button to automatic mode in place of the clock, and fold the tools."""
        self.back.setVisible(wanted)
        for reading in (self.note, self.time):
            reading.setHidden(wanted)
        self.fold.flatten(not wanted)

    def show_clock(self, clock: SettingClock) -> None:
        """Show the setting time and the state of the clock."""
        minutes, seconds = divmod(clock.elapsed_s, 60)
        self.time.setText(tr("{m:.0f}:{s:04.1f}", m=minutes, s=seconds))
        paused = tr("applied") if clock.applied else tr("paused")
        self.note.setText(tr("setting") if clock.running else paused)


class SettingClock(QObject):
    """Measures the setting time: from the first display of a photo in manual mode until applied.

    Corrections count, too. The clock pauses in automatic mode and while another window is active.
    """

    # (): the time has changed; ten times a second while the clock runs.
    ticked = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._before_ms = 0
        self._since = QElapsedTimer()
        self._shown = self._wanted = self._applied = False
        self._focused = True
        # Time of the first edit and of each `apply`, s on the clock.
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
        """True after `apply`, until the next edit."""
        return self._applied

    def reset(self) -> None:
        """Reset to zero; the clock starts when the next photo is shown."""
        self._shown = self._applied = False
        self.looking_s, self.applied_s = None, []
        self._update()
        self._before_ms = 0
        self.ticked.emit()

    def show_photo(self) -> None:
        """Start the clock: the photo is on screen."""
        if not self._shown:
            self._shown = True
            self._update()

    def want(self, manual: bool) -> None:
        self._wanted = manual
        self._update()

    def focus(self, focused: bool) -> None:
        """Pause while another window is active."""
        self._focused = focused
        self._update()

    def set_something(self) -> None:
        """Record an edit. After `apply`, an edit is a correction and restarts the clock."""
        if self.looking_s is None:
            self.looking_s = self.elapsed_s
        self._applied = False
        self._update()

    def apply(self) -> None:
        """Stop the clock: all points are set."""
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
