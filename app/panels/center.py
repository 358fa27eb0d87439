"""The choice of one of the centre candidates."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QAbstractButton,
    QButtonGroup,
    QHBoxLayout,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from kogao_core.settings import CENTERS, cited

from ..i18n import tr
from ..theme import GRID_PX
from . import fields
from .controls import heading

_LEAST_PX: Final = 3 * GRID_PX


class CenterChoice(QWidget):
    """A row of buttons: the candidates of figure 7a.

    Signals
    -------
    chosen(int)
        The number of a candidate, from 1.
    """

    chosen = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        name = heading(fields.label("center"))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(GRID_PX)
        row.addWidget(name)
        row.addStretch()
        self._group = QButtonGroup(self)
        for number in range(1, len(CENTERS) + 1):
            button = QToolButton()
            button.setText(str(number))
            button.setCheckable(True)
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            button.setProperty("segment", "true")
            # As wide as it likes while there is room, narrower where there are many.
            button.setMinimumWidth(_LEAST_PX)
            button.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
            button.setAccessibleName(tr("Centre {n}", n=number))
            button.setToolTip(_center_tip(number))
            self._group.addButton(button, number)
            row.addWidget(button)
        name.setBuddy(self._group.button(1))
        self._group.idClicked.connect(self.chosen)

    def show_number(self, number: int) -> None:
        """Show which candidate is chosen."""
        self._group.button(number).setChecked(True)

    @property
    def buttons(self) -> list[QAbstractButton]:
        """The buttons, candidate 1 first."""
        return self._group.buttons()


def _center_tip(number: int) -> str:
    candidate = CENTERS[number - 1]
    tenths = 10.0 * candidate.fraction
    share = f"{tenths:g} : {10.0 - tenths:g}"
    words = tr("Distance to the eyes : to the mouth = {share}", share=share)
    return cited(words, tr(candidate.where))
