"""Threads that help and threads that hurt."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any, Final

import threadpoolctl

MOST_THREADS = 4


def default_threads() -> int:
    """Return how many threads resample when nobody says: the processors, up to 4."""
    return min(MOST_THREADS, os.cpu_count() or 1)


@cache
def pool(threads: int) -> ThreadPoolExecutor:
    """Return the program's own pool of that size."""
    return ThreadPoolExecutor(threads, thread_name_prefix="kogao-warp")


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep BLAS to one thread inside the ``with`` block.

    Our matrices are small: a second BLAS thread costs more than it brings, and where the machine
    is busy a hundred times more, because it spins while it waits. It also rounds otherwise, which
    can change a pixel. The limit is the whole program's, so blocks that overlap in several threads
    share it: the first sets it, the last lifts it.
    """
    _LIMIT.enter()
    try:
        yield
    finally:
        _LIMIT.leave()


class _SharedLimit:
    def __init__(self) -> None:
        self._lock = Lock()
        self._users = 0
        self._limit: Any = None

    def enter(self) -> None:
        with self._lock:
            if self._users == 0:
                self._limit = _controller().limit(limits=1, user_api="blas")
            self._users += 1

    def leave(self) -> None:
        with self._lock:
            self._users -= 1
            if self._users == 0:
                self._limit.restore_original_limits()


_LIMIT: Final = _SharedLimit()


@cache
def _controller() -> threadpoolctl.ThreadpoolController:
    return threadpoolctl.ThreadpoolController()
