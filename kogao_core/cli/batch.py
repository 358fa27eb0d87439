"""``kogao-cli batch``: process many photos; resume after an interruption."""

from __future__ import annotations

import dataclasses
import os
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any, Final

import click

from kogao_core import batch
from kogao_core.base import wording
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text, tr, translated
from kogao_core.batch import Outcome, Workers
from kogao_core.batch.measures import codebook_of, write
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.photo.disclosure.disclosing import Disclosure
from kogao_core.photo.export import Export
from kogao_core.projects.results import Results
from kogao_core.projects.sidecar import own_folder


@words.command(
    "batch",
    examples=(
        "kogao-cli batch photos/ -o slim/",
        "kogao-cli batch photos/ 'more/*.jpg' -o slim/ --amount 6 --jobs 4",
        "kogao-cli batch photos/ -o web/ --longest-side 2048 --srgb --to jpg",
    ),
)
@click.argument("inputs", metavar="IN...", nargs=-1, required=True, type=common.PHOTO)
@words.option(
    "-o", "--output", "folder", required=True, type=common.FOLDER, metavar="DIR",
    help="Folder for the results; created if missing",
)  # fmt: skip
@options.chooses
@words.option(
    "-j", "--jobs", type=click.IntRange(1, 256), default=lambda: os.cpu_count() or 1,
    help="Photos processed in parallel; each needs about 8 times its pixels in memory "
    "[processors]",
)  # fmt: skip
@words.option(
    "--report", type=common.FILE, metavar="FILE", section=options.OUTPUT,
    help="Report, one JSON line per photo; photos listed as done are skipped "
    "[DIR/kogao-batch.jsonl]",
)  # fmt: skip
@words.option(
    "--measures", type=common.FILE, metavar="FILE", section=options.OUTPUT,
    help="Write requested and achieved amounts and face measures (CSV), with a codebook",
)  # fmt: skip
@words.option(
    "--projects", is_flag=True, section=reading.INPUT,
    help="Apply the saved edits of photos (PHOTO.kogao.json); options apply to the others",
)  # fmt: skip
@options.discloses
@options.exports
@words.option(
    "--to", "form", type=click.Choice(reading.NAMED_ENDINGS), section=options.OUTPUT,
    help="Format of all results [format of each photo]",
)  # fmt: skip
@words.option(
    "--names", "name", metavar="PATTERN", default="{name}", section=options.OUTPUT,
    help="File names of results, with {name}, {n} (001, 002, …) and {amount} [{name}]",
)  # fmt: skip
@words.option("--force", is_flag=True, help="Overwrite files in the output folder")
@words.option(
    "--as", "suffix", default="jpg", section=options.OUTPUT,
    type=click.Choice(reading.NAMED_ENDINGS),
    help="Format of results of HEIC and raw photos [jpg]",
)  # fmt: skip
@reading.takes_results
@words.option("--again", is_flag=True, help="Ignore the report and process all photos again")
@words.section(reading.INPUT, common.limits_megapixels)
@reading.chooses_landmarks
@reading.takes_point_files
def command(
    inputs: tuple[Path, ...],
    folder: Path,
    which: str,
    doubtful: bool,
    recipe_file: Path | None,
    jobs: int,
    report: Path | None,
    measures: Path | None,
    projects: bool,
    disclosure: Disclosure,
    export: Export,
    form: str | None,
    name: str,
    force: bool,
    suffix: str,
    results: bool,
    again: bool,
    max_megapixels: float,
    landmarks: str | None,
    **choices: Any,
) -> int:
    """Make the faces in many photos smaller.

    IN is a photo, a folder or a pattern such as 'in/*.jpg'.
    """
    recipe = options.recipe_of(recipe_file, choices)
    report = report or folder / batch.REPORT
    points, points_map = reading.point_files()
    if measures is not None:
        common.check_free(measures, force)
        common.check_free(codebook_of(measures), force)
    with ending.stopping(ValueError, ending.USAGE):
        export = dataclasses.replace(export, ending=f".{form}" if form else "", name=name)
    with (
        ending.stopping(BadFile, ending.UNREADABLE),
        ending.stopping(batch.NothingToDo, ending.USAGE),
    ):
        tasks = batch.plan(
            _expanded(inputs), folder, recipe,
            which=which, max_megapixels=max_megapixels, landmarks=landmarks,
            projects=projects, suffix=f".{suffix}", disclosure=disclosure,
            report=None if again else report, doubtful=doubtful, export=export,
            points=points, points_map=points_map,
            edits=own_folder(), results=None if results else Results.of_user(),
        )  # fmt: skip
        if not force and not report.exists():
            try:
                batch.check_free(tasks)
            except batch.NothingToDo as error:
                raise ending.Stop(
                    Text("{error}, or use --force to overwrite", error=error)
                ) from None
    reading.check_networks()
    reading.mention_fallback(landmarks)
    progress = _Progress(len(tasks))
    with ending.refusing(
        lambda reason: Text(
            "the report {report} can't be written ({reason}); free some space or choose another "
            "file, then run the batch again to resume",
            report=report,
            reason=reason,
        )
    ):
        batch.record(
            batch.run(tasks, Workers.processes(jobs)), report, Results.of_user(), progress.add
        )
    if measures is not None:
        with ending.writing(measures):
            write(batch.measures_of(report, tasks), measures)
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
            raise ending.Stop(Text("no file matches {path}", path=path))
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
