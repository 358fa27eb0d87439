"""Strokes of the brush, line and eraser become protection; each is one undo step."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import Final

import cv2
import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QCheckBox, QPushButton, QWidget

from kogao_core.base.geometry import Array
from kogao_core.warp.protection import NOTHING

from ..i18n import tr
from ..theme import GRID_PX
from ..view_state import Brush, ToolName
from ..widgets.controls import Fold, action_button, column_of, muted_label, row_of
from ..widgets.sliders import ValueSlider
from ..widgets.typed import SliderScale
from .feature import Context, Feature

# The first brush's radius in the photo's longer side, and that of one that pushes or restores.
_OF_PHOTO: Final = 1 / 100
_OF_PHOTO_MOVING: Final = 1 / 25
# A stroke may leave the cursor's way by this share of its radius: fewer corners, quicker fits.
_LOOSE: Final = 1 / 8
_LOOSE_PX: Final = 0.5
_STEPS_PER_OCTAVE: Final = 8
_SMALLEST_PX: Final = 1.0
_LARGEST_PX: Final = 512.0
# Four presses of a bracket key double the brush.
_PRESSES_PER_OCTAVE: Final = 4


class StrokeFeature(Feature):
    """Draws strokes of a brush over the photo; each is one undo step."""

    panel: BrushPanel

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        # Of the stroke in hand: places in px of the photo first; empty without one.
        self._path: list[tuple[float, ...]] = []

    def _draw(self, brushes: Protect) -> None:
        """Follow the mouse, and let the panel's slider size the brush."""
        self.panel.size_px.edited.connect(brushes.set_radius)
        self.panel.size_px.reset.connect(brushes.fit_brush)
        self.panel.size_px.refused.connect(self.say)
        canvas = self.window.canvas
        canvas.stroke_begun.connect(self.begin)
        canvas.stroked.connect(self.extend)
        canvas.stroke_ended.connect(self.end)
        self.document.aborted.connect(self._drop)

    def begin(self, x: float, y: float) -> None:
        """Begin a stroke at (x, y), px of the photo."""
        raise NotImplementedError

    def extend(self, x: float, y: float, straight: bool) -> None:
        """Go on to (x, y); a `straight` line is level or upright."""
        raise NotImplementedError

    def end(self) -> None:
        """Let go: the stroke is one undo step."""
        if self._path:
            self._drop()
            self.document.commit()

    def _drop(self) -> None:
        self._path = []


