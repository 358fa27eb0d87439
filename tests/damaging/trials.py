"""Cases through kogao-cli, each in a process of its own, and counts of what they came to."""

from __future__ import annotations

import argparse
import collections
import concurrent.futures
import fnmatch
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

LONGEST_SECONDS = 20.0
MOST_BYTES = 2 << 30
LONGEST_SENTENCE = 700  # letters
_PATIENCE = 1.5  # of the longest time, before a process is ended
SAID, COMPLAINTS, WORK, TEMPORARY = "said", "complaints", "work", "tmp"
# More memory is a MemoryError, not a dead machine.
_RUN = "import resource; resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30)); "
_RUN += "from kogao_core.cli import main; main()"
_PROGRAM = "kogao-cli: "
_DIGITS = re.compile(r"\d+")
_WORDS = {0: "done", 2: "refused (2)", 3: "unreadable (3)", 4: "no face (4)", 5: "in part (5)"}


@dataclass(frozen=True)
class Trial:
    """One run of the program.

    Parameters
    ----------
    kind : str
        For the table.
    arguments : sequence of str
        Paths in them are relative.
    files : dict of str to bytes
        What lies in the folder where it runs.
    outputs : tuple of str
        What may lie there afterwards if it succeeds; patterns as shells have them.
    becomes : dict of str to bytes
        Files of the folder that may change, to this content only.
    own : tuple of str
        What the program may keep there for itself, whatever it comes to; patterns, too.
    codes : tuple of int
        Exit codes that its documentation allows here.
    lines : tuple of str
        How lines on stderr may begin.
    """

    kind: str
    arguments: list[str]
    files: dict[str, bytes]
    outputs: tuple[str, ...] = ()
    becomes: dict[str, bytes] = field(default_factory=dict)
    own: tuple[str, ...] = ()
    codes: tuple[int, ...] = (0, 2, 3)
    lines: tuple[str, ...] = (_PROGRAM,)


@dataclass(frozen=True)
class Reply:
    """What a process took, and how it ended: a negative code is a signal."""

    code: int
    seconds: float
    peak_bytes: int


@dataclass
class Counts:
    """How often each kind of case came to what, and what went wrong."""

    kinds: collections.Counter[tuple[str, str]] = field(default_factory=collections.Counter)
    wrong: collections.Counter[str] = field(default_factory=collections.Counter)
    slowest_seconds: float = 0.0
    most_bytes: int = 0

    def add(self, kind: str, verdict: str, reply: Reply) -> None:
        """Count one."""
        fine = verdict in _WORDS.values()
        self.kinds[kind, verdict if fine else "wrong"] += 1
        if not fine:
            self.wrong[f"{kind}: {verdict}"] += 1
        self.slowest_seconds = max(self.slowest_seconds, reply.seconds)
        self.most_bytes = max(self.most_bytes, reply.peak_bytes)

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        sums: collections.Counter[str] = collections.Counter()
        for (_, verdict), count in self.kinds.items():
            sums[verdict] += count
        return {
            "sums": dict(sums),
            "slowest_s": round(self.slowest_seconds, 2),
            "most_mib": self.most_bytes >> 20,
            "kinds": {f"{kind}: {verdict}": n for (kind, verdict), n in sorted(self.kinds.items())},
            "wrong": dict(self.wrong.most_common()),
        }


def tried(trial: Trial, folder: Path) -> tuple[str, Reply]:
    """Run a case in a new folder and process; return the verdict and what the process took."""
    for name in (WORK, TEMPORARY):
        (folder / name).mkdir(parents=True)
    for name, data in trial.files.items():
        place = folder / WORK / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(data)
    places = {"TMPDIR": str(folder / TEMPORARY), "XDG_DATA_HOME": str(folder / "data")}
    start = time.perf_counter()
    with (folder / SAID).open("wb") as said, (folder / COMPLAINTS).open("wb") as complaints:
        process = subprocess.Popen(
            [sys.executable, "-c", _RUN, *trial.arguments], cwd=folder / WORK,
            stdin=subprocess.DEVNULL, stdout=said, stderr=complaints,
            env={**os.environ, **places},
        )  # fmt: skip
        clock = threading.Timer(_PATIENCE * LONGEST_SECONDS, process.kill)
        clock.start()
        _, status, usage = os.wait4(process.pid, 0)
        clock.cancel()
    process.returncode = os.waitstatus_to_exitcode(status)
    seconds = time.perf_counter() - start
    reply = Reply(process.returncode, seconds, 1024 * usage.ru_maxrss)
    return _verdict(trial, reply, folder), reply


