"""Layers over the photo. Each class declares one; here they are put on top of each other."""

from __future__ import annotations

from typing import Final

from ...view_state import ViewState
from .compare import Divider
from .listed import LISTED
from .overlay import Overlay
from .protection import BrushRing
from .unlisted import Draft, FaceNumbers, FollowingBand, Names, PixelGrid, Placement

_ALWAYS: Final[tuple[type[Overlay], ...]] = (
    PixelGrid,
    FollowingBand,
    FaceNumbers,
    Draft,
    Placement,
    Names,
    Divider,
    BrushRing,
)


def stack(view: ViewState) -> list[Overlay]:
    """Return all overlays in the order in which they are drawn."""
    return [kind(view) for kind in sorted((*LISTED, *_ALWAYS), key=lambda kind: kind.height)]