class Protect(StrokeFeature):
    """Paints and erases."""

    name = "protect"
    changed = Signal()

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._tools = QActionGroup(self)
        self._radii: dict[bool, float] = {}  # of the brush put away, by whether it moves
        self.add_tool("points", tr("Points"), "A", tr("Drag landmarks and targets"))
        self.add_tool("brush", tr("Brush"), "B", tr("Paint what must not move"))
        self.add_tool(
            "line", tr("Line"), "N", tr("Protect a straight edge; Shift keeps it level or upright")
        )
        self.add_tool("eraser", tr("Eraser"), "E", tr("Rub protection out"))
        self.add_action(
            "hard",
            tr("&Hard edge"),
            "Shift+B",
            tr("Not a pixel of it moves"),
            toggled=self.set_hard,
        )
        self.add_action(
            "smaller",
            tr("&Smaller brush"),
            "[",
            tr("Make brush and eraser smaller"),
            lambda: self.resize(-1),
            needs_photo=True,
        )
        self.add_action(
            "larger",
            tr("&Larger brush"),
            "]",
            tr("Make brush and eraser larger"),
            lambda: self.resize(1),
            needs_photo=True,
        )
        self.add_action(
            "unprotect",
            tr("&Remove all protection"),
            "Shift+E",
            tr("Let every place move again"),
            self.clear,
        )
        self.panel: ProtectPanel = ProtectPanel(
            self._tools.actions(), self.actions["hard"], self.actions["unprotect"]
        )
        self._draw(self)
        self.changed.connect(self.window.canvas.take_tool)
        self.changed.connect(self.window.canvas.redraw)
        self.changed.connect(self._show_tool)
        self.document.opened.connect(self.fit_brush)
        self.watch(lambda: len(self.document.state.protection.strokes), self._show_count)
        # Each photo begins with a brush that suits it.
        self.enable_with_photo(self.panel.size_px.setEnabled)

    def add_tool(self, name: ToolName, text: str, key: str, tip: str) -> QAction:
        """Add what a drag may do, one of all tools."""
        first = name == self.view.brush.tool
        tool = self.add_action(
            f"tool-{name}", text, key, tip, lambda: self.take(name), checked=first
        )
        self._tools.addAction(tool)
        return tool

    # -- the brush -------------------------------------------------------------------------------

    def take(self, tool: ToolName) -> None:
        """Take another tool in hand; those that protect and those that move have a size each."""
        before = self.view.brush
        after = dataclasses.replace(before, tool=tool)
        self._radii[before.moves] = before.radius_px
        self.set_brush(tool=tool, radius_px=self._radii.get(after.moves, before.radius_px))

    def set_radius(self, radius_px: float) -> None:
        """Make the brush this large, px of the photo."""
        self.window.bar.move_on()
        self.set_brush(radius_px=min(max(radius_px, _SMALLEST_PX), _LARGEST_PX))

    def fit_brush(self) -> None:
        """Make the brush as large as suits the photo."""
        self._drop()
        self._radii = {moves: self.fitting_px(moves=moves) for moves in (False, True)}
        self.set_radius(self._radii[self.view.brush.moves])
        self.panel.size_px.show_first(self._radii[False])

    def fitting_px(self, *, moves: bool) -> float:
        """Return how large a brush that moves, or one that protects, suits the photo, px."""
        longer = max(self.document.image.width, self.document.image.height)
        return min((_OF_PHOTO_MOVING if moves else _OF_PHOTO) * longer, _LARGEST_PX)

    def resize(self, steps: int) -> None:
        """Make the brush larger or smaller by so many presses of a key."""
        self.set_radius(self.view.brush.radius_px * 2.0 ** (steps / _PRESSES_PER_OCTAVE))

    def set_hard(self, hard: bool) -> None:
        """Choose whether the next strokes have a hard edge."""
        self.set_brush(hard=hard)

    # -- strokes ---------------------------------------------------------------------------------

    def begin(self, x: float, y: float) -> None:
        """Begin a stroke at (x, y), px of the photo."""
        if not self.view.brush.protects:
            return
        self.document.commit()
        self._path = [(x, y)]
        if self.view.brush.tool != "line":
            self._show()

    def extend(self, x: float, y: float, straight: bool) -> None:
        """Go on to (x, y); a `straight` line is level or upright."""
        if not self._path:
            return
        self.view.cursor = np.array([x, y])
        if self.view.brush.tool == "line":
            self._path = [self._path[0], _squared(self._path[0], (x, y)) if straight else (x, y)]
        else:
            self._path.append((x, y))
        self._show()

    def clear(self) -> None:
        """Take all protection away."""
        if self.document.state.protection.strokes:
            state = dataclasses.replace(self.document.state, protection=NOTHING)
            self.document.step(state, tr("Remove all protection"))

    def _show(self) -> None:
        brush, before = self.view.brush, self.document.committed.protection
        path = _smoothed(self._path, max(_LOOSE_PX, _LOOSE * brush.radius_px))
        if brush.tool == "eraser":
            protection, text = before.erased(path, brush.radius_px), tr("Erase protection")
        else:
            feather = self._feather_px() if brush.hard else 0.0
            protection, text = before.with_stroke(path, brush.radius_px, feather), tr("Protect")
        if protection.strokes != self.document.state.protection.strokes:
            state = dataclasses.replace(self.document.committed, protection=protection)
            self.document.preview(state, text)

    def _feather_px(self) -> float:
        # As wide as the landmarks are apart, it carries the move past a hard edge without folding.
        spacings = (face.anchor.spacing_px for face in self.document.state.active)
        return min(spacings, default=max(1.0, self.view.brush.radius_px))

    def set_brush(self, **changes: object) -> None:
        """Change what the tool in hand is like."""
        self.view.brush = dataclasses.replace(self.view.brush, **changes)  # type: ignore[arg-type]
        self.changed.emit()

    def _show_tool(self) -> None:
        self.panel.show_brush(self.view.brush)
        self._show_need()

    def _show_count(self) -> None:
        self.panel.show_count(len(self.document.state.protection.strokes))
        self._show_need()

    def _show_need(self) -> None:
        there = bool(self.document.state.protection.strokes)
        self.window.need(self.name, there or self.view.brush.protects)


