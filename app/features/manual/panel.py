"""Manual mode's tools, its clock, and the button that stops it."""

from __future__ import annotations

from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QSizePolicy, QWidget

from ...i18n import tr
from ...theme import GRID_PX
from ...widgets.controls import Fold, action_button, column_of, heading, muted_label, row_of

_COLUMNS = 3
_TICK_MS = 100


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
        column = column_of(self, spacing=2 * GRID_PX)
        column.addLayout(row_of(heading(tr("By hand")), None, self.note, self.time, self.back))
        column.addWidget(self.fold)
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
    """Runs while there is a photo, the window has the focus and nothing is applied yet.

    Signals
    -------
    ticked
        Another time is to be shown.
    """

    ticked = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._before_ms = 0
        self._since = QElapsedTimer()
        self._shown = self._wanted = self._applied = False
        self._focused = True
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

    def apply(self, applied: bool) -> None:
        """Stop, or go on because something is set again."""
        self._applied = applied
        self._update()

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
