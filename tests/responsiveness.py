"""Whether the window goes on while something else works."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator

from PySide6.QtCore import QTimer
from timeouts import LONGEST_S


class Responsiveness:
    """Delays work until the window has handled an event that came after the work began.

    Where the GUI thread does the work itself, or waits for it, no event is handled: after a while
    the work goes on, and its name is among the `stalled`.
    """

    def __init__(self) -> None:
        self.answered: set[str] = set()
        self.stalled: set[str] = set()
        self._beat = threading.Event()
        self._timer = QTimer(interval=1)
        self._timer.timeout.connect(self._beat.set)
        self._timer.start()

    def wait(self, name: str) -> None:
        """Wait for the window."""
        self._beat.clear()
        # Less than the window is waited for meanwhile.
        (self.answered if self._beat.wait(LONGEST_S / 2) else self.stalled).add(name)

    def delayed(self, name: str, call: Callable) -> Callable:
        """Return `call` as it is done after the window has answered."""

        def later(*args, **more):
            self.wait(name)
            return call(*args, **more)

        return later

    def delayed_items(self, name: str, call: Callable[..., Iterable]) -> Callable[..., Iterator]:
        """Return a `call` whose every item comes after the window has answered."""

        def one_by_one(*args, **more):
            for item in call(*args, **more):
                self.wait(name)
                yield item

        return one_by_one