def _smoothed(path: list[tuple[float, ...]], loose_px: float) -> Array:
    points = np.array(path, np.float32)[:, None]
    if len(points) < 3:
        return np.asarray(points[:, 0], np.float64)
    return np.asarray(cv2.approxPolyDP(points, loose_px, closed=False)[:, 0], np.float64)


def _squared(start: tuple[float, ...], end: tuple[float, float]) -> tuple[float, float]:
    """Return `end` moved so that the line to it is level or upright, whichever is nearer."""
    level = abs(end[0] - start[0]) >= abs(end[1] - start[1])
    return (end[0], start[1]) if level else (start[0], end[1])


class BrushPanel(QWidget):
    """A fold of tools, what the brush is like, and a way to take all strokes back."""

    def __init__(
        self,
        title: str,
        tools: Iterable[QAction],
        size_px: ValueSlider,
        controls: Iterable[QWidget],
        clear: tuple[QPushButton, QAction],
        nothing: str,
    ) -> None:
        super().__init__()
        self.size_px, self.count, self._nothing = size_px, muted_label(), nothing
        self.clear, action = clear
        self.clear.clicked.connect(action.trigger)
        body = QWidget()
        self.fold = Fold(title, body)
        column_of(self, self.fold)
        buttons = row_of(*map(action_button, tools), spacing=GRID_PX)
        for place in range(buttons.count()):
            buttons.setStretch(place, 1)
        below = row_of(self.count, None, self.clear)
        column_of(body, buttons, size_px, *controls, below, spacing=2 * GRID_PX)

    def show_count(self, strokes: int) -> None:
        """Show how many strokes there are."""
        self.count.setText(tr("Strokes: {n}", n=strokes) if strokes else self._nothing)
        self.clear.setEnabled(strokes > 0)


class ProtectPanel(BrushPanel):
    """Tools, size, edge, and a way to remove everything."""

    def __init__(self, tools: Iterable[QAction], hard: QAction, clear: QAction) -> None:
        tip = tr("Width of brush, line and eraser in px of the photo; [ and ] change it")
        size_px = ValueSlider(tr("Brush si&ze"), sizes(), tip, 0)
        self.hard = QCheckBox(tr("Hard edge: not a pixel of it moves"))
        self.hard.setToolTip(tr("The move fades out beside the stroke and is nothing on it"))
        self.hard.toggled.connect(hard.setChecked)
        hard.toggled.connect(self.hard.setChecked)
        remove = QPushButton(tr("Remove all"))
        remove.setAccessibleName(tr("Remove all protection"))
        remove.setToolTip(tr("Let everything that was painted or drawn move again"))
        nothing = tr("Nothing is protected")
        super().__init__(tr("Protect"), tools, size_px, [self.hard], (remove, clear), nothing)

    def show_brush(self, brush: Brush) -> None:
        """Show how large the tool in hand is, and unfold for one that paints."""
        if brush.protects:
            self.fold.button.setChecked(True)
        self.size_px.show_value(brush.radius_px)


def sizes() -> SliderScale:
    """How wide a brush may be."""
    low, high = (round(_STEPS_PER_OCTAVE * math.log2(px)) for px in (_SMALLEST_PX, _LARGEST_PX))
    return SliderScale(
        low,
        high,
        _STEPS_PER_OCTAVE,
        lambda n: 2.0 ** (n / _STEPS_PER_OCTAVE),
        lambda v: round(_STEPS_PER_OCTAVE * math.log2(v)),
        lambda v: tr("{v:.0f} px across", v=2 * v),
        lambda px: round(px) / 2,
    )
