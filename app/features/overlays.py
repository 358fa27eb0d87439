"""Which overlays are on, with their marks and keys; and when the marks of faces step back."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np
from PySide6.QtCore import QSize, QTimer
from PySide6.QtGui import QAction, QIcon
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QWidget

from ..canvas.handles import face_at
from ..canvas.overlays import glyphs
from ..canvas.overlays.listed import LISTED
from ..canvas.overlays.overlay import Overlay
from ..i18n import tr, translated
from ..theme import GRID_PX
from ..view_state import Handle
from ..widgets.controls import column_of, heading, muted_label
from ..workspaces import INSPECT, Workspace
from .feature import Context, Feature
from .files import Files
from .points import Points
from .recipe import RecipeEditing

# How long a setting rests before the marks come back.
REST_MS: Final = 700
# A face is pointed at from this far outside it, in its landmark spacings.
_MARGIN: Final = 1.5


class OverlaysPanel(QWidget):
    """A check box for every overlay."""

    def __init__(self, actions: Sequence[QAction]) -> None:
        super().__init__()
        self._actions, self._hidden = actions, list[QAction]()
        grid = QGridLayout()
        grid.setSpacing(GRID_PX)
        grid.setColumnStretch(0, 1)
        for row, (overlay, action) in enumerate(zip(LISTED, actions, strict=True)):
            grid.addWidget(self._box(overlay, action), row, 0)
            grid.addWidget(_key_label(action), row, 1)
        column_of(self, heading(tr("Overlays")), grid, spacing=2 * GRID_PX)

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
        self.switches = {overlay.name: self._add_switch(overlay) for overlay in LISTED}
        hide = self.add_action(
            "hide-overlays",
            tr("Hide all o&verlays"),
            "O",
            tr("The photo without marks, or the same marks again"),
            toggled=lambda on: self.panel.hide_all(on),
        )
        hide.setIconText(tr("Hide overlays"))
        self.panel: OverlaysPanel = OverlaysPanel([*self.switches.values()])

    def _add_switch(self, overlay: type[Overlay]) -> QAction:
        title = translated(overlay.title)
        show = partial(self.window.canvas.show_overlay, overlay.name)
        tip = tr("Show or hide: {what}", what=title)
        return self.add_action(f"overlay-{overlay.name}", title, overlay.key, tip, toggled=show)


class Marks(Feature):
    """Says which faces' marks are shown, as `ViewState.pointed`.

    In a quiet workspace they show under the cursor and on a point that is dragged or moved by keys,
    and go while a setting moves. The first start shows them all: they explain what was found.
    """

    def __init__(
        self,
        context: Context,
        recipe: RecipeEditing,
        files: Files,
        points: Points,
        overlays: Overlays,
    ) -> None:
        super().__init__(context)
        self._quiet = self._by_key = False
        self._under: int | None = None
        self._moving = QTimer(self, singleShot=True, interval=REST_MS)
        self._moving.timeout.connect(self._show)
        self.window.arranged.connect(self._arrange)
        recipe.moved.connect(self._step_back)
        canvas = self.window.canvas
        canvas.hovered.connect(self._point)
        canvas.nudged.connect(self._take_by_key)
        canvas.taken.connect(self._take_by_key)
        for step in points.steps:
            step.triggered.connect(self._take_by_key)
        files.welcomed.connect(lambda: self._explain(True))
        self.document.opened.connect(
            lambda: self._explain(bool(self.view.explained) and files.on_sample())
        )
        for switch in overlays.switches.values():
            switch.triggered.connect(lambda: self._explain(False))
        self.document.changed.connect(self._show)

    def show_all(self) -> None:
        """Let no mark step back, as a picture that asks for them needs it."""
        self._quiet = False
        self._show()

    def _arrange(self, workspace: Workspace) -> None:
        self._quiet = workspace.quiet
        self._show()

    def _explain(self, explains: bool) -> None:
        self.view.explained = frozenset(INSPECT.overlays if explains else ())
        self._show()

    def _step_back(self) -> None:
        self._moving.start()
        self._show()

    def _take_by_key(self, *_: object) -> None:
        self._by_key = True
        self._show()

    def _point(self, handle: Handle | None, x: float, y: float) -> None:
        self._by_key = False
        faces = self.document.state.faces
        self._under = None if handle is None else handle.face
        if self._under is None and faces and (x, y) != (-1.0, -1.0):
            far_px = _MARGIN * min(face.anchor.spacing_px for face in faces)
            self._under = face_at(faces, np.array([x, y]), far_px)
        self._show()

    def _show(self) -> None:
        pointed = self._pointed()
        if pointed != self.view.pointed:
            self.view.pointed = pointed
            self.window.canvas.redraw()

    def _pointed(self) -> frozenset[int] | None:
        view = self.view
        by_hand = view.state.mode == "manual" or view.marking or view.placing is not None
        if not self._quiet or self.view.explained or by_hand:
            return None
        if self._moving.isActive():
            return frozenset()
        faces = {self._under, view.face} if self._under is not None else set[int | None]()
        selected = view.selected
        if selected is not None and (self._by_key or self.document.in_gesture):
            faces.add(selected.face)
        return frozenset(face for face in faces if face is not None)
