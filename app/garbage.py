"""Python's garbage is collected on the GUI thread alone.

A worker that happens to set the collector off would destroy widgets that lie in a cycle of
references, on its own thread, and that ends the program now and then.
"""

from __future__ import annotations

import gc
from typing import Final

from PySide6.QtCore import QObject, QTimer

_EVERY_MS: Final = 1000


class Collector(QObject):
    """Collects as often as Python would, but between events.

    Parameters
    ----------
    parent : QObject
        Owner, on the GUI thread.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        gc.disable()
        # What the program consists of stays anyway; looking through it again takes time.
        gc.freeze()
        self._timer = QTimer(self, interval=_EVERY_MS)
        self._timer.timeout.connect(self._collect)
        self._timer.start()

    def stop(self) -> None:
        """Leave it to Python again: no worker runs any more."""
        self._timer.stop()
        gc.unfreeze()
        gc.enable()

    def _collect(self) -> None:
        pairs = zip(gc.get_count(), gc.get_threshold(), strict=True)
        due = [level for level, (count, limit) in enumerate(pairs) if count > limit]
        if due:
            gc.collect(due[-1])
