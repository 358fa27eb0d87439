"""A process that runs ``kogao-cli`` again and again, each time as if it had just begun.

It reads one JSON object a line, ``{"arguments": [...], "folder": "..."}``, and answers with one:
exit code, seconds, the most memory used, and what was raised. What the program prints, or a
library, goes to the files ``said`` and ``complaints`` of the folder, whoever wrote it.
"""

from __future__ import annotations

import json
import os
import re
import resource
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path
from typing import Any

from kogao_core.cli import main

MOST_ADDRESSES = 3 << 30  # bytes; more is a MemoryError, not a dead machine
_OURS = re.compile(r"[/\\](kogao_core|app)[/\\]")
SAID, COMPLAINTS, WORK, TEMPORARY, DATA = "said", "complaints", "work", "tmp", "data"


def answer(arguments: list[str], folder: Path) -> dict[str, Any]:
    """Run the program in a folder; return what came of it."""
    for descriptor, name in ((1, SAID), (2, COMPLAINTS)):
        with (folder / name).open("wb") as file:
            os.dup2(file.fileno(), descriptor)
    os.environ["TMPDIR"] = tempfile.tempdir = str(folder / TEMPORARY)
    os.environ["XDG_DATA_HOME"] = str(folder / DATA)
    os.chdir(folder / WORK)
    _forget_peak()
    code, raised = None, ""
    start = time.perf_counter()
    try:
        # Entered anew, it lets each warning be shown again.
        with warnings.catch_warnings():
            main(arguments)
    except SystemExit as end:
        code = end.code
    except BaseException as error:
        raised = _named(error)
        traceback.print_exc()
    seconds = time.perf_counter() - start
    sys.stdout.flush()
    sys.stderr.flush()
    return {"code": code, "raised": raised, "seconds": seconds, "peak_bytes": _peak()}


def _named(error: BaseException) -> str:
    """Return an exception's name and the last place of ours that it came through."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if _OURS.search(frame.filename)]
    place = f"{Path(ours[-1].filename).name}:{ours[-1].lineno}" if ours else "elsewhere"
    return f"{type(error).__name__} in {place}"


def _forget_peak() -> None:
    if sys.platform == "linux":
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def _peak() -> int:
    """Return the most memory that this process, or one that it started, has held, in bytes."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    if sys.platform != "linux":  # without a way to forget, the most so far
        return max(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, children)
    status = Path("/proc/self/status").read_text(encoding="ascii")
    own = next(line for line in status.splitlines() if line.startswith("VmHWM"))
    return 1024 * max(int(own.split()[1]), children)


def serve() -> None:
    """Answer until there is nothing more to do."""
    replies = os.fdopen(os.dup(1), "w", encoding="utf-8")
    resource.setrlimit(resource.RLIMIT_AS, (MOST_ADDRESSES, MOST_ADDRESSES))
    for line in sys.stdin:
        asked = json.loads(line)
        reply = answer(asked["arguments"], Path(asked["folder"]))
        replies.write(json.dumps(reply) + "\n")
        replies.flush()


if __name__ == "__main__":
    serve()
