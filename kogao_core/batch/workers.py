"""Who works on a batch: processes of this machine, or a cluster."""

from __future__ import annotations

import concurrent.futures
import dataclasses
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
from kogao_core.base.threads import keep_freed
from kogao_core.batch.tasks import Outcome, Task, work

# Photos handed out ahead of each worker: enough to keep it busy, few enough to stop at once.
_AHEAD: Final = 2
# What a cluster is given to answer, and its workers to join: tasks would wait for them for ever.
_ANSWER_S, _JOIN_S = 10.0, 8.0


class NoWorkers(Exception):
    """A cluster's scheduler has nobody to do the work."""


def _send(executor: Executor, task: Task) -> Future[Outcome]:
    return executor.submit(work, task)


def _send_afar(executor: Executor, task: Task) -> Future[Outcome]:
    """Hand a task to workers that were started in other folders; the report names it as here."""
    return executor.submit(_work_afar, task.rooted(), task.source, task.output)


def _work_afar(task: Task, source: str, output: str) -> Outcome:
    return dataclasses.replace(work(task), source=source, output=output)


class Workers:
    """Where tasks are worked on; a context manager."""

    def __init__(
        self,
        make: Callable[[], Executor],
        count: int,
        close: Callable[[], object] = lambda: None,
        send: Callable[[Executor, Task], Future[Outcome]] = _send,
    ) -> None:
        self.count = count
        self._make, self._close, self._send = make, close, send
        self._executor: Executor | None = None

    @staticmethod
    def processes(count: int) -> Workers:
        """Return workers in `count` processes of this machine, one warping thread each."""
        return Workers(
            lambda: concurrent.futures.ProcessPoolExecutor(
                count, mp_context=multiprocessing.get_context(_start()), initializer=_settle
            ),
            count,
        )

    @staticmethod
    def dask(address: str) -> Workers:
        """Return the workers of a dask.distributed cluster that sees the same files.

        Raises NoWorkers.
        """
        from distributed import Client  # an extra

        client = Client(address, timeout=_ANSWER_S)
        try:
            client.wait_for_workers(1, timeout=_JOIN_S)
        except TimeoutError:
            client.close()
            raise NoWorkers from None
        count = max(1, sum(client.nthreads().values()))
        return Workers(lambda: client.get_executor(retries=2), count, client.close, _send_afar)

    def submit(self, task: Task) -> Future[Outcome]:
        """Hand out a task."""
        for _ in range(2):
            if self._executor is None:
                self._executor = self._make()
            try:
                with _uninterrupted():
                    return self._send(self._executor, task)
            except BrokenProcessPool:
                self._executor = None
        raise RuntimeError("workers can't be started on this machine")

    def __enter__(self) -> Workers:
        """Workers start with the first task."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let running tasks end."""
        if self._executor is not None:
            self._executor.shutdown(wait=True)
            self._executor = None
        self._close()


def run(
    tasks: Iterable[Task], workers: Workers, stop: Callable[[], bool] = lambda: False
) -> Iterator[Outcome]:
    """Work on tasks and yield outcomes as they come, in no order.

    Only a few tasks are handed out at a time, so memory is bounded by the number of workers. A
    worker that dies, for want of memory say, fails the photo it was at; the others go on.
    """
    doubtful: list[Task] = []
    with workers:
        for task, outcome in _spread(tasks, workers, stop):
            if outcome is None:
                doubtful.append(task)
            else:
                yield outcome
        # A dying worker takes down all that were handed out: one by one shows which it was.
        for task in doubtful:
            if stop():
                return
            yield _result(workers.submit(task)) or Outcome(
                task.source,
                task.output,
                "failed",
                Text("the worker died at it; work on fewer at a time"),
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
    """Return what a worker made of a task; None when it died, for `work` itself never raises."""
    try:
        return future.result()
    except Exception:
        return None


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Let processes that start meanwhile see no interrupt, not even before they have settled."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start() -> Literal["fork", "spawn"]:
    """Return how a worker begins: as a copy of this process, or afresh."""
    # A copy has all modules already, which take 0.2 s. Of several threads it would have one, and
    # what the others had locked.
    is_alone = sys.platform == "linux" and len([*Path("/proc/self/task").glob("*")]) == 1
    return "fork" if is_alone else "spawn"


def _settle() -> None:
    # Photos are spread over processes already: threads inside each would only get in the way. An
    # interrupt is for the process that hands out tasks, which ends this one.
    open_standard_streams()
    keep_freed()  # the next photo is often as large as the last
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    interrupts.end_when_told(code=1)
    cv2.setNumThreads(1)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    # A program that is killed tells nobody: its workers would wait for tasks for ever.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        interrupts.clear()
        os._exit(1)
