"""Export of many photos: the order, the worker processes, progress and the final message."""

from __future__ import annotations

import dataclasses
import os
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QThreadPool, Signal
from PySide6.QtWidgets import QMessageBox

from kogao_core import batch
from kogao_core.base.index import path_hash
from kogao_core.base.wording import system_reason
from kogao_core.batch import REPORT, Outcome, Workers
from kogao_core.retouch import RetouchJob

from ..i18n import sentence, tr, translated
from ..storage import Storage
from ..widgets.dialogs import ask_choice, open_path, question
from ..widgets.messages import BarAction
from .disclosure import SaveOptions
from .feature import Context, Feature
from .files.saver import Saver
from .landmarks import LandmarkSources
from .strip import Strip
from .strip.facts import Mark

# Each worker needs about eight times the pixels of a photo in memory.
_JOBS: Final = max(1, min(4, (os.cpu_count() or 2) - 1))


_NAMED: Final = 8  # photos that a question names


@dataclass(frozen=True, slots=True)
class Order:
    """An export of several photos."""

    photos: tuple[Path, ...]
    folder: Path  # for results
    report: Path
    job: RetouchJob  # the recipe is for photos without edits


@dataclass(frozen=True, slots=True)
class ExportPlan:
    """The tasks of an export, and the facts that need a question before it starts."""

    tasks: list[batch.Task]
    outdated: int  # edits that may look different
    partial: list[batch.Task]  # tasks with a face marked only in part


@dataclass
class BatchProgress:
    """Progress of an export."""

    total: int  # photos
    counts: Counter[str] = field(default_factory=Counter)  # photos by status
    _start: float = field(default_factory=time.monotonic)

    @property
    def finished(self) -> int:
        return self.counts.total()

    @property
    def result(self) -> str:
        """Number of photos by status, in words."""
        words = {
            "done": tr("done"),
            "skipped": tr("done before"),
            "result": tr("results already"),
            "no face": tr("without a face"),
            "failed": tr("failed"),
        }
        counts = [f"{self.counts[kind]} {words[kind]}" for kind in words if self.counts[kind]]
        return " · ".join(counts)

    @property
    def line(self) -> str:
        """Progress in words, with the estimated time left."""
        parts = [tr("{n} of {total}", n=self.finished, total=self.total)]
        if self.finished:
            parts.append(self.result)
        left, worked = self.total - self.finished, self.finished - self.counts["skipped"]
        if worked and left > 0:
            left_s = (time.monotonic() - self._start) / worked * left
            seconds = tr("about {n:.0f} s left", n=left_s)
            parts.append(seconds if left_s < 90.0 else tr("about {n:.0f} min left", n=left_s / 60))
        return " · ".join(parts)


def report_of(folder: Path, storage: Storage) -> Path:
    """Return the report of exports into a folder: in Kogao's folder, or as version 1.0 wrote it."""
    before = folder / REPORT
    return before if before.exists() else storage.exports / f"{path_hash(folder)[:32]}.jsonl"


def planned(order: Order, storage: Storage) -> ExportPlan:
    """Return the tasks of an export and the questions about them. Raises NothingToDo."""
    tasks = batch.plan(
        order.photos,
        order.folder,
        order.job,
        report=order.report,
        edits=storage.edits,
        results=storage.results,
    )
    if not order.report.exists():  # never replace files that Kogao has not exported
        batch.check_free(tasks)
    return ExportPlan(tasks, batch.outdated(tasks), batch.partial(tasks))


def carry_out(
    tasks: Sequence[batch.Task],
    order: Order,
    storage: Storage,
    stop: Callable[[], bool],
    went: Callable[[Outcome], None],
) -> None:
    """Export the photos in worker processes until all are done or `stop` returns True.

    Raises NothingToDo.
    """
    try:
        order.report.parent.mkdir(parents=True, exist_ok=True)
        outcomes = batch.run(tasks, Workers.processes(_JOBS), stop)
        batch.record(outcomes, order.report, storage.results, went)
    except OSError as error:
        text = tr(
            "{folder} can't be written to ({reason}); choose another folder",
            folder=order.folder,
            reason=system_reason(error),
        )
        raise batch.NothingToDo(text) from error


