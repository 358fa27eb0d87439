"""Unexpected exceptions: shown in the window and logged, without ending the program.

Qt continues after an exception in a slot and prints only to stderr, which users may not see.
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
_LARGEST_LOG: Final = 2**20  # bytes; one older file is kept, too


class Faults(QObject):
    """Receives every uncaught exception of any thread."""

    # (why: str): an unexpected exception, which the log has in full.
    caught = Signal(str)

    def __init__(self, log: Path) -> None:
        super().__init__()
        self._log = log
        self._print = sys.excepthook
        self._known: set[tuple[type[BaseException], str, int]] = set()

    @contextmanager
    def heard(self) -> Iterator[None]:
        """Install the exception hooks and the log handler inside the ``with`` block."""
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
        # A failure while painting repeats with each repaint, including the repaint for the message.
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
        # Create the file on the first write.
        handler = RotatingFileHandler(
            log, maxBytes=_LARGEST_LOG, backupCount=1, encoding="utf-8", delay=True
        )
    except OSError:  # the folder is not writable: use stderr only
        return None
    handler.setFormatter(logging.Formatter("%(asctime)s %(message)s"))
    return handler
