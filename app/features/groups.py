"""Groups: switch faces on and off, zoom to faces, and the menu of a face."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

from PySide6.QtCore import QPoint, QRectF, Qt
from PySide6.QtWidgets import QMenu

from kogao_core.faces.face import Face

from ..i18n import tr
from .faces import Faces
from .feature import Context, Feature
from .recipe import RecipeEditing

# Margin around a face for zooming, as a fraction of the longer side: shows hair and neck.
_MARGIN = 0.75
_OF_ONE = ("only-face", "switch-face")
_OF_ALL = ("all-faces", "no-face", "invert-faces")


class Groups(Feature):
    """Switches faces on and off, zooms to faces, and shows the menu of a face."""

    def __init__(self, context: Context, recipe: RecipeEditing, faces: Faces) -> None:
        super().__init__(context)
        self._recipe = recipe
        self.bind("only-face", lambda: self._keep({self._face}))
        self.bind("switch-face", lambda: self._keep(self._on ^ {self._face}))
        self.bind("all-faces", lambda: self._keep(self._every))
        self.bind("no-face", lambda: self._keep(()))
        self.bind("invert-faces", lambda: self._keep(self._every - self._on))
        self.bind("zoom-face", self.zoom)
        self.menu: QMenu = QMenu(tr("Face"), self.window)
        self.menu.setAccessibleName(tr("Face"))
        names = (*_OF_ONE, None, *_OF_ALL, None, "zoom-face", "follow-photo")
        for name in names:
            if name is None:
                self.menu.addSeparator()
            else:
                self.menu.addAction(self.actions[name])
        self.window.canvas.menu_wanted.connect(self._offer)
        rows = faces.panel.list
        rows.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        # The right click has already selected the row.
        rows.customContextMenuRequested.connect(
            lambda at: self.menu.popup(rows.viewport().mapToGlobal(at))
        )
        rows.itemDoubleClicked.connect(self.zoom)
        faces.panel.chosen.connect(lambda _: self._bring_into_view())
        self.view.watch(self._enable, "face")
        self.document.watch(self._enable, "faces", value=lambda: len(self.document.state.faces))

    def zoom(self) -> None:
        """Zoom to the selected face, or to all faces without a selection."""
        faces, chosen = self.document.state.faces, self._face
        if faces:
            self.window.canvas.look_at(_round(faces if chosen is None else [faces[chosen]]))

    def _bring_into_view(self) -> None:
        face, canvas = self.view.face, self.window.canvas
        if face is not None:
            middle = canvas.to_screen(self.document.state.faces[face].middle).toPoint()
            if not canvas.viewport().rect().contains(middle):
                self.zoom()

    def _offer(self, face: int, at: QPoint) -> None:
        """Select a face and open the menu at a position on the screen."""
        self._recipe.choose(face)
        self.menu.popup(at)

    @property
    def _face(self) -> int | None:
        alone = len(self.document.state.faces) == 1
        return 0 if alone else self.view.face

    @property
    def _every(self) -> frozenset[int]:
        return frozenset(range(len(self.document.state.faces)))

    @property
    def _on(self) -> frozenset[int]:
        return self._every - self.document.state.off

    def _keep(self, on: Iterable[int | None]) -> None:
        """Switch these faces on and all other faces off, as one undo step if anything changes."""
        state = self.document.state
        off = self._every - frozenset(on)
        if off != state.off:
            self.document.step(dataclasses.replace(state, off=off), tr("Switch faces"))

    def _enable(self) -> None:
        any_face = bool(self.document.state.faces)
        for name in (*_OF_ALL, "zoom-face"):
            self.actions[name].setEnabled(any_face)
        for name in _OF_ONE:
            self.actions[name].setEnabled(self._face is not None)


def _round(faces: Iterable[Face]) -> QRectF:
    """Return the rectangle of the photo that contains these faces with a margin, px."""
    area = QRectF()
    for face in faces:
        left, top, width, height = face.box
        margin = _MARGIN * max(width, height)
        area |= QRectF(left, top, width, height).adjusted(-margin, -margin, margin, margin)
    return area
