"""Announcements for screen readers: moves, warnings, messages and toggles."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtGui import QAction

from kogao_core.base.geometry import Array
from kogao_core.field.one_to_one import OneToOne

from ..accessibility import announce
from ..canvas import handles
from ..canvas.spoken import LEAST_PX, face_name, ways
from ..i18n import bare, tr
from ..view_state import Handle, RenderedFrame
from ..widgets.controls import WarningLabel
from .faces import Faces
from .feature import Context, Feature
from .history import History
from .points import Points
from .protect import sizes
from .recipe import RecipeEditing


class Speech(Feature):
    """Announces selections, moves with the result, and messages.

    Screen readers read the focused widget without an announcement.
    """

    def __init__(
        self,
        context: Context,
        points: Points,
        recipe: RecipeEditing,
        faces: Faces,
        history: History,
    ) -> None:
        super().__init__(context)
        self._points = points
        self._point: Handle | None = None
        # Position of the selected point at the last announcement, px of the photo.
        self._at: Array = np.zeros(2)
        # Warning labels and the last announced state.
        self._warning: dict[WarningLabel, bool] = dict.fromkeys(
            (recipe.panel.gauge.text, recipe.panel.one_to_one), False
        )
        self._faces: tuple[object, ...] = self.view.face, self.view.also
        self.view.watch(self._tell_point, "selected")
        self.view.watch(self._tell_original, "original")
        self.view.watch(self._tell_face, "face", "also")
        faces.found.connect(self._tell_found)
        history.did.connect(self._say)
        self.view.watch(self._tell_drawn, "frame")
        self.window.bar.appeared.connect(self._tell_message)

    def listen(self) -> None:
        """Announce toggled commands; call after all features have added actions."""
        for action in self.actions.values():
            if action.isCheckable():
                action.triggered.connect(partial(self._tell_switch, action))
        self.actions["delete"].triggered.connect(lambda: self._say(self.document.undo.undoText()))
        for name in ("smaller", "larger"):
            self.actions[name].triggered.connect(
                lambda: self._say(sizes().text(self.view.brush.radius_px))
            )

    def _tell_original(self) -> None:
        self._say(tr("before") if self.view.original else tr("after"))

    def _tell_face(self) -> None:
        """Announce newly selected faces."""
        before, self._faces = self._faces, (self.view.face, self.view.also)
        if self._faces == before:
            return
        face, said = self.view.face, []
        if face is None:
            said.append(tr("All faces"))
        elif not self.window.canvas.hasFocus():
            said.append(face_name(self.view, face))
        # Otherwise the next frame triggers the announcement.
        if self.live.is_final(self.view.frame):
            said += self._warnings()
        if said:
            self._say(", ".join(said))

    def _tell_found(self, count: int) -> None:
        # The message bar announces that no face was found.
        if count:
            self._say(tr("Faces found: {n}", n=count))

    def _tell_point(self) -> None:
        """Announce the newly selected point, unless the canvas announces the focus."""
        point = self.view.selected
        if point == self._point:
            return
        self._point = point
        if point is not None:
            self._at = handles.position(self.document.state, point)
            if not self.window.canvas.hasFocus():
                self._say(self._points.name_of(point))

    def _tell_drawn(self) -> None:
        """Announce moves and warnings once the full photo is rendered."""
        frame = self.view.frame
        if frame is not None and not self.document.in_gesture and self.live.is_final(frame):
            said = [*self._move(frame), *self._warnings()]
            if said:
                self._say(", ".join(said))

    def _move(self, frame: RenderedFrame) -> list[str]:
        """Return the shift of the selected point, and whether the warp folds."""
        point = self.view.selected
        if point is None or point != self._point:
            return []
        to = handles.position(self.document.state, point)
        away, self._at = to - self._at, to
        if np.abs(away).max() < LEAST_PX:
            return []
        return [self._points.name_of(point), *ways(away), _verdict(frame.figures.one_to_one)]

    def _warnings(self) -> list[str]:
        """Return warnings that appeared or disappeared since the last call."""
        said = []
        for label, before in self._warning.items():
            self._warning[label] = label.warns
            if label.warns != before:
                said.append(label.text())
        return list(filter(None, said))

    def _tell_message(self) -> None:
        """Announce the visible message and the buttons except "Dismiss"."""
        bar = self.window.bar
        steps = [bare(button.text()) for button in bar.buttons[:-1]]
        words = [tr("Buttons: {names}", names=", ".join(steps))] if steps else []
        wrong = bar.shown is not None and bar.shown.wrong
        announce(self.window.canvas, " ".join([bar.accessibleDescription(), *words]), urgent=wrong)

    def _tell_switch(self, action: QAction) -> None:
        what = bare(action.text())
        on = action.isChecked()
        self._say(tr("{what}: on", what=what) if on else tr("{what}: off", what=what))

    def _say(self, text: str) -> None:
        announce(self.window.canvas, text)


def _verdict(check: OneToOne) -> str:
    if check.folds:
        return tr("folds in {n} cells", n=len(check.folded_cells))
    return tr("no folds") if check.edges_proven and check.settled else tr("small folds possible")
