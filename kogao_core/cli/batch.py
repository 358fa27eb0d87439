"""``kogao-cli batch``: process many photos; resume after an interruption."""

from __future__ import annotations

import sys
import time
from collections import Counter
from pathlib import Path
from types import SimpleNamespace
from typing import Final

import click

from kogao_core import batch
from kogao_core.base import wording
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text, tr, translated
from kogao_core.batch import Outcome, Workers
from kogao_core.batch.cluster import connect
from kogao_core.batch.measures import codebook_of, write
from kogao_core.cli import card, common, ending, options, reading
from kogao_core.projects.edits import Edits
from kogao_core.projects.results import Results


def run(args: SimpleNamespace) -> int:
    """Run the command."""
    recipe = options.recipe_of(args.recipe_file, vars(args))
    with ending.stopping(ValueError, ending.USAGE):
        suffix = f".{args.form}" if args.form else ""
        job = reading.job_of(args, recipe, ending=suffix, name=args.name)
    report = args.report or args.folder / batch.REPORT
    if args.measures is not None:
        common.check_free(args.measures, args.force)
        common.check_free(codebook_of(args.measures), args.force)
    common.check_report(args.card, args.force)
    with (
        ending.stopping(BadFile, ending.UNREADABLE),
        ending.stopping(batch.NothingToDo, ending.USAGE),
    ):
        tasks = batch.plan(
            _expanded(args.inputs), args.folder, job,
            suffix=f".{args.suffix}", report=None if args.again else report, points=args.points,
            edits=Edits.of_user() if args.projects else None,
            results=None if args.results else Results.of_user(),
        )  # fmt: skip
        if not args.force and not report.exists():
            try:
                batch.check_free(tasks)
            except batch.NothingToDo as error:
                raise ending.Stop("{error}, or use --force to overwrite", error=error) from None
    reading.check_networks()
    reading.mention_fallback(args.landmarks)
    if count := batch.outdated(tasks):
        ending.print_message(
            Text.counted(count, "warning: {n} edit of an older version may look different now",
                         "warning: {n} edits of an older version may look different now")
        )  # fmt: skip
    progress = _Progress(len(tasks))
    with ending.stopping(batch.NothingToDo, ending.USAGE), ending.refusing(
        "the report {report} can't be written ({reason}); mend that, or choose another file "
        "with --report, then run the batch again to resume",
        report=report,
    ):  # fmt: skip
        pool = connect(args.cluster, args.folder) if args.cluster else Workers.processes(args.jobs)
        batch.record(batch.run(tasks, pool), report, Results.of_user(), progress.add)
    if args.measures is not None:
        with ending.writing(args.measures):
            write(batch.measures_of(report, tasks), args.measures)
    if args.card is not None:
        with ending.writing(args.card):
            card.write(args.card, args.folder, recipe, batch.measures_of(report, tasks))
    progress.end(report)
    if progress.counts["failed"] or progress.counts["no face"]:
        return ending.SOME_FAILED
    return ending.OWN_RESULT if progress.counts["result"] else 0


def _expanded(inputs: tuple[Path, ...]) -> list[Path]:
    """Expand patterns that the shell did not expand."""
    paths: list[Path] = []
    for path in inputs:
        if path.exists() or not any(sign in str(path) for sign in "*?["):
            paths.append(path)
            continue
        anchor = Path(path.anchor) if path.anchor else Path()
        found = sorted(anchor.glob(str(path.relative_to(anchor) if path.anchor else path)))
        if not found:
            raise ending.Stop("no file matches {path}; check the pattern and the folder", path=path)
        paths += found
    return paths


_STATES: Final = {
    "done": Text("done"),
    "skipped": Text("skipped"),
    "result": Text("earlier results skipped"),
    "no face": Text("no face"),
    "failed": Text("failed"),
}


class _Progress:
    """Counts outcomes and estimates the remaining time."""

    def __init__(self, total: int) -> None:
        self._total = total
        self._start = time.monotonic()
        self.counts: Counter[str] = Counter()

    def add(self, outcome: Outcome) -> None:
        """Count an outcome; print the photos that failed or were skipped."""
        self.counts[outcome.status] += 1
        if outcome.status in ("failed", "no face", "result"):
            named = outcome.reason.startswith(outcome.source)
            reason = translated(outcome.reason)
            self._print(reason if named else f"{outcome.source}: {reason}")
        if sys.stderr.isatty():
            self._print(self._line(), end="\r")

    def end(self, report: Path) -> None:
        """Print the totals."""
        self._print(tr("{line}; see {report}", line=self._line(), report=report))

    def _line(self) -> str:
        finished = sum(self.counts.values())
        counts = ", ".join(
            f"{count} {translated(_STATES[name])}" for name, count in sorted(self.counts.items())
        )
        worked = finished - self.counts["skipped"]
        line = tr(
            "{finished} of {total}: {counts}",
            finished=finished,
            total=self._total,
            counts=counts or tr("nothing yet"),
        )
        if worked and finished < self._total:
            left = (time.monotonic() - self._start) / worked * (self._total - finished)
            if left > 90:
                return tr("{line}, {left:.0f} min left", line=line, left=left / 60)
            return tr("{line}, {left:.0f} s left", line=line, left=left)
        return line

    def _print(self, text: str, end: str = "\n") -> None:
        click.echo(wording.sentence(text) + end, nl=False, err=True)
