"""Run the tasks of a batch in worker processes."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path
from typing import Final, Literal

import cv2

from kogao_core.base import interrupts
from kogao_core.base.language import Text
from kogao_core.base.stderr import open_standard_streams
from kogao_core.base.threads import reuse_freed_memory
from kogao_core.batch.tasks import Outcome, Task, work

# Tasks submitted per worker: enough to keep the worker busy, few enough to stop quickly.
_AHEAD: Final = 2


class Workers:
    """A pool of worker processes, as a context manager. `make` starts the executor."""

    def __init__(self, make: Callable[[], Executor], count: int) -> None:
        self.count = count
        self._make = make
        self._executor: Executor | None = None

    @staticmethod
    def processes(count: int) -> Workers:
        """Return a pool of `count` processes that warp with one thread each."""
        return Workers(
            lambda: concurrent.futures.ProcessPoolExecutor(
                count, mp_context=multiprocessing.get_context(_start()), initializer=_settle
            ),
            count,
        )

    def submit(self, task: Task) -> Future[Outcome]:
        """Submit a task; start new processes if the pool is broken."""
        for _ in range(2):
            if self._executor is None:
                self._executor = self._make()
            try:
                with _uninterrupted():
                    return self._executor.submit(work, task)
            except BrokenProcessPool:
                self._executor = None
        raise RuntimeError("workers can't be started on this machine")

    def __enter__(self) -> Workers:
        """Return the pool. Processes start with the first task."""
        return self

    def __exit__(self, *_: object) -> None:
        """Wait for running tasks and end the processes."""
        if self._executor is not None:
            self._executor.shutdown(wait=True)
            self._executor = None


def run(
    tasks: Iterable[Task], workers: Workers, stop: Callable[[], bool] = lambda: False
) -> Iterator[Outcome]:
    """Run tasks and yield outcomes in order of completion.

    Only a few tasks are submitted at a time, so the number of workers limits the memory. If a
    worker process dies, its photo fails and the other photos continue.
    """
    doubtful: list[Task] = []
    with workers:
        for task, outcome in _spread(tasks, workers, stop):
            if outcome is None:
                doubtful.append(task)
            else:
                yield outcome
        # A crashed worker fails every submitted task. Retry one task at a time to find the cause.
        for task in doubtful:
            if stop():
                return
            yield _result(workers.submit(task)) or Outcome(
                task.source,
                task.output,
                "failed",
                reason=Text("the worker process died; run fewer photos at a time"),
            )


def _spread(
    tasks: Iterable[Task], workers: Workers, stop: Callable[[], bool]
) -> Iterator[tuple[Task, Outcome | None]]:
    waiting = iter(tasks)
    running: dict[Future[Outcome], Task] = {}
    try:
        while True:
            while len(running) < workers.count * _AHEAD and not stop():
                task = next(waiting, None)
                if task is None:
                    break
                running[workers.submit(task)] = task
            if not running:
                return
            first = concurrent.futures.FIRST_COMPLETED
            for future in concurrent.futures.wait(running, return_when=first).done:
                yield running.pop(future), _result(future)
    finally:
        for future in running:
            future.cancel()


def _result(future: Future[Outcome]) -> Outcome | None:
    """Return the outcome of a task; None if the worker process died (`work` never raises)."""
    try:
        return future.result()
    except Exception:
        return None


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Block SIGINT, so that new processes start with the signal blocked. No effect on Windows."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start() -> Literal["fork", "spawn"]:
    """Return the start method of worker processes."""
    # fork saves 0.2 s of imports. A forked process has only one thread, so locks that other
    # threads hold would stay locked.
    is_alone = sys.platform == "linux" and len([*Path("/proc/self/task").glob("*")]) == 1
    return "fork" if is_alone else "spawn"


def _settle() -> None:
    # Processes already use all cores, so disable threads inside each. Ignore SIGINT: the parent
    # process handles the interrupt and ends the workers.
    open_standard_streams()
    reuse_freed_memory()  # the next photo often has the same size
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    interrupts.exit_on_signals(code=1)
    cv2.setNumThreads(1)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    # Without this, workers of a killed parent would wait for tasks forever.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        interrupts.clear()
        os._exit(1)
