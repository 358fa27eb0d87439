"""Strokes of the brush, line and eraser become protection; each is one undo step."""

from __future__ import annotations

import dataclasses
from typing import Final

import cv2
import numpy as np
from PySide6.QtCore import QObject, Signal

from kogao_core.geometry import Array
from kogao_core.protection import NOTHING, Protection

from ..document import Document, State
from ..i18n import tr
from ..scene import Scene
from ..tools import LARGEST_PX, PER_OCTAVE, SMALLEST_PX, ToolName
from .editing import Editing

_OF_PHOTO: Final = 1 / 100  # the first brush's radius in the photo's longer side
# A stroke may leave the cursor's way by this share of its radius: fewer corners, quicker fits.
_LOOSE: Final = 1 / 8
_LOOSE_PX: Final = 0.5
# A feather as wide as the landmarks are apart carries the move past a hard edge without folding.
_FEATHER_SPACINGS: Final = 1.0


class Protecting(QObject):
    """Paints and erases.

    Signals
    -------
    changed
        Another tool, size or edge, as `Scene.brush` says.
    restyled
        The overlays need drawing.
    """

    changed = Signal()
    restyled = Signal()

    def __init__(
        self, document: Document, scene: Scene, editing: Editing, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._document, self._scene, self._editing = document, scene, editing
        self._before: State | None = None
        self._way: list[tuple[float, float]] = []
        document.opened.connect(self.fit_brush)
        editing.aborted.connect(self._drop)

    # -- the brush -------------------------------------------------------------------------------

    def take(self, tool: ToolName) -> None:
        """Take another tool in hand."""
        self._set(tool=tool)

    def set_radius(self, radius_px: float) -> None:
        """Make the brush this large, px of the photo."""
        self._set(radius_px=min(max(radius_px, SMALLEST_PX), LARGEST_PX))

    def fit_brush(self) -> None:
        """Make the brush as large as suits the photo."""
        self._drop()
        image = self._document.image
        self.set_radius(_OF_PHOTO * max(image.width, image.height))

    def resize(self, steps: int) -> None:
        """Make the brush larger or smaller by so many presses of a key."""
        self.set_radius(self._scene.brush.radius_px * 2.0 ** (steps / PER_OCTAVE))

    def set_hard(self, hard: bool) -> None:
        """Choose whether the next strokes have a hard edge."""
        self._set(hard=hard)

    # -- strokes ---------------------------------------------------------------------------------

    def begin(self, x: float, y: float) -> None:
        """Begin a stroke at (x, y), px of the photo."""
        self._editing.commit()
        self._before, self._way = self._document.state, [(x, y)]
        if self._scene.brush.tool != "line":
            self._show()

    def extend(self, x: float, y: float, straight: bool) -> None:
        """Go on to (x, y); a `straight` line is level or upright."""
        if self._before is None:
            return
        self._scene.cursor = np.array([x, y])
        if self._scene.brush.tool == "line":
            self._way = [self._way[0], _squared(self._way[0], (x, y)) if straight else (x, y)]
        else:
            self._way.append((x, y))
        self._show()

    def end(self) -> None:
        """Let go: the stroke is one undo step."""
        if self._before is not None:
            self._drop()
            self._editing.commit()

    def clear(self) -> None:
        """Take all protection away."""
        if self._document.state.protection.strokes:
            self._step(NOTHING, tr("Remove all protection"))

    def _step(self, protection: Protection, text: str) -> None:
        self._editing.step(dataclasses.replace(self._document.state, protection=protection), text)

    def _show(self) -> None:
        if self._before is None:
            return
        brush, before = self._scene.brush, self._before.protection
        way = _smoothed(self._way, max(_LOOSE_PX, _LOOSE * brush.radius_px))
        if brush.tool == "eraser":
            protection, text = before.erased(way, brush.radius_px), tr("Erase protection")
        else:
            feather = self._feather_px() if brush.hard else 0.0
            protection, text = before.with_stroke(way, brush.radius_px, feather), tr("Protect")
        if protection.strokes != self._document.state.protection.strokes:
            state = dataclasses.replace(self._before, protection=protection)
            self._editing.preview(state, text)

    def _feather_px(self) -> float:
        spacings = [face.anchor.spacing_px for face in self._document.state.active]
        return _FEATHER_SPACINGS * (
            min(spacings) if spacings else max(1.0, self._scene.brush.radius_px)
        )

    def _set(self, **changes: object) -> None:
        self._scene.brush = dataclasses.replace(self._scene.brush, **changes)  # type: ignore[arg-type]
        self.changed.emit()
        self.restyled.emit()

    def _drop(self) -> None:
        self._before, self._way = None, []


def _smoothed(way: list[tuple[float, float]], loose_px: float) -> Array:
    points = np.array(way, np.float32)[:, None]
    if len(points) < 3:
        return np.asarray(points[:, 0], np.float64)
    return np.asarray(cv2.approxPolyDP(points, loose_px, closed=False)[:, 0], np.float64)


def _squared(start: tuple[float, float], end: tuple[float, float]) -> tuple[float, float]:
    """Return `end` moved so that the line to it is level or upright, whichever is nearer."""
    level = abs(end[0] - start[0]) >= abs(end[1] - start[1])
    return (end[0], start[1]) if level else (start[0], end[1])
