"""Threads that help and threads that hurt; and memory that is used again."""

from __future__ import annotations

import atexit
import ctypes
import gc
import os
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from functools import cache
from typing import Final, Generic, TypeVar

import threadpoolctl

MOST_THREADS = 4
_TURN_S = 0.0005

_Task = TypeVar("_Task")
_Result = TypeVar("_Result")
_Tool = TypeVar("_Tool")


class Stopped(Exception):
    """Nobody wants any more what was under way."""


_unwanted: ContextVar[Callable[[], bool]] = ContextVar("unwanted", default=lambda: False)


@contextmanager
def stoppable(unwanted: Callable[[], bool]) -> Iterator[None]:
    """Let what is shared out in the ``with`` block be stopped. Raises Stopped."""
    before = _unwanted.set(unwanted)
    try:
        yield
    finally:
        _unwanted.reset(before)


def default_threads() -> int:
    """Return how many threads resample by default: the processors, up to 4."""
    return min(MOST_THREADS, os.cpu_count() or 1)


def share_out(
    tasks: Iterable[_Task], hand: Callable[[], Callable[[_Task], object]], threads: int
) -> None:
    """Do all tasks in this thread and, as far as they are free, in helpers of the program's pool.

    When this returns or raises, no helper works on a task any more: one that is busy is waited for,
    one that still queues behind other work is cancelled. Raises Stopped.
    """
    # Each thread takes the next task when it is done with one; a future per task costs more.
    waiting, unwanted = deque(tasks), _unwanted.get()

    def work() -> None:
        try:
            do = hand()
            while True:
                if unwanted():
                    raise Stopped
                try:
                    task = waiting.popleft()
                except IndexError:
                    return
                do(task)
        except BaseException:
            waiting.clear()  # nobody goes on with what is lost
            raise

    helpers: list[Future[None]] = []
    try:
        for _ in range(min(threads, len(waiting)) - 1):
            helpers.append(_pool(threads).submit(work))
        work()
    finally:
        problems = [None if helper.cancel() else helper.exception() for helper in helpers]
    for problem in problems:
        if problem is not None:
            raise problem


def share_in_order(
    tasks: Sequence[_Task],
    do: Callable[[_Task], _Result],
    take: Callable[[_Task, _Result], object],
    threads: int,
) -> None:
    """Share tasks out and hand each result on in the order of the tasks, one at a time."""
    lock, results, taken = threading.Lock(), dict[int, _Result](), 0

    def work(numbered: tuple[int, _Task]) -> None:
        nonlocal taken
        number, task = numbered
        result = do(task)
        with lock:
            results[number] = result
            while taken in results:
                take(tasks[taken], results.pop(taken))
                taken += 1

    share_out(enumerate(tasks), lambda: work, threads)


class Spares(Generic[_Tool]):
    """Things that only one thread may use at a time: as many as there are threads at work."""

    def __init__(self, make: Callable[[], _Tool]) -> None:
        self._make = make
        self._free: deque[_Tool] = deque()

    @contextmanager
    def one(self) -> Iterator[_Tool]:
        """Lend one to the ``with`` block, made when all others are in use."""
        try:
            tool = self._free.pop()
        except IndexError:
            tool = self._make()
        try:
            yield tool
        finally:
            self._free.append(tool)


def take_short_turns() -> None:
    """Let a thread that keeps the interpreter busy hand it over after 0.5 ms, not Python's 5.

    A window needs it for every event, a decoder for every piece of a file: 5 ms each add up. A
    photo of 25 megapixels took 2.2 s to read beside a busy thread, and takes 0.4; alone 0.2.
    """
    sys.setswitchinterval(_TURN_S)


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="kogao-warp")


def without_blas_threads() -> None:
    """Let OpenBLAS start no threads, in a program that hasn't imported numpy yet.

    They wait for work at full speed, on the processors that others need.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def one_blas_thread() -> AbstractContextManager[object]:
    """Keep BLAS to one thread inside the ``with`` block.

    Our matrices are small: a second BLAS thread costs more than it brings, and where the machine
    is busy a hundred times more, because it spins while it waits.
    """
    return _controller().limit(limits=1, user_api="blas")  # type: ignore[no-any-return]


@cache
def _controller() -> threadpoolctl.ThreadpoolController:
    return threadpoolctl.ThreadpoolController()


# Numbers of glibc's mallopt: what is free at the top stays; large pieces are no mappings of their
# own; threads share one heap, or what one of them frees would be of no use to the others.
_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
_MOST_BYTES: Final = 1 << 30


def keep_freed() -> bool:
    """Let what is freed be used again instead of going back to the system; return whether it will.

    The arrays of a photo come and go, and every page of a fresh one costs a fault. Not for a
    program that stays open: its memory would never shrink. Only glibc can be told so.
    """
    if sys.platform != "linux":
        return False
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is None:
        return False
    wanted = ((_TRIM_THRESHOLD, _MOST_BYTES), (_MMAP_THRESHOLD, _MOST_BYTES), (_ARENA_MAX, 1))
    return all(mallopt(number, value) == 1 for number, value in wanted)


def end_at_once() -> None:
    """Spare the end of the program a last look through all there is, 0.1 s for nothing."""
    atexit.register(gc.freeze)
