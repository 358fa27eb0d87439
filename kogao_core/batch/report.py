"""The report of a batch: a line of JSON for each photo, added as soon as it is done."""

from __future__ import annotations

import errno
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Final

from kogao_core.base.atomic import appended
from kogao_core.base.language import Text
from kogao_core.batch.tasks import Outcome
from kogao_core.projects.results import Results

_START: Final = b'{"s'  # ource, the first field of a line


def record(
    outcomes: Iterable[Outcome],
    report: Path,
    results: Results,
    then: Callable[[Outcome], object],
) -> None:
    """Add every outcome to a report, which is made or gone on with, and results to their list."""
    if report.is_file():
        with report.open("rb") as file:
            if not _START.startswith(file.read(len(_START))):
                raise FileExistsError(errno.EEXIST, Text("it is no report of a batch"), str(report))
    with appended(report) as lines:
        for outcome in outcomes:
            lines.write(outcome.to_json().encode() + b"\n")
            lines.flush()
            if outcome.status == "done":
                results.add(Path(outcome.source), Path(outcome.output), outcome.edit)
            then(outcome)


def keys_of(report: Path | None) -> dict[str, str]:
    """Return the keys of what a report lists as done, by output; damaged lines don't count."""
    keys: dict[str, str] = {}
    if report is None or not report.is_file():
        return keys
    for line in report.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            entry = json.loads(line)
            output, status, key = entry["output"], entry["status"], entry["key"]
        except (ValueError, KeyError, TypeError, RecursionError):
            continue
        if status in ("done", "skipped") and isinstance(output, str) and isinstance(key, str):
            keys[output] = key
    return keys
