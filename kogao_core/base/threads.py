"""Run work in threads, limit the threads of libraries, and reuse freed memory."""

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
    """The caller cancelled the work."""


_unwanted: ContextVar[Callable[[], bool]] = ContextVar("unwanted", default=lambda: False)


@contextmanager
def stoppable(unwanted: Callable[[], bool]) -> Iterator[None]:
    """Cancel `parallel_for` in the ``with`` block as soon as `unwanted` is true. Raises Stopped."""
    before = _unwanted.set(unwanted)
    try:
        yield
    finally:
        _unwanted.reset(before)


def default_threads() -> int:
    """Return the default number of resampling threads: the number of processors, at most 4."""
    return min(MOST_THREADS, os.cpu_count() or 1)


def parallel_for(
    tasks: Iterable[_Task], hand: Callable[[], Callable[[_Task], object]], threads: int
) -> None:
    """Run all tasks in this thread and in idle threads of the shared pool.

    Before returning or raising, wait for busy helpers and cancel queued helpers. Raises Stopped.
    """
    # Each thread takes the next task from a queue: one future per task would cost more.
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
            waiting.clear()  # drop the remaining tasks: the call fails anyway
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


def parallel_in_order(
    tasks: Sequence[_Task],
    do: Callable[[_Task], _Result],
    take: Callable[[_Task, _Result], object],
    threads: int,
) -> None:
    """Run tasks in parallel; call `take` with each result, one at a time, in task order."""
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

    parallel_for(enumerate(tasks), lambda: work, threads)


def parallel_map(do: Callable[[_Task], _Result], tasks: Sequence[_Task]) -> list[_Result]:
    """Return the results of `do`, which threads compute, in task order."""
    results: list[_Result] = []
    parallel_in_order(tasks, do, lambda _, result: results.append(result), default_threads())
    return results


class ObjectPool(Generic[_Tool]):
    """A pool of objects that are not thread-safe. Each concurrent user borrows a separate one."""

    def __init__(self, make: Callable[[], _Tool]) -> None:
        self._make = make
        self._free: deque[_Tool] = deque()

    @contextmanager
    def one(self) -> Iterator[_Tool]:
        """Borrow an object for the ``with`` block; create one if all others are in use."""
        try:
            tool = self._free.pop()
        except IndexError:
            tool = self._make()
        try:
            yield tool
        finally:
            self._free.append(tool)


def shorten_switch_interval() -> None:
    """Set Python's thread switch interval to 0.5 ms instead of 5 ms.

    A window waits for the interpreter lock at every event, and a decoder at every chunk of a file.
    While another thread is busy, reading 25 megapixels takes 0.4 s instead of 2.2 s; alone 0.2 s.
    """
    sys.setswitchinterval(_TURN_S)


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="kogao-warp")


def without_blas_threads() -> None:
    """Disable OpenBLAS threads. Call this before numpy is imported.

    Idle OpenBLAS threads spin on processors that other threads need.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def one_blas_thread() -> AbstractContextManager[object]:
    """Keep BLAS to one thread inside the ``with`` block.

    Our matrices are small: a second BLAS thread takes more time than it saves. On a busy machine
    it takes a hundred times more, because it spins while it waits.
    """
    return _controller().limit(limits=1, user_api="blas")  # type: ignore[no-any-return]


@cache
def _controller() -> threadpoolctl.ThreadpoolController:
    return threadpoolctl.ThreadpoolController()


# Parameters of glibc's mallopt: keep free memory at the top of the heap, don't use mmap for large
# blocks, and share one heap between threads, so that every thread can reuse freed memory.
_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
_MOST_BYTES: Final = 1 << 30


def reuse_freed_memory() -> bool:
    """Keep freed memory in the process for reuse. Return whether the C library agreed.

    Each page of a new array costs a page fault. Don't use this in a program that stays open: its
    memory would never shrink. Works with glibc only.
    """
    mallopt = getattr(_c_library(), "mallopt", None)
    if mallopt is None:
        return False
    wanted = ((_TRIM_THRESHOLD, _MOST_BYTES), (_MMAP_THRESHOLD, _MOST_BYTES), (_ARENA_MAX, 1))
    return all(mallopt(number, value) == 1 for number, value in wanted)


def give_back_freed_memory() -> None:
    """Return freed memory to the system, which glibc keeps; 30 ms for 100 MB."""
    if (trim := getattr(_c_library(), "malloc_trim", None)) is not None:
        trim(0)


def _c_library() -> ctypes.CDLL | None:
    return ctypes.CDLL(None) if sys.platform == "linux" else None


def skip_final_collection() -> None:
    """Skip the final garbage collection at exit, which takes 0.1 s."""
    atexit.register(gc.freeze)
