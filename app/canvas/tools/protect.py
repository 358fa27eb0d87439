"""Paints, draws and erases protection."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.field.protection import Protection, Stroke, distance_px

from ...i18n import tr
from ...view_state import ViewState
from .gesture import Gesture, PointerEvent

# Simplification tolerance of a stroke as a fraction of the radius: fewer corners, faster fits.
_LOOSE: Final = 1 / 8
_LOOSE_PX: Final = 0.5
# A line and the numbers of its ends that move.
Grip = tuple[Stroke, list[int]]


def protect(view: ViewState, event: PointerEvent) -> Gesture:
    """Draw one stroke with brush, line or eraser; it is one undo step."""
    document, is_line = view.document, view.brush.tool == "line"
    document.commit()
    path = [event.point_px]
    while not event.released:
        if not is_line or len(path) > 1:
            _preview(view, np.array(path))
        event = yield
        if is_line:
            path = [
                path[0],
                _squared(path[0], event.point_px) if event.straight else event.point_px,
            ]
        else:
            path.append(event.point_px)
    document.commit()


def line_at(protection: Protection, point_px: Array, reach_px: float) -> Grip | None:
    """Return the newest line within reach of (x, y), px, and the numbers of the ends to move."""
    for stroke in reversed(protection.drawn):
        ends, reach = stroke.points_px, max(stroke.radius_px, reach_px)
        if len(ends) == 2 and distance_px(point_px[None], ends)[0] <= reach:
            apart = np.hypot(*(ends - point_px).T)
            return stroke, [int(apart.argmin())] if apart.min() <= reach_px else [0, 1]
    return None


def move_line(
    view: ViewState, grip: Grip, event: PointerEvent, moved: Callable[[Stroke], object]
) -> Gesture:
    """Move one end of a line, or all of it; it is one undo step."""
    document, (line, ends), start = view.document, grip, event.point_px
    document.commit()
    while not event.released:
        if (event.point_px != start).any():
            points = line.points_px.copy()
            points[ends] += event.point_px - start
            if event.straight and len(ends) == 1:
                points[ends] = _squared(points[1 - ends[0]], points[ends[0]])
            new = dataclasses.replace(line, points_px=points)
            protection = document.committed.protection.replaced(line, new)
            state = dataclasses.replace(document.committed, protection=protection)
            document.preview(state, tr("Move a line"))
            moved(new)
        event = yield
    document.commit()


def _preview(view: ViewState, path: Array) -> None:
    document, brush = view.document, view.brush
    before = document.committed.protection
    path = _smoothed(path, max(_LOOSE_PX, _LOOSE * brush.radius_px))
    if brush.tool == "eraser":
        protection, text = before.erased(path, brush.radius_px), tr("Erase protection")
    else:
        protection, text = before.with_stroke(path, brush.radius_px), tr("Protect")
    if protection.strokes != document.state.protection.strokes:
        state = dataclasses.replace(document.committed, protection=protection)
        document.preview(state, text)


def _smoothed(path: Array, loose_px: float) -> Array:
    if len(path) < 3:
        return path
    corners = path.astype(np.float32)[:, None]
    return np.asarray(cv2.approxPolyDP(corners, loose_px, closed=False)[:, 0], np.float64)


def _squared(start: Array, end: Array) -> Array:
    """Return `end` moved so that the line is horizontal or vertical, the nearer of both."""
    level = abs(end[0] - start[0]) >= abs(end[1] - start[1])
    return np.array([end[0], start[1]] if level else [start[0], end[1]])
