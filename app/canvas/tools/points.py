"""Drags points of a face, or the frame around a face that is placed by hand."""

from __future__ import annotations

import numpy as np

from kogao_core.additions.limits import OutOfBounds, check_faces
from kogao_core.base.geometry import Array

from ...document import Document, State
from ...i18n import tr
from ...view_state import Handle, ViewState
from .. import handles
from .gesture import Gesture, PointerEvent


def drag(
    view: ViewState, handle: Handle, offset_px: Array, event: PointerEvent | None = None
) -> Gesture:
    """Move a handle with the pointer, at a constant offset of shape (2,), px of the photo.

    `event`: the first move; by default the next event.
    """
    document = view.document
    event = event or (yield)
    while not event.released:
        if handle.movable:
            before = document.committed
            start, to = handles.position(before, handle), event.point_px + offset_px
            moved = handles.moved(before, handle, start, to, view.following)
            preview(document, handle, moved)
        event = yield
    document.commit()


def preview(document: Document, handle: Handle, moved: State) -> None:
    """Preview a moved handle; ignore moves far out of the photo."""
    try:
        check_faces([moved.faces[handle.face]], document.image)
    except OutOfBounds:
        return
    away = handles.position(moved, handle) - handles.position(document.committed, handle)
    px = tr("{px:.1f} px", px=float(np.hypot(*away)))
    document.preview(moved, name_of(document, handle), px)


def name_of(document: Document, handle: Handle) -> str:
    """Return the name of a point."""
    return handles.name(handle, len(document.state.faces[handle.face].outline))
