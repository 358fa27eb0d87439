"""End the program on SIGINT, SIGTERM or SIGHUP: one line on stderr, exit code 130, no leftovers.

The handler raises no exception: an exception inside an import, a lock or the start of a thread can
hang Python. All file writes are safe against a kill at any moment (`atomic`).
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType

CODE = 130
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
_ERROR_FD = 2
_CHILDREN_S = 1.0  # time to wait for worker processes to end
_leaving: list[Callable[[], object]] = []


def leaving(act: Callable[[], object]) -> None:
    """Register a callback to run before a signal ends the process. It must not block."""
    _leaving.append(act)


def clear() -> None:
    """Run the registered callbacks."""
    for act in _leaving:
        act()


def exit_on_signals(program: str = "", code: int = CODE) -> None:
    """Install signal handlers that end this process and print a line with the program's name.

    Signals that are ignored, as under nohup, stay ignored. Without a name, no line is printed.
    """
    own = os.getpid()
    # Keep a copy of stderr: decoders' warnings are redirected away from descriptor 2 at times.
    error = _copied(_ERROR_FD) if program else None

    def end(*_: object) -> None:
        if os.getpid() != own:  # a forked child that has not installed its own handler yet
            os._exit(code)
        _set(signal.SIG_IGN)
        _end_children()
        clear()
        if error is not None:
            line = f"{program}: {_translated('interrupted')}\n"
            os.write(error, line.encode(errors="replace"))
        os._exit(code)

    _set(end)


def ignore_signals() -> None:
    """Ignore signals from now on: only the interpreter's shutdown is left."""
    _set(signal.SIG_IGN)


def _set(handler: Callable[[int, FrameType | None], object] | signal.Handlers) -> None:
    for number in _numbers():
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _numbers() -> list[signal.Signals]:
    if threading.current_thread() is not threading.main_thread():
        return []  # Python allows handlers in the main thread only
    return [getattr(signal, name) for name in _NAMES if hasattr(signal, name)]


def _copied(descriptor: int) -> int | None:
    try:
        return os.dup(descriptor)
    except OSError:  # the program was started without this descriptor
        return None


def _end_children() -> None:
    """Terminate the worker processes of this process and wait for them."""
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
    # Don't import here: a module may be half loaded when the signal arrives.
    looked_up = getattr(sys.modules.get("kogao_core.base.language"), "looked_up", None)
    return text if looked_up is None else str(looked_up(text))
