"""What a batch is to do, how far it has come, and the work: the command line's own tasks."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from kogao_core import batch
from kogao_core.base.wording import system_reason
from kogao_core.batch import REPORT, Outcome, Workers
from kogao_core.photo.disclosure.disclosing import NO_DISCLOSURE, Disclosure
from kogao_core.photo.export import AS_IT_IS, Export
from kogao_core.recipe.recipe import Recipe

from ...i18n import tr
from ...storage import Storage


@dataclass(frozen=True, slots=True)
class Order:
    """What to do to which photos."""

    inputs: tuple[Path, ...]  # photos and folders
    folder: Path  # where results and the report go
    recipe: Recipe  # for every photo, but those with a project of their own if `projects`
    jobs: int = 1  # photos worked on at a time
    projects: bool = False  # do what the project beside a photo says
    again: bool = False  # do everything again, whatever the report says
    doubtful: bool = False  # work on doubtful faces, too
    landmarks: str | None = None  # where they come from, see `landmarks.source`
    disclosure: Disclosure = NO_DISCLOSURE  # what results tell about themselves
    export: Export = AS_IT_IS  # their size, format, colours and names

    @property
    def report(self) -> Path:
        """Where the report goes."""
        return self.folder / REPORT


@dataclass
class BatchProgress:
    """How far a batch has come."""

    total: int  # photos in all
    counts: Counter[str] = field(default_factory=Counter)  # photos by what became of them
    _start: float = field(default_factory=time.monotonic)

    @property
    def finished(self) -> int:
        """Photos that are over and done with."""
        return self.counts.total()

    @property
    def line(self) -> str:
        """How far it is, in words, and how long the rest will take once there is a pace."""
        words = {
            "done": tr("done"),
            "skipped": tr("done before"),
            "result": tr("results already"),
            "no face": tr("without a face"),
            "failed": tr("failed"),
        }
        counts = [f"{self.counts[kind]} {words[kind]}" for kind in words if self.counts[kind]]
        parts = [tr("{n} of {total}", n=self.finished, total=self.total), *counts]
        left, worked = self.total - self.finished, self.finished - self.counts["skipped"]
        if worked and left > 0:
            left_s = (time.monotonic() - self._start) / worked * left
            seconds = tr("about {n:.0f} s left", n=left_s)
            parts.append(seconds if left_s < 90.0 else tr("about {n:.0f} min left", n=left_s / 60))
        return " · ".join(parts)


def carry_out(
    order: Order,
    storage: Storage,
    stop: Callable[[], bool],
    planned: Callable[[int], None],
    went: Callable[[Outcome], None],
) -> None:
    """Work on photo after photo in processes of their own, until all are done or `stop` says so.

    Raises NothingToDo.
    """
    report = order.report
    tasks = batch.plan(
        order.inputs,
        order.folder,
        order.recipe,
        landmarks=order.landmarks,
        projects=order.projects,
        disclosure=order.disclosure,
        export=order.export,
        report=None if order.again else report,
        doubtful=order.doubtful,
        edits=storage.edits,
        results=storage.results,
    )
    if not report.exists():  # what no batch of ours has written isn't ours to replace
        batch.check_free(tasks)
    planned(len(tasks))
    try:
        outcomes = batch.run(tasks, Workers.processes(order.jobs), stop)
        batch.record(outcomes, report, storage.results, went)
    except OSError as error:
        text = tr(
            "{folder} can't be written to ({reason}); choose another folder",
            folder=order.folder,
            reason=system_reason(error),
        )
        raise batch.NothingToDo(text) from error
