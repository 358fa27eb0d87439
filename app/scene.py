"""What is on screen: read by the canvas and its overlays, written by the controllers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from kogao_core.geometry import Box

from .document import State
from .points import Handle
from .surfaces import Frame

NOWHERE: Final = Box(0, 0, 0, 0)


@dataclass
class Scene:
    """The state to draw and how.

    Parameters
    ----------
    state : State
        Faces and recipe, a gesture's preview included.
    image : Box
        The photo's rectangle.
    frame : Frame, optional
        The newest rendering; it may lag behind `state` by one.
    visible : set of str
        Names of the overlays switched on.
    original : bool
        True while the photo is shown as it was.
    hovered, selected : Handle, optional
        The point under the cursor, and the one that the arrow keys move.
    placing : int, optional
        The face that is being placed as a whole.
    """

    state: State = field(default_factory=State)
    image: Box = NOWHERE
    frame: Frame | None = None
    visible: set[str] = field(default_factory=set)
    original: bool = False
    hovered: Handle | None = None
    selected: Handle | None = None
    placing: int | None = None
