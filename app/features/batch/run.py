"""Many photos in worker processes: the command line's own tasks, followed from the window."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from PySide6.QtCore import QObject, QThreadPool, Signal

from kogao_core import batch
from kogao_core.batch import REPORT, Outcome, Workers
from kogao_core.photo.disclosure import NO_DISCLOSURE, Disclosure
from kogao_core.recipe import Recipe

from ...i18n import sentence, tr
from ...workers import Lane


@dataclass(frozen=True, slots=True)
class Order:
    """What to do to which photos.

    Parameters
    ----------
    inputs : tuple of Path
        Photos and folders.
    folder : Path
        Where results and the report go.
    recipe : Recipe
        For every photo, but those with a project of their own if `projects`.
    jobs : int
        Photos worked on at a time.
    projects : bool
        Do what the project beside a photo says.
    again : bool
        Do everything again, whatever the report says.
    landmarks : str, optional
        Where they come from, see `landmarks.source`.
    disclosure : Disclosure
        What results tell about themselves.
    """

    inputs: tuple[Path, ...]
    folder: Path
    recipe: Recipe
    jobs: int = 1
    projects: bool = False
    again: bool = False
    landmarks: str | None = None
    disclosure: Disclosure = NO_DISCLOSURE

    @property
    def report(self) -> Path:
        """Where the report goes."""
        return self.folder / REPORT


@dataclass
class BatchProgress:
    """How far a batch has come.

    Parameters
    ----------
    total : int
        Photos in all.
    counts : Counter
        Photos by what became of them.
    """

    total: int
    counts: Counter[str] = field(default_factory=Counter)
    _start: float = field(default_factory=time.monotonic)

    @property
    def finished(self) -> int:
        """Photos that are over and done with."""
        return self.counts.total()

    @property
    def left_s(self) -> float | None:
        """Seconds the rest will take at this pace; None while there is no pace yet."""
        worked = self.finished - self.counts["skipped"]
        if not worked or self.finished >= self.total:
            return None
        return (time.monotonic() - self._start) / worked * (self.total - self.finished)


class BatchRun(QObject):
    """One batch at a time, in a thread that waits for worker processes.

    Signals
    -------
    advanced(BatchProgress)
        Photos are over and done with.
    troubled(Outcome)
        A photo couldn't be done.
    ended(bool)
        It is over; True when it was stopped before its end.
    refused(str)
        It can't be begun, and why.
    """

    advanced = Signal(object)
    troubled = Signal(object)
    ended = Signal(bool)
    refused = Signal(str)
    _planned = Signal(int)
    _went = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        # A thread of its own: it is taken for as long as the batch lasts.
        self._pool = QThreadPool(self)
        self._lane = Lane(self._pool, lambda problem: self.refused.emit(sentence(problem)), self)
        self._lane.done.connect(lambda _: self.ended.emit(self.stopping))
        self._progress = BatchProgress(0)
        self._stop = threading.Event()
        self._planned.connect(self._begin)
        self._went.connect(self._take)

    @property
    def busy(self) -> bool:
        """True while a batch runs."""
        return self._lane.busy

    @property
    def stopping(self) -> bool:
        """True once it was asked to stop."""
        return self._stop.is_set()

    def start(self, order: Order) -> None:
        """Begin a batch, or go on with one that the folder's report knows."""
        if not self.busy:
            self._stop.clear()
            stop, planned, went = self._stop, self._planned.emit, self._went.emit
            self._lane.submit(lambda: _work(order, stop.is_set, planned, went))

    def stop(self) -> None:
        """Hand out no more photos; those in hand are finished."""
        self._stop.set()

    def wait(self) -> None:
        """Stop, and wait until the photos in hand are finished."""
        self.stop()
        self._lane.drop()
        self._pool.waitForDone()

    def _begin(self, total: int) -> None:
        self._progress = BatchProgress(total)
        self.advanced.emit(self._progress)

    def _take(self, outcome: Outcome) -> None:
        self._progress.counts[outcome.status] += 1
        if outcome.status in ("failed", "no face"):
            self.troubled.emit(outcome)
        self.advanced.emit(self._progress)


def _work(
    order: Order,
    stop: Callable[[], bool],
    planned: Callable[[int], None],
    went: Callable[[Outcome], None],
) -> None:
    report = order.report
    tasks = batch.plan(
        order.inputs,
        order.folder,
        order.recipe,
        landmarks=order.landmarks,
        projects=order.projects,
        disclosure=order.disclosure,
        report=None if order.again else report,
    )
    taken = next((task.output for task in tasks if Path(task.output).exists()), None)
    if taken is not None and not report.exists():
        # What no batch of ours has written isn't ours to replace.
        raise batch.NothingToDo(tr("{file} exists; choose another folder", file=taken))
    planned(len(tasks))
    try:
        batch.record(batch.run(tasks, Workers.processes(order.jobs), stop), report, went)
    except OSError as error:
        text = tr(
            "{folder} can't be written to ({reason}); choose another folder",
            folder=order.folder,
            reason=error.strerror or error,
        )
        raise batch.NothingToDo(text) from error
