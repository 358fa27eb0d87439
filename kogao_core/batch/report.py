"""The report of a batch: a line of JSON for each photo, added as soon as it is done."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Final, TextIO

from kogao_core.atomic import check_target
from kogao_core.batch.tasks import Outcome
from kogao_core.language import Text

REPORT: Final = "kogao-batch.jsonl"
"""Its name, in the folder of the results."""
_START: Final = b'{"s'  # ource, the first field of a line


def record(outcomes: Iterable[Outcome], report: Path, then: Callable[[Outcome], object]) -> None:
    """Add every outcome to a report, which is made or gone on with.

    Parameters
    ----------
    outcomes : iterable of Outcome
        As `run` yields them; nothing is run before the report is open.
    report : Path
        The file.
    then : callable
        Called with each outcome that is on the disk.

    Raises
    ------
    OSError
        If the report can't be written, or the file is something else.
    """
    with _appended(report) as lines:
        for outcome in outcomes:
            lines.write(outcome.to_json() + "\n")
            lines.flush()
            then(outcome)


def _appended(report: Path) -> TextIO:
    """Open a report to go on with, on a line of its own."""
    report.parent.mkdir(parents=True, exist_ok=True)
    check_target(report)
    if report.is_file():
        with report.open("rb") as file:
            if not _START.startswith(file.read(len(_START))):
                raise FileExistsError(errno.EEXIST, Text("it is no report of a batch"), str(report))
    was_cut = (
        report.is_file() and report.stat().st_size > 0 and not report.read_bytes().endswith(b"\n")
    )
    lines = report.open("a", encoding="utf-8")
    if was_cut:
        lines.write("\n")
    return lines
