"""Which overlays are on, with their marks and keys: the legend and the switches in one."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSize
from PySide6.QtGui import QAction, QIcon
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QWidget

from ..actions import Spec
from ..canvas.overlays import glyphs
from ..canvas.overlays.listed import LISTED
from ..canvas.overlays.overlay import Overlay
from ..i18n import tr, translated
from ..theme import GRID_PX
from ..widgets.controls import column_of, heading, muted_label
from .feature import Context, Feature


class OverlaysPanel(QWidget):
    """A check box for every overlay.

    Parameters
    ----------
    actions : sequence of QAction
        The checkable action of each of `LISTED`.
    """

    def __init__(self, actions: Sequence[QAction]) -> None:
        super().__init__()
        self._actions, self._hidden = actions, list[QAction]()
        column = column_of(self, spacing=2 * GRID_PX)
        column.addWidget(heading(tr("Overlays")))
        grid = QGridLayout()
        grid.setSpacing(GRID_PX)
        grid.setColumnStretch(0, 1)
        for row, (overlay, action) in enumerate(zip(LISTED, actions, strict=True)):
            grid.addWidget(self._box(overlay, action), row, 0)
            grid.addWidget(_key_label(action), row, 1)
        column.addLayout(grid)

    def hide_all(self, hidden: bool) -> None:
        """Switch all overlays off, or those on again that were."""
        if hidden:
            self._hidden = [action for action in self._actions if action.isChecked()]
        for action in self._hidden:
            action.setChecked(not hidden)

    def _box(self, overlay: type[Overlay], action: QAction) -> QCheckBox:
        box = QCheckBox(action.text())
        box.setIcon(QIcon(glyphs.swatch(overlay.swatch, self.devicePixelRatioF())))
        box.setIconSize(QSize(glyphs.SWATCH_PX, glyphs.SWATCH_PX))
        box.setChecked(action.isChecked())
        box.setToolTip(action.toolTip())
        box.toggled.connect(action.setChecked)
        action.toggled.connect(box.setChecked)
        return box


def _key_label(action: QAction) -> QLabel:
    label = muted_label(action.shortcut().toString())
    action.changed.connect(lambda: label.setText(action.shortcut().toString()))
    return label


class Overlays(Feature):
    """Switches the overlays on and off."""

    name = "overlays"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.add_actions(
            *map(self._switch, LISTED),
            Spec(
                "hide-overlays",
                tr("Hide all o&verlays"),
                "O",
                tr("The photo without marks, or the same marks again"),
                toggled=self._hide_all,
                checked=False,
            ),
        )
        self.actions["hide-overlays"].setIconText(tr("Hide overlays"))
        self.panel: OverlaysPanel = OverlaysPanel(
            [self.actions[f"overlay-{overlay.name}"] for overlay in LISTED]
        )

    def _switch(self, overlay: type[Overlay]) -> Spec:
        title, name = translated(overlay.title), overlay.name

        def show(on: bool) -> None:
            self.window.canvas.show_overlay(name, on)

        tip = tr("Show or hide: {what}", what=title)
        return Spec(f"overlay-{name}", title, overlay.key, tip, toggled=show, checked=False)

    def _hide_all(self, hidden: bool) -> None:
        self.panel.hide_all(hidden)
