"""SIGINT, SIGTERM and SIGHUP end a program at once: one line, exit code 130, nothing left aside.

Not by an exception: one that is raised within an import, a lock or the start of a thread can hang
Python for ever. What a program does is done so that it may be killed at any moment (`atomic`).
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

CODE = 130
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
_ERROR_FD = 2
_CHILDREN_S = 1.0  # for which processes that share the work are waited for
_leaving: list[Callable[[], object]] = []


def leaving(act: Callable[[], object]) -> None:
    """Let something be called before this process is ended by a signal; it must not wait."""
    _leaving.append(act)


def clear() -> None:
    """Call what was to be called."""
    for act in _leaving:
        act()


def end_when_told(program: str = "", code: int = CODE) -> None:
    """Let signals end this process, with a line on standard error by the name of the program.

    Whoever has one ignored, as nohup has, is let alone. Without a name nothing is said.
    """
    own = os.getpid()
    # Decoders' complaints are kept from the descriptor 2 for a moment: the line isn't.
    error = _copied(_ERROR_FD) if program else None

    def end(*_: object) -> None:
        if os.getpid() != own:  # a copy that has not come to its own orders yet
            os._exit(code)
        _set(signal.SIG_IGN)
        _end_children()
        clear()
        if error is not None:
            line = f"{program}: {_translated('interrupted')}\n"
            os.write(error, line.encode(errors="replace"))
        os._exit(code)

    _set(end)


def let_be() -> None:
    """Let signals do nothing any more: all is said and done but for Python's own end."""
    _set(signal.SIG_IGN)


@contextmanager
def raised() -> Iterator[None]:
    """Let a signal raise KeyboardInterrupt, in a program that waits for one to go on."""
    before = {number: signal.getsignal(number) for number in _numbers()}
    _set(signal.default_int_handler)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _set(handler: Callable[[int, FrameType | None], object] | signal.Handlers) -> None:
    for number in _numbers():
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _numbers() -> list[signal.Signals]:
    if threading.current_thread() is not threading.main_thread():
        return []  # Python refuses
    return [getattr(signal, name) for name in _NAMES if hasattr(signal, name)]


def _copied(descriptor: int) -> int | None:
    try:
        return os.dup(descriptor)
    except OSError:  # there is none where a program was started without
        return None


def _end_children() -> None:
    """End the processes that this one has started to share its work, and wait for them."""
    multiprocessing = sys.modules.get("multiprocessing.process")
    if multiprocessing is None:
        return
    children = multiprocessing.active_children()
    for child in children:
        child.terminate()
    end = time.monotonic() + _CHILDREN_S
    for child in children:
        child.join(max(0.0, end - time.monotonic()))


def _translated(text: str) -> str:
    # The module may be half loaded: nothing is imported in here.
    looked_up = getattr(sys.modules.get("kogao_core.base.language"), "looked_up", None)
    return text if looked_up is None else str(looked_up(text))
