"""Which overlays are on, with their marks and keys: the legend and the switches in one."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QSize
from PySide6.QtGui import QAction, QIcon
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QWidget

from ..i18n import tr
from ..overlays import swatches
from ..theme import GRID_PX
from .controls import column_of, heading, muted_label


class OverlaysPanel(QWidget):
    """A check box for every overlay.

    Parameters
    ----------
    actions : mapping of str to QAction
        The checkable action of each overlay, by the overlay's name.
    """

    def __init__(self, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        self._actions, self._hidden = list(actions.values()), list[QAction]()
        column = column_of(self, spacing=2 * GRID_PX)
        column.addWidget(heading(tr("Overlays")))
        grid = QGridLayout()
        grid.setSpacing(GRID_PX)
        grid.setColumnStretch(0, 1)
        for row, (name, action) in enumerate(actions.items()):
            grid.addWidget(self._box(name, action), row, 0)
            grid.addWidget(_key_label(action), row, 1)
        column.addLayout(grid)

    def hide_all(self, hidden: bool) -> None:
        """Switch all overlays off, or those on again that were."""
        if hidden:
            self._hidden = [action for action in self._actions if action.isChecked()]
        for action in self._hidden:
            action.setChecked(not hidden)

    def _box(self, name: str, action: QAction) -> QCheckBox:
        box = QCheckBox(action.text())
        box.setIcon(QIcon(swatches.pixmap(name, self.devicePixelRatioF())))
        box.setIconSize(QSize(swatches.SIZE_PX, swatches.SIZE_PX))
        box.setChecked(action.isChecked())
        box.setToolTip(action.toolTip())
        box.toggled.connect(action.setChecked)
        action.toggled.connect(box.setChecked)
        return box


def _key_label(action: QAction) -> QLabel:
    label = muted_label(action.shortcut().toString())
    action.changed.connect(lambda: label.setText(action.shortcut().toString()))
    return label