class Batch(Feature):
    """Exports several photos, one order at a time."""

    # (outcome: Outcome): a photo is finished; from a worker.
    _finished = Signal(object)

    def __init__(
        self,
        context: Context,
        landmarks: LandmarkSources,
        options: SaveOptions,
        strip: Strip,
        saver: Saver,
    ) -> None:
        super().__init__(context)
        self._landmarks, self._options = landmarks, options
        self._strip, self._saver = strip, saver
        self._progress, self._failures = BatchProgress(0), list[str]()
        self._order: Order | None = None
        self._stopping = threading.Event()
        self._then: Callable[[], object] | None = None
        # A separate pool: the thread is busy for the whole export.
        self._own_pool = QThreadPool(self)
        self._running = self.lane(self._end, self._refuse, self._own_pool)
        self._planning = self.lane(self._review, self._refuse, self._own_pool)
        self._finished.connect(self._take)

    def stop(self) -> None:
        """Stop after the photos in progress."""
        self._stopping.set()
        super().stop()
        self._own_pool.waitForDone()

    def guard(self, then: Callable[[], object]) -> None:
        """Call `then` at once, or ask to stop a running export first."""
        if not self.busy:
            then()
            return
        buttons = QMessageBox.StandardButton
        box = question(self.window, tr("Stop the export?"))
        box.setInformativeText(tr("Photos in work are finished. Export again to continue."))
        box.setStandardButtons(buttons.Yes | buttons.Cancel)
        box.button(buttons.Yes).setText(tr("&Stop and close"))
        box.setDefaultButton(buttons.Cancel)
        box.button(buttons.Yes).clicked.connect(lambda: self._stop_and(then))
        box.open()

    def _stop_and(self, then: Callable[[], object]) -> None:
        if not self.busy:
            then()
            return
        self._then = then
        self.working.emit(tr("Finishing the photos in work…"))
        self._stopping.set()

    def start(self, order: Order) -> None:
        """Save the edits of the open photo, then export; skip photos that are up to date."""
        landmarks, disclosure = self._landmarks.wanted, self._options.current
        job = dataclasses.replace(order.job, landmarks=landmarks, disclosure=disclosure)
        self._saver.guard(lambda: self._run(dataclasses.replace(order, job=job)))

    def _run(self, order: Order) -> None:
        self._order = order
        self._failures = []
        self._stopping.clear()
        self._begin(len(order.photos))
        storage = self.storage
        self._planning.submit(lambda: (order, planned(order, storage)))

    def _review(self, made: tuple[Order, ExportPlan]) -> None:
        """Show the plan before if names differ, or if faces are marked only in part."""
        order, plan = made
        renamed = [task for task in plan.tasks if task.renamed]
        if not (renamed or plan.partial):
            self._go(order, plan, plan.tasks)
            return
        pairs = [f"{Path(it.source).name} → {Path(it.output).name}" for it in plan.tasks]
        lines = [tr("Photos of one name get different names:")] if renamed else []
        lines += [pairs[plan.tasks.index(task)] for task in renamed[:_NAMED]]
        answers = {tr("E&xport"): plan.tasks}
        if plan.partial:
            names = ", ".join(Path(task.source).name for task in plan.partial[:_NAMED])
            lines.append(tr("Faces marked only in part: {names}", names=names))
            found = [dataclasses.replace(it, by_hand=it not in plan.partial) for it in plan.tasks]
            answers = {tr("&Automatic points"): found, tr("Points so &far"): plan.tasks}
        acts = {title: partial(self._go, order, plan, it) for title, it in answers.items()}
        box = ask_choice(self.window, tr("Export like this?"), "\n".join(lines), acts)
        box.setDetailedText("\n".join(pairs))
        box.rejected.connect(self._go_on)
        box.open()

    def _go(self, order: Order, plan: ExportPlan, tasks: list[batch.Task]) -> None:
        self._begin(len(tasks), plan.outdated)
        storage, stopping, finished = self.storage, self._stopping.is_set, self._finished.emit
        self._running.submit(lambda: carry_out(tasks, order, storage, stopping, finished))

    def _begin(self, total: int, outdated: int = 0) -> None:
        self._progress = BatchProgress(total)
        if outdated:
            self.say(tr("Edits of an older version that may look different now: {n}", n=outdated))
        self._advance()

    def _take(self, outcome: Outcome) -> None:
        self._progress.counts[outcome.status] += 1
        if outcome.status in ("failed", "no face", "result"):
            why = translated(outcome.reason)
            is_named = outcome.reason.startswith(outcome.source)
            named = sentence(why) if is_named else f"{Path(outcome.source).name}: {sentence(why)}"
            self._failures.append(named)
        undone = outcome.status in ("failed", "no face")
        mark: Mark = "doubtful" if outcome.doubtful else "failed" if undone else ""
        self._strip.look_again(Path(outcome.source), mark)
        self._advance()

    def _advance(self) -> None:
        n, total = self._progress.finished, self._progress.total
        self._strip.panel.show_running(tr("{n} of {total}", n=n, total=total), self._stopping.set)
        self.working.emit(tr("Export: {progress}", progress=self._progress.line))

    def _end(self, _: None) -> None:
        line = self._progress.result
        if self._stopping.is_set():
            text = sentence(tr("Export stopped: {line}", line=line))
        else:
            text = sentence(tr("Export finished: {line}", line=line))
        folder = BarAction(tr("Open folder"), lambda: open_path(self._folder))
        place = Path() if self._order is None else self._order.report
        report = BarAction(tr("Open report"), lambda: open_path(place))
        failed = bool(self._failures)
        steps = (folder, report) if failed else (folder,)
        self.say(" ".join([text, *self._failures[:1]]), *steps, wrong=failed)
        self._go_on()

    @property
    def _folder(self) -> Path:
        return self._order.folder if self._order is not None else Path()

    def _refuse(self, problem: Exception) -> None:
        self.say(sentence(problem))
        self._go_on()

    def _go_on(self) -> None:
        self.working.emit("")
        self._strip.panel.show_running("")
        then, self._then = self._then, None
        if then is not None:
            then()
