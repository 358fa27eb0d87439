"""Background jobs: each lane runs one job at a time and keeps only the newest request."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, QThreadPool, Signal

from .faults import LOG

Job = Callable[[], Any]


class Lane(QObject):
    """A queue of length one.

    A request that arrives while a job runs replaces the waiting request. The next job starts
    only after the listeners of `done` have returned. So a job may overwrite the buffer of the
    last result but one.
    """

    # (result: object): a job has ended; not after `drop`.
    done = Signal(object)
    # (generation: int, result: object, error: Exception or None): from a worker.
    _returned = Signal(int, object, object)

    def __init__(
        self,
        pool: QThreadPool,
        failed: Callable[[Exception], object],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._pool, self._failed = pool, failed
        self._waiting: Job | None = None
        self._running = False
        self._generation = 0
        self._returned.connect(self._settle)

    @property
    def busy(self) -> bool:
        """True while a job runs or waits, or a result is delivered."""
        return self._running or self._waiting is not None

    def submit(self, job: Job) -> None:
        """Run `job` next; replace a waiting job."""
        self._waiting = job
        self._start_next()

    def drop(self) -> None:
        """Discard the waiting job and the result of the running job."""
        self._generation += 1
        self._waiting = None

    def _start_next(self) -> None:
        if self._running or self._waiting is None:
            return
        job, self._waiting = self._waiting, None
        self._running = True
        generation = self._generation
        self._pool.start(lambda: self._run(generation, job))

    def _run(self, generation: int, job: Job) -> None:
        result, error = None, None
        try:
            result = job()
        # An exception in a pool thread would end the program. Pass exceptions to `failed` instead.
        except Exception as problem:
            error = problem
        self._returned.emit(generation, result, error)

    def _settle(self, generation: int, result: object, error: Exception | None) -> None:
        try:
            if generation != self._generation:
                return
            if error is None:
                self.done.emit(result)
            else:
                LOG.warning("%s: a job failed", type(self.parent()).__name__, exc_info=error)
                self._failed(error)
        finally:
            self._running = False
            self._start_next()
