"""Manual mode's tools, its clock, and the button that stops it."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QToolButton, QWidget

from ..clock import SettingClock
from ..i18n import tr
from ..theme import GRID_PX
from .controls import column_of, heading, muted_label

_COLUMNS = 3


class ManualPanel(QWidget):
    """Shown in manual mode only.

    Parameters
    ----------
    tools : iterable of QAction
        What can be done with points.
    apply, compare : QAction
        Stop the clock; show both modes' results.
    """

    def __init__(self, tools: Iterable[QAction], apply: QAction, compare: QAction) -> None:
        super().__init__()
        self.time = QLabel()
        self.time.setAccessibleName(tr("Setting time"))
        self.note = muted_label()
        top = QHBoxLayout()
        top.addWidget(heading(tr("By hand")))
        top.addStretch()
        top.addWidget(self.note)
        top.addWidget(self.time)
        grid = QGridLayout()
        grid.setSpacing(GRID_PX)
        for place, action in enumerate((*tools, apply, compare)):
            grid.addWidget(_button(action), *divmod(place, _COLUMNS))
        column = column_of(self, spacing=2 * GRID_PX)
        column.addLayout(top)
        column.addLayout(grid)

    def show_clock(self, clock: SettingClock) -> None:
        """Show the time, and whether it runs."""
        minutes, seconds = divmod(clock.elapsed_s, 60)
        self.time.setText(tr("{m:.0f}:{s:04.1f}", m=minutes, s=seconds))
        paused = tr("applied") if clock.applied else tr("paused")
        self.note.setText(tr("setting") if clock.running else paused)


def _button(action: QAction) -> QToolButton:
    button = QToolButton()
    button.setDefaultAction(action)
    button.setAccessibleName(action.text().replace("&", ""))
    button.setProperty("segment", "true")
    button.setProperty("snug", "true")
    button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
    button.setSizePolicy(button.sizePolicy().Policy.Expanding, button.sizePolicy().Policy.Fixed)
    return button
