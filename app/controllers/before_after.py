"""Which way the photo before and after is compared."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from ..before_after import CompareName
from ..scene import Scene


class BeforeAfter(QObject):
    """Writes the way to compare into the scene.

    Signals
    -------
    changed
        The canvas needs drawing.
    """

    changed = Signal()

    def __init__(self, scene: Scene, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._scene = scene

    def toggle(self, name: CompareName, on: bool) -> None:
        """Compare this way, or no longer."""
        if on:
            self._scene.compare = name
        elif self._scene.compare == name:
            self._scene.compare = "off"
        self.changed.emit()

    def wipe_to(self, share: float) -> None:
        """Put the divider at this share of the canvas's width."""
        self._scene.wipe = min(max(share, 0.0), 1.0)
        self.changed.emit()

    def wipe_by(self, share: float) -> None:
        """Move the divider, as the keys do."""
        if self._scene.compare == "wipe":
            self.wipe_to(self._scene.wipe + share)

    def use_loupe(self, on: bool) -> None:
        """Magnify what lies under the cursor."""
        self._scene.loupe = on
        self.changed.emit()
