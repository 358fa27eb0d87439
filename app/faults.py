"""What nobody expected: said in the window, written down for us, and never the end of the work.

Qt goes on after an exception in a slot, but tells nobody; so it would vanish wherever there is no
terminal.
"""

from __future__ import annotations

import logging
import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from logging.handlers import RotatingFileHandler
from pathlib import Path
from types import TracebackType
from typing import Final

from PySide6.QtCore import QObject, Signal

from .i18n import reason

LOG: Final = logging.getLogger("kogao_app")
_LARGEST_LOG: Final = 2**20  # bytes; the one before is kept, too


class Faults(QObject):
    """Hears of every exception that nothing else has caught, in whatever thread."""

    caught = Signal(str)

    def __init__(self, log: Path) -> None:
        super().__init__()
        self._log = log
        self._print = sys.excepthook
        self._known: set[tuple[type[BaseException], str, int]] = set()

    @contextmanager
    def heard(self) -> Iterator[None]:
        """Listen inside the ``with`` block, and keep a log of this and of what workers raise."""
        before = sys.excepthook, threading.excepthook
        handler = _handler(self._log)
        if handler is not None:
            LOG.addHandler(handler)
        self._print, sys.excepthook = sys.excepthook, self._hear
        threading.excepthook = lambda it: self._hear(it.exc_type, it.exc_value, it.exc_traceback)
        try:
            yield
        finally:
            sys.excepthook, threading.excepthook = before
            if handler is not None:
                LOG.removeHandler(handler)
                handler.close()

    def _hear(
        self, kind: type[BaseException], problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        place = traceback.extract_tb(trace)[-1] if trace is not None else None
        where = (kind, place.filename, place.lineno or 0) if place else (kind, "", 0)
        # What fails while painting fails again with every picture, that of this message too.
        if where in self._known:
            return
        self._known.add(where)
        if problem is not None:
            self._print(kind, problem, trace)
        if isinstance(problem, Exception):
            LOG.error("nobody expected this", exc_info=(kind, problem, trace))
            self.caught.emit(reason(problem))


def _handler(log: Path) -> logging.Handler | None:
    try:
        log.parent.mkdir(parents=True, exist_ok=True)
        # Made when first written to.
        handler = RotatingFileHandler(
            log, maxBytes=_LARGEST_LOG, backupCount=1, encoding="utf-8", delay=True
        )
    except OSError:  # nowhere to write: stderr has to do
        return None
    handler.setFormatter(logging.Formatter("%(asctime)s %(message)s"))
    return handler
