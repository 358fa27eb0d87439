"""Where the time of one command goes: ``python tests/benchmarks/stages.py OUT.json ARGUMENTS...``.

Runs `kogao-cli` with the arguments and looks every few ms at what the main thread is in. Each look
counts for the time since the last one, so C code that keeps the interpreter counts, too.
"""

from __future__ import annotations

import collections
import json
import sys
import tempfile
import threading
import time
from pathlib import Path
from types import FrameType

# The first that is on the stack tells the stage.
STAGES = (
    ("importlib._bootstrap", "load modules"),
    ("kogao_core.background.lines", "bent lines"),
    ("kogao_core.cli.summary", "readings"),
    ("kogao_core.faces.landmarks", "find faces"),
    ("kogao_core.pipeline", "render"),
    ("kogao_core.photo.writing", "save"),
    ("kogao_core.photo.disclosure.disclosing", "save"),
    ("kogao_core.photo", "decode"),
)
REST = "the rest"
OUTSIDE = "start and end of Python"
_EVERY_S = 0.002


def of_command(*arguments: object) -> dict[str, float]:
    """Return the time of each stage of a command in a process of its own, ms."""
    from processes import run

    with tempfile.TemporaryDirectory() as folder:
        told = Path(folder) / "stages.json"
        cost = run(sys.executable, __file__, told, *arguments)
        stages: dict[str, float] = json.loads(told.read_text())
    return {OUTSIDE: max(0.0, cost.wall_ms - sum(stages.values())), **stages}


def _stage(frame: FrameType | None) -> str:
    modules = set()
    while frame is not None:
        modules.add(frame.f_globals.get("__name__", ""))
        frame = frame.f_back
    for start, stage in STAGES:
        if any(name == start or name.startswith(f"{start}.") for name in modules):
            return stage
    return REST


def _main(told: Path, arguments: list[str]) -> None:
    main, over = threading.get_ident(), threading.Event()
    taken: collections.Counter[str] = collections.Counter()

    def watch() -> None:
        last = time.perf_counter()
        while not over.wait(_EVERY_S):
            stage, now = _stage(sys._current_frames().get(main)), time.perf_counter()
            taken[stage] += (now - last) * 1e3
            last = now

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    sys.argv = ["kogao-cli", *arguments]
    try:
        from kogao_core.cli import main as kogao_cli

        kogao_cli()
    finally:
        over.set()
        watcher.join()
        told.write_text(json.dumps(taken))


if __name__ == "__main__":
    _main(Path(sys.argv[1]), sys.argv[2:])