def _verdict(trial: Trial, reply: Reply, folder: Path) -> str:
    if reply.seconds > LONGEST_SECONDS:
        return f"more than {LONGEST_SECONDS:g} s"
    if reply.peak_bytes > MOST_BYTES:
        return f"more than {MOST_BYTES >> 30} GiB"
    if reply.code not in trial.codes:
        return f"undocumented exit code {reply.code}"
    said, complaints = (
        (folder / name).read_text(encoding="utf-8", errors="backslashreplace")
        for name in (SAID, COMPLAINTS)
    )
    ill = _ill_said(trial, reply.code, said, complaints) or _ill_left(trial, reply.code, folder)
    return ill or _WORDS[reply.code]


def _ill_said(trial: Trial, code: int, said: str, complaints: str) -> str:
    lines = complaints.splitlines()
    for line in lines:
        if not line.startswith(trial.lines):
            return f"noise on stderr: {_DIGITS.sub('0', line)[:60]}"
        if len(line) > LONGEST_SENTENCE or not line.isprintable():
            return f"more than {LONGEST_SENTENCE} letters, or some that can't be printed"
    # What was done may need remarks, of which each has its line.
    if code not in (0, 5) and trial.lines == (_PROGRAM,) and len(lines) > 1:
        return "several lines on stderr"
    if _PROGRAM in trial.lines and code in (2, 3, 4) and (said or not lines):
        return "an error on stdout, or none at all"
    if code == 0 and "--json" in trial.arguments:
        try:
            json.loads(said, parse_constant=float.fromhex)
        except ValueError:
            return "no JSON on stdout"
    return ""


def _ill_left(trial: Trial, code: int, folder: Path) -> str:
    place = folder / WORK
    left = {path.relative_to(place).as_posix() for path in place.rglob("*") if path.is_file()}
    fine = (*trial.own, *(trial.outputs if code in (0, 5) else ()))
    more = sorted(name for name in left - set(trial.files) if not _among(name, fine))
    if more or any((folder / TEMPORARY).iterdir()):
        return f"left behind: {Path(more[0]).suffix if more else 'in the temporary folder'}"
    for name, data in trial.files.items():
        if _among(name, (*trial.own, *trial.outputs)):
            continue
        now = (place / name).read_bytes() if name in left else None
        if now not in (data, trial.becomes.get(name, data)):
            return "changed what it was given"
    return ""


def _among(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def run(make: Callable[[np.random.Generator], Trial], options: argparse.Namespace) -> Counts:
    """Try cases, each of which follows from the seed and its number, and count."""
    counts = Counts()
    keep: Path = options.keep or Path(tempfile.mkdtemp(prefix="hostile-"))
    keep.mkdir(parents=True, exist_ok=True)

    def work(number: int) -> None:
        trial = make(np.random.default_rng([options.seed, number]))
        folder = keep / f"{number} {trial.kind}"
        verdict, reply = tried(trial, folder)
        counts.add(trial.kind, verdict, reply)
        if verdict in _WORDS.values():
            shutil.rmtree(folder)
        else:
            note = {"verdict": verdict, "arguments": trial.arguments, **asdict(reply)}
            (folder / "verdict.json").write_text(json.dumps(note, indent=1), encoding="utf-8")

    make(np.random.default_rng(options.seed))  # encoders of the sound files dislike threads
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(work, range(options.inputs)))
    if not any(keep.iterdir()):
        keep.rmdir()
    return counts


def options(about: str, inputs: int) -> argparse.ArgumentParser:
    """Return the options that all these programs take."""
    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=inputs)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time")
    parser.add_argument("--only", type=lambda text: text.split(","), default=[])
    parser.add_argument("--keep", type=Path, help="folder for what went wrong")
    return parser


def finish(counts: Counts, options: argparse.Namespace) -> None:
    """Print the counts; end with 1 if anything went wrong."""
    values = {"inputs": options.inputs, "seed": options.seed, **counts.to_dict()}
    print(json.dumps(values, indent=1, ensure_ascii=False))
    sys.exit(bool(counts.wrong))
