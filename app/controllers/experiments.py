"""Runs one experiment at a time on a worker, with its progress, until it is done or stopped."""

from __future__ import annotations

import threading

from PySide6.QtCore import QObject, QThreadPool, Signal

from ..experiments import ExperimentName, Task, run
from ..workers import Lane


class _Stopped(Exception):
    """The user has seen enough."""


class Experiments(QObject):
    """The worker's side of the Experiments menu.

    Signals
    -------
    told(int, int)
        So many runs are done, of so many.
    done(Outcome)
        It ended by itself.
    failed(Exception)
        It couldn't be done.
    """

    told = Signal(int, int)
    done = Signal(object)
    failed = Signal(object)

    def __init__(self, pool: QThreadPool, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._enough = threading.Event()
        self._lane = Lane(pool, self._fail, self)
        self._lane.done.connect(self.done)

    @property
    def busy(self) -> bool:
        """True while one runs."""
        return self._lane.busy

    def start(self, name: ExperimentName, task: Task) -> None:
        """Run an experiment in place of one under way."""
        self.stop()
        self._enough = enough = threading.Event()

        def tell(done: int, of: int) -> None:
            if enough.is_set():
                raise _Stopped
            self.told.emit(done, of)

        self._lane.submit(lambda: run(name, task, tell))

    def stop(self) -> None:
        """End the one under way after its current run; nothing comes of it."""
        self._enough.set()
        self._lane.drop()

    def _fail(self, problem: Exception) -> None:
        if not isinstance(problem, _Stopped):
            self.failed.emit(problem)
