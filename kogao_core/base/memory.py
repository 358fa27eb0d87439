"""How memory is asked for, and left behind, by a program that works through photos and ends."""

from __future__ import annotations

import atexit
import ctypes
import gc
import sys
from typing import Final

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
