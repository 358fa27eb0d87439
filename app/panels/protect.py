"""The tools that say what must not move: which one, how large, with which edge."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QPushButton, QToolButton, QWidget

from ..i18n import tr
from ..theme import GRID_PX
from ..tools import LARGEST_PX, SMALLEST_PX, Brush, ToolName
from .controls import Fold, Scale, ValueSlider, column_of, muted_label

_PER_OCTAVE: Final = 8


class ProtectPanel(QWidget):
    """Tools, size, edge, and a way to remove everything.

    Parameters
    ----------
    tools : mapping of str to QAction
        The checkable action of each tool, by the tool's name.
    hard : QAction
        Whether the next strokes have a hard edge.
    clear : QAction
        Removes all protection.

    Signals
    -------
    resized(float)
        Another radius of the brush, px of the photo.
    reset
        The brush's first size is wanted.
    """

    resized = Signal(float)
    reset = Signal()

    def __init__(self, tools: Mapping[ToolName, QAction], hard: QAction, clear: QAction) -> None:
        super().__init__()
        self.size_px = ValueSlider(tr("Brush si&ze"), _sizes(), _size_tip(), 0)
        self.size_px.edited.connect(self.resized)
        self.size_px.reset.connect(self.reset)
        self.hard = QCheckBox(tr("Har&d edge: not a pixel of it moves"))
        self.hard.setToolTip(tr("The move fades out beside the stroke and is nothing on it"))
        self.hard.toggled.connect(hard.setChecked)
        hard.toggled.connect(self.hard.setChecked)
        self.count = muted_label()
        self.clear = QPushButton(tr("Remove all"))
        self.clear.setAccessibleName(tr("Remove all protection"))
        self.clear.clicked.connect(clear.trigger)
        body = QWidget()
        self.fold = Fold(tr("Protect"), body)
        column_of(self).addWidget(self.fold)
        column = column_of(body, spacing=2 * GRID_PX)
        column.addLayout(_row(tools))
        column.addWidget(self.size_px)
        column.addWidget(self.hard)
        foot = QHBoxLayout()
        foot.addWidget(self.count)
        foot.addStretch()
        foot.addWidget(self.clear)
        column.addLayout(foot)

    def show_brush(self, brush: Brush) -> None:
        """Show how large the tool in hand is, and unfold for one that paints."""
        if brush.paints:
            self.fold.button.setChecked(True)
        self.size_px.show_value(brush.radius_px)

    def show_count(self, strokes: int) -> None:
        """Show how many strokes there are."""
        words = tr("Strokes: {n}", n=strokes) if strokes else tr("Nothing is protected")
        self.count.setText(words)
        self.clear.setEnabled(strokes > 0)


def _row(tools: Mapping[ToolName, QAction]) -> QHBoxLayout:
    row = QHBoxLayout()
    row.setSpacing(GRID_PX)
    for action in tools.values():
        button = QToolButton()
        button.setDefaultAction(action)
        button.setAccessibleName(action.text())
        button.setProperty("segment", "true")
        button.setProperty("snug", "true")
        button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        row.addWidget(button, 1)
    return row


def _sizes() -> Scale:
    low, high = (round(_PER_OCTAVE * math.log2(px)) for px in (SMALLEST_PX, LARGEST_PX))
    return Scale(
        low,
        high,
        _PER_OCTAVE,
        lambda n: 2.0 ** (n / _PER_OCTAVE),
        lambda v: round(_PER_OCTAVE * math.log2(v)),
        lambda v: tr("{v:.0f} px across", v=2 * v),
    )


def _size_tip() -> str:
    return tr("Width of brush, line and eraser in px of the photo; [ and ] change it")
