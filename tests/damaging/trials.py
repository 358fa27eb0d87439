"""Cases through kogao-cli, each in a process of its own, and counts of their results."""

from __future__ import annotations

import collections
import fnmatch
import json
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from kogao_core.cli import main

LONGEST_S = 20.0
MOST_BYTES = 2 << 30
LONGEST_SENTENCE = 700  # letters
SAID, COMPLAINTS, WORK, TEMPORARY = "said", "complaints", "work", "tmp"
_MEMORY_BYTES = 3 << 30  # more is a MemoryError instead of a dead machine
_PROGRAM = "kogao-cli: "
_DIGITS = re.compile(r"\d+")
_WORDS = {0: "done", 2: "refused (2)", 3: "unreadable (3)", 4: "no face (4)", 5: "in part (5)"}


@dataclass(frozen=True)
class Trial:
    """One run of the program. Patterns of names are those of a shell."""

    kind: str  # for the table
    arguments: list[str]  # paths are relative
    files: dict[str, bytes]  # content of the folder in which the program runs
    outputs: tuple[str, ...] = ()  # patterns of files that a success may write there
    becomes: dict[str, bytes] = field(default_factory=dict)  # files that may get this content
    own: tuple[str, ...] = ()  # patterns of files that the program may always write there
    codes: tuple[int, ...] = (0, 2, 3)  # documented exit codes
    lines: tuple[str, ...] = (_PROGRAM,)  # beginnings of lines on stderr


def tried(trial: Trial, folder: Path) -> str:
    """Run a case in a new folder and a forked process; return the verdict."""
    for name in (WORK, TEMPORARY):
        (folder / name).mkdir(parents=True)
    for name, data in trial.files.items():
        place = folder / WORK / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(data)
    start = time.perf_counter()
    child = os.fork()
    if not child:
        _run(trial.arguments, folder)
    _, status, usage = os.wait4(child, 0)
    code = os.waitstatus_to_exitcode(status)
    if time.perf_counter() - start > LONGEST_S:
        return f"more than {LONGEST_S:g} s"
    if 1024 * usage.ru_maxrss > MOST_BYTES:
        return f"more than {MOST_BYTES >> 30} GiB"
    if code not in trial.codes:
        return f"undocumented exit code {code}"
    said, complaints = (
        (folder / name).read_text(encoding="utf-8", errors="backslashreplace")
        for name in (SAID, COMPLAINTS)
    )
    ill = _ill_said(trial, code, said, complaints) or _ill_left(trial, code, folder)
    return ill or _WORDS[code]


def _run(arguments: list[str], folder: Path) -> NoReturn:
    """Run the program in this forked process as if it had been started in the folder."""
    code: Any = 70
    try:
        os.chdir(folder / WORK)
        os.environ["TMPDIR"] = str(folder / TEMPORARY)
        os.environ["XDG_DATA_HOME"] = str(folder / "data")
        tempfile.tempdir = None  # read from the environment again
        for descriptor, file in enumerate((os.devnull, folder / SAID, folder / COMPLAINTS)):
            os.dup2(os.open(file, os.O_RDWR | os.O_CREAT), descriptor)
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY_BYTES, _MEMORY_BYTES))
        signal.alarm(round(1.5 * LONGEST_S))
        sys.argv = ["kogao-cli", *arguments]
        main()
    except SystemExit as ending:
        code = ending.code
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code or 0)


def _ill_said(trial: Trial, code: int, said: str, complaints: str) -> str:
    lines = complaints.splitlines()
    for line in lines:
        if not line.startswith(trial.lines):
            return f"noise on stderr: {_DIGITS.sub('0', line)[:60]}"
        if len(line) > LONGEST_SENTENCE or not line.isprintable():
            return f"more than {LONGEST_SENTENCE} letters, or some that can't be printed"
    # A success may print several warnings, one line each.
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


def run(
    make: Callable[[np.random.Generator], Trial], inputs: int, seed: int, keep: Path
) -> dict[str, Any]:
    """Try cases that follow from the seed and their number; return counts of the verdicts.

    The folders of cases with another verdict than a documented one stay in `keep`.
    """
    sums: collections.Counter[str] = collections.Counter()
    kinds: collections.Counter[str] = collections.Counter()
    wrong: collections.Counter[str] = collections.Counter()
    for number in range(inputs):
        trial = make(np.random.default_rng([seed, number]))
        folder = keep / f"{number} {trial.kind}"
        verdict = tried(trial, folder)
        kinds[f"{trial.kind}: {verdict}"] += 1
        if verdict in _WORDS.values():
            sums[verdict] += 1
            shutil.rmtree(folder)
        else:
            wrong[f"{trial.kind}: {verdict}"] += 1
            note = {"verdict": verdict, "arguments": trial.arguments}
            (folder / "verdict.json").write_text(json.dumps(note, indent=1), encoding="utf-8")
    return {"sums": sums, "kinds": dict(sorted(kinds.items())), "wrong": wrong}
