"""Overlay switches, visibility of marks, and analysis of the background."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np
from PySide6.QtCore import QSize, QTimer, Signal
from PySide6.QtGui import QAction, QActionGroup, QIcon
from PySide6.QtWidgets import QCheckBox, QGridLayout, QWidget

from kogao_core.background.find import BackgroundFinder, MeasuredLines, measure
from kogao_core.background.lines import BackgroundLine
from kogao_core.base.geometry import Image, Line
from kogao_core.projects.json import as_line

from ..actions import Item
from ..canvas.handles import face_at
from ..canvas.overlays import glyphs
from ..canvas.overlays.listed import LISTED
from ..canvas.overlays.overlay import Overlay
from ..i18n import reason, sentence, tr, translated
from ..theme import GRID_PX
from ..view_state import RenderedFrame
from ..widgets.controls import column_of, heading, muted_label
from ..workspaces import RETOUCH, Workspace
from .feature import Context, Feature
from .files import Files
from .points import Points
from .recipe import RecipeEditing

# Delay before marks reappear after a setting has changed, ms.
REST_MS: Final = 700
# Distance from a face within which the cursor selects the marks, in landmark spacings.
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
            grid.addWidget(muted_label(action.shortcut().toString()), row, 1)
        column_of(self, heading(tr("Overlays")), grid, spacing=2 * GRID_PX)

    def hide_all(self, hidden: bool) -> None:
        """Hide all overlays, or show the hidden overlays again."""
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


class Overlays(Feature):
    """Shows and hides the overlays."""

    name = "overlays"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.switches = {overlay.name: self._add_switch(overlay) for overlay in LISTED}
        # Two maps would mix their colours.
        self.one_of("overlay-heat", "overlay-jacobian").setExclusionPolicy(
            QActionGroup.ExclusionPolicy.ExclusiveOptional
        )
        hide = self.bind("hide-overlays", toggled=lambda on: self.panel.hide_all(on))
        hide.setIconText(tr("Hide overlays"))
        self.panel: OverlaysPanel = OverlaysPanel([*self.switches.values()])

    def _add_switch(self, overlay: type[Overlay]) -> QAction:
        title = translated(overlay.title)
        show = partial(self._show, overlay.name)
        tip = tr("Show or hide: {what}", what=title)
        return self.bind(Item(f"overlay-{overlay.name}", title, overlay.key, tip), toggled=show)

    def _show(self, name: str, on: bool) -> None:
        others = self.view.switched - {name}
        self.view.set(switched=others | {name} if on else others)


class Marks(Feature):
    """Decides which faces show marks, stored in `ViewState.pointed`.

    In a quiet workspace marks show under the cursor and for a moved point, and hide while a
    setting changes. The first start shows all marks, to explain the detected landmarks.
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
        self.view.watch(self._point, "cursor", "hovered")
        canvas.nudged.connect(self._take_by_key)
        canvas.taken.connect(self._take_by_key)
        for step in points.steps:
            step.triggered.connect(self._take_by_key)
        files.welcomed.connect(lambda: self._explain(True))
        self.document.opened.connect(self._moving.stop)
        self.document.opened.connect(
            lambda: self._explain(bool(self.view.explained) and files.on_sample())
        )
        for switch in overlays.switches.values():
            switch.triggered.connect(lambda: self._explain(False))
        self.document.watch(self._show, "faces", "mode", "in_gesture")

    def show_all(self) -> None:
        """Show all marks permanently, for screenshots of overlays."""
        self._quiet = False
        self._show()

    def _arrange(self, workspace: Workspace) -> None:
        self._quiet = workspace.quiet
        self._show()

    def _explain(self, explains: bool) -> None:
        self.view.set(explained=frozenset(RETOUCH.overlays if explains else ()))
        self._show()

    def _step_back(self) -> None:
        self._moving.start()
        self._show()

    def _take_by_key(self, *_: object) -> None:
        self._by_key = True
        self._show()

    def _point(self) -> None:
        self._by_key = False
        faces, cursor, hovered = self.document.state.faces, self.view.cursor, self.view.hovered
        self._under = None if hovered is None else hovered.face
        if self._under is None and faces and cursor is not None:
            far_px = _MARGIN * min(face.anchor.spacing_px for face in faces)
            self._under = face_at(faces, np.array(cursor), far_px)
        self._show()

    def _show(self) -> None:
        self.view.set(pointed=self._pointed())

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


class Surroundings(Feature):
    """Updates the lines after each full result while their overlay is enabled."""

    # (): the lines of the newest full result are measured.
    seen = Signal()
    # (text: str): the lines can't be measured.
    not_seen = Signal(str)

    def __init__(self, context: Context, overlays: Overlays) -> None:
        super().__init__(context)
        self._note = ""
        self._lane = self.lane(self._show, self._fail)
        self.bind("lines-go", self.let_all_go)
        self.bind("lines-hold", self.hold_all)
        self.window.canvas.line_clicked.connect(self.toggle)
        self.view.watch(self._look, "full")
        self.document.opened.connect(self._forget)
        overlays.switches["straight"].toggled.connect(self._look)

    def toggle(self, line: BackgroundLine) -> None:
        """Toggle whether a line is kept straight, as one undo step."""
        seen = self.live.background
        if seen is None:
            return
        text = tr("Hold a line") if line.holding == "let go" else tr("Let a line go")
        self._step(seen.toggled((line.start_px, line.end_px), self.document.state.loose), text)

    def let_all_go(self) -> None:
        """Keep no line straight, including lines released before."""
        seen, loose = self.live.background, self.document.state.loose
        if seen is not None:
            more = (as_line(line) for line in seen.lines if not seen.is_loose(line, loose))
            self._step((*loose, *more), tr("Let all lines go"))

    def hold_all(self) -> None:
        """Keep every line straight, and enable the setting."""
        before = self.document.state
        if before.loose or not before.recipe.hold_background:
            state = before.with_choices(None, hold_background=True)
            self.document.step(dataclasses.replace(state, loose=()), tr("Hold all lines"))

    def _step(self, loose: tuple[Line, ...], text: str) -> None:
        if loose != self.document.state.loose:
            self.document.step(dataclasses.replace(self.document.state, loose=loose), text)

    def _look(self) -> None:
        """Start the analysis if the overlay is enabled."""
        photo, frame, finder = self.document.photo, self.view.full, self.live.finder
        self.window.bar.refresh()
        if photo is not None and frame is not None and self._wanted:
            self._lane.submit(lambda: look(photo.pixels, frame, finder))

    @property
    def _wanted(self) -> bool:
        return "straight" in self.view.visible

    def _show(self, seen: MeasuredLines) -> None:
        self.view.set(lines=seen.lines)
        if seen.note not in ("", self._note):
            self.say(sentence(seen.note), wrong=False)
        self._note = seen.note
        self.seen.emit()

    def _fail(self, problem: Exception) -> None:
        text = tr("The background can't be measured ({why}).", why=reason(problem))
        frame = self.view.full
        self.say(text, applies=lambda: self.view.full is frame and self._wanted)
        self.not_seen.emit(text)

    def _forget(self) -> None:
        self._lane.drop()
        self.view.set(lines=())


def look(photo: Image, frame: RenderedFrame, finder: BackgroundFinder) -> MeasuredLines:
    """Measure the lines of the background in a full result."""
    if not frame.done.faces:
        return MeasuredLines(())
    return measure(photo, frame.rendering, frame.done, finder)
