"""Pushes pixels with a round brush, and restores the original."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Final

import numpy as np

from kogao_core.additions.brush import BrushKind, BrushStroke, Brushwork
from kogao_core.additions.limits import OutOfBounds, check_brushwork
from kogao_core.base.geometry import Array

from ...i18n import tr
from ...view_state import ViewState
from .gesture import Gesture, PointerEvent

# Least distance between corners of a stroke, in radii and in px.
_APART: Final = 1 / 8
_APART_PX: Final = 0.5


def push(view: ViewState, event: PointerEvent, refuse: Callable[[OutOfBounds], object]) -> Gesture:
    """Draw one stroke; it is one undo step. A stroke that gets too long ends, and is refused."""
    document, path = view.document, [_corner(event)]
    document.commit()
    while not event.released:
        try:
            _preview(view, np.array(path))
        except OutOfBounds as problem:
            document.commit()
            refuse(problem)
            return
        event = yield
        apart_px = max(_APART_PX, _APART * view.brush.radius_px)
        # The last corner follows the pointer until far enough from the previous corner.
        if len(path) > 1 and np.hypot(*(path[-1] - path[-2])[:2]) < apart_px:
            path.pop()
        path.append(_corner(event))
    document.commit()


def _corner(event: PointerEvent) -> Array:
    return np.array([*event.point_px, event.pressure])


def _preview(view: ViewState, path: Array) -> None:
    document, brush = view.document, view.brush
    kind: BrushKind = "push" if brush.tool == "push" else "restore"
    if (kind == "push" and len(path) == 1) or not path[:, 2].any():
        return
    stroke = BrushStroke(
        *(kind, path[:, :2], brush.radius_px, brush.strength, brush.falloff),
        None if path[:, 2].min() == 1.0 else path[:, 2],
    )
    brushwork = Brushwork((*document.committed.brushwork.strokes, stroke))
    check_brushwork(brushwork, document.image)
    text = tr("Push") if kind == "push" else tr("Restore")
    document.preview(dataclasses.replace(document.committed, brushwork=brushwork), text)
