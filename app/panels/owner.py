"""Whose settings the recipe panel edits: the photo's, or those of one face."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QWidget

from ..document import State
from ..i18n import tr
from ..theme import GRID_PX
from .controls import column_of, heading, muted_label


class OwnerLine(QWidget):
    """Says whose settings these are; the button leads back to the photo's.

    Signals
    -------
    follow
        The face shall go by the photo's recipe again.
    """

    follow = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.title, self.note = heading(""), muted_label()
        self.note.setWordWrap(True)
        self.button = QPushButton(tr("&Use the photo's"))
        self.button.setToolTip(tr("Forget this face's own settings"))
        self.button.setAccessibleName(tr("Use the photo's settings"))
        self.button.clicked.connect(self.follow)
        row = QHBoxLayout()
        row.setSpacing(2 * GRID_PX)
        row.addWidget(self.title)
        row.addWidget(self.note, 1)
        row.addWidget(self.button)
        column_of(self).addLayout(row)

    def showEvent(self, event: QShowEvent) -> None:
        """Nothing below may jump when the button comes and goes: keep its height, as dressed."""
        self.button.ensurePolished()
        self.setMinimumHeight(self.button.sizeHint().height())
        super().showEvent(event)

    def show_state(self, state: State, chosen: int | None) -> None:
        """Show whose settings are edited and which faces have their own."""
        own = [index for index, face in enumerate(state.faces) if face.recipe is not None]
        if chosen is None:
            numbers = ", ".join(str(index + 1) for index in own)
            self.title.setText(tr("All faces"))
            self.note.setText(tr("but {numbers}", numbers=numbers) if own else "")
        else:
            self.title.setText(tr("Face {n}", n=chosen + 1))
            self.note.setText(tr("its own") if chosen in own else tr("as the photo"))
        self.button.setVisible(chosen in own or (chosen is None and bool(own)))
