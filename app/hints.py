"""What the tool in hand does, in one line."""

from __future__ import annotations

from . import marking
from .i18n import tr
from .scene import Scene
from .tools import tools


def hint(scene: Scene) -> str:
    """Return what the mouse does now; empty where it can only move the photo."""
    if scene.brush.paints:
        return next(tool.tip for tool in tools() if tool.name == scene.brush.tool)
    if scene.marking:
        return marking.next_hint(scene.state)
    if not scene.state.faces:
        return ""
    if scene.placing is not None:
        return tr("Drag the frame onto the face; a corner turns and sizes it")
    if len(scene.state.faces) > 1 and scene.face is None:
        return tr("Click a face to select it; drag to move the photo")
    return tr("Drag a point to correct it")
