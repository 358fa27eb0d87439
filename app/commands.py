"""Undo steps. A gesture previews many times and commits once; a step holds whole states."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtGui import QUndoCommand

if TYPE_CHECKING:
    from .document import State


class ReplaceState(QUndoCommand):
    """Put one state in place of another.

    Parameters
    ----------
    restore : callable
        Takes the state to show.
    before, after : State
        Around the gesture.
    text : str
        What the gesture did, as the Edit menu names it.
    """

    def __init__(
        self, restore: Callable[[State], None], before: State, after: State, text: str
    ) -> None:
        super().__init__(text)
        self._restore, self._before, self._after = restore, before, after

    def redo(self) -> None:
        """Show the later state."""
        self._restore(self._after)

    def undo(self) -> None:
        """Show the earlier state."""
        self._restore(self._before)
