"""A gesture: one generator from the press to the release."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass

from kogao_core.base.geometry import Array

from ...view_state import Handle


@dataclass(frozen=True, slots=True, eq=False)
class PointerEvent:
    """A press, a move or the release of the pointer."""

    point_px: Array  # (2,): position (x, y), px of the photo
    straight: bool = False  # whether a line becomes horizontal or vertical
    pressure: float = 1.0  # of the pen, 0 to 1
    released: bool = False  # whether the gesture ends


# Previews a state of the document at each event and commits after the release. A gesture that is
# aborted receives no further event. The committed state may change meanwhile: faces that are found
# late are added to every state.
Gesture = Generator[None, PointerEvent, None]
# Begins a gesture at a press on a handle, or beside all handles.
Tool = Callable[[Handle | None, PointerEvent], Gesture]
