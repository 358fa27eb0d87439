"""Threads that help and threads that hurt."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from functools import cache

import threadpoolctl

MOST_THREADS = 4


def default_threads() -> int:
    """Return how many threads resample when nobody says: the processors, up to 4."""
    return min(MOST_THREADS, os.cpu_count() or 1)


@cache
def pool(threads: int) -> ThreadPoolExecutor:
    """Return the program's own pool of that size."""
    return ThreadPoolExecutor(threads, thread_name_prefix="kogao-warp")


def one_blas_thread() -> AbstractContextManager[object]:
    """Keep BLAS to one thread inside the ``with`` block.

    Our matrices are small: a second BLAS thread costs more than it brings, and where the machine
    is busy a hundred times more, because it spins while it waits.
    """
    return _controller().limit(limits=1, user_api="blas")  # type: ignore[no-any-return]


@cache
def _controller() -> threadpoolctl.ThreadpoolController:
    return threadpoolctl.ThreadpoolController()
