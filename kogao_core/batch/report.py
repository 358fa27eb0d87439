"""The report of a batch: a line of JSON for each photo, added as soon as it is done."""

from __future__ import annotations

import errno
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from kogao_core.base.atomic import appended
from kogao_core.base.language import Text
from kogao_core.batch.measures import COLUMNS
from kogao_core.batch.tasks import Outcome, Task
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
    """Return the keys of what a report lists as done, by output."""
    done = (entry for entry in _entries(report) if entry["status"] in ("done", "skipped"))
    return {entry["output"]: entry["key"] for entry in done}


def measures_of(report: Path, tasks: Sequence[Task]) -> list[Mapping[str, Any]]:
    """Return what a report says of each face of the tasks' results, in their order."""
    # Of what was done before and skipped now, the line before tells.
    latest = {one["output"]: one for one in _entries(report) if one["status"] != "skipped"}
    of_each = (latest.get(task.output, {}).get("measures") for task in tasks)
    rows = (row for rows in of_each if isinstance(rows, list) for row in rows)
    return [row for row in rows if isinstance(row, dict) and COLUMNS.keys() <= row.keys()]


def _entries(report: Path | None) -> Iterator[dict[str, Any]]:
    """Yield the lines of a report; damaged ones don't count."""
    if report is None or not report.is_file():
        return
    for line in report.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            entry = json.loads(line)
            texts = entry["output"], entry["status"], entry["key"]
        except (ValueError, KeyError, TypeError, RecursionError):
            continue
        if all(isinstance(text, str) for text in texts):
            yield entry
