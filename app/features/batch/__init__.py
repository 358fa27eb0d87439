"""Many photos with the same settings: their dialog, and the question before it is cut short."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from functools import cached_property
from pathlib import Path

from PySide6.QtCore import QThreadPool, Signal
from PySide6.QtWidgets import QMessageBox

from kogao_core.batch import Outcome
from kogao_core.recipe.presets import listed

from ...i18n import sentence, tr, translated
from ...widgets.dialogs import question
from .. import export, presets
from ..feature import Context, Feature
from ..files.options import SaveOptions, words
from ..landmarks import LandmarkSources
from ..strip import Strip
from ..strip.facts import Mark
from .dialog import BatchDialog
from .order import BatchProgress, Order, carry_out


class Batch(Feature):
    """Runs one batch at a time, and follows it in the dialog that takes the order."""

    _planned = Signal(int)
    _went = Signal(object)

    def __init__(
        self, context: Context, landmarks: LandmarkSources, options: SaveOptions, strip: Strip
    ) -> None:
        super().__init__(context)
        self._landmarks, self._options, self._strip = landmarks, options, strip
        self._progress = BatchProgress(0)
        self._enough = threading.Event()
        self._then: Callable[[], object] | None = None
        # A thread of its own: it is taken for as long as the batch lasts.
        self._own_pool = QThreadPool(self)
        self._running = self.lane(self._end, self._refuse, self._own_pool)
        self._planned.connect(self._begin)
        self._went.connect(self._take)
        self.add_action(
            "batch", tr("&Batch…"), "Ctrl+B", tr("The same settings for many photos"), self.show
        )

        strip.film.addAction(
            self.add_action(
                "batch-chosen",
                tr("Batch &these…"),
                "Ctrl+Alt+B",
                tr("The photos chosen on the film strip, or all of it, with what each has"),
                self.show_chosen,
            )
        )

    @cached_property
    def dialog(self) -> BatchDialog:
        """Where a batch is ordered and followed."""
        dialog = BatchDialog(self.window)
        dialog.wanted.connect(self.start)
        dialog.stopped.connect(self._enough.set)
        return dialog

    def stop(self) -> None:
        """Stop, once the photos in hand are finished."""
        self._enough.set()
        super().stop()
        self._own_pool.waitForDone()
        for dialog in self.window.findChildren(BatchDialog):
            dialog.close()

    def show(self) -> None:
        """Show the dialog with the settings of this moment."""
        now = self.document.state.recipe
        recipes = {tr("The settings of this moment, {what}", what=translated(now.amount)): now}
        recipes |= presets.built_in() | listed(self.storage.presets)
        if not self.busy:
            disclosure = words(self._options.current)
            self.dialog.form.offer(recipes, export.presets(self.settings), disclosure)
        self.dialog.present()

    def show_chosen(self) -> None:
        """Show the dialog with the photos chosen on the strip; of one alone, with all of them."""
        if not self.busy:
            chosen = self._strip.chosen()
            self.dialog.form.replace(chosen if len(chosen) > 1 else self._strip.photos())
        self.show()

    def guard(self, then: Callable[[], object]) -> None:
        """Do `then` at once, or after a running batch was stopped with the user's consent."""
        if not self.busy:
            then()
            return
        buttons = QMessageBox.StandardButton
        box = question(self.window, tr("Stop the batch?"))
        box.setInformativeText(
            tr("The photos in hand are finished first; it can go on another time.")
        )
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
        self.working.emit(tr("The photos in hand are finished first…"))
        self._enough.set()

    def start(self, order: Order) -> None:
        """Begin a batch, or go on with one that the folder's report knows."""
        disclosure, enough = self._options.current, self._enough
        whole = dataclasses.replace(order, landmarks=self._landmarks.wanted, disclosure=disclosure)
        self.dialog.show_running()
        enough.clear()
        storage = self.storage
        planned, went = self._planned.emit, self._went.emit
        self._running.submit(lambda: carry_out(whole, storage, enough.is_set, planned, went))

    def _begin(self, total: int) -> None:
        self._progress = BatchProgress(total)
        self._advance()

    def _take(self, outcome: Outcome) -> None:
        self._progress.counts[outcome.status] += 1
        if outcome.status in ("failed", "no face", "result"):
            self.dialog.show_bad(outcome)
        undone = outcome.status in ("failed", "no face")
        told: Mark = "doubtful" if outcome.doubtful else "failed" if undone else ""
        self._strip.look_again(Path(outcome.source), told)
        self._advance()

    def _advance(self) -> None:
        self.dialog.show_progress(self._progress, stopping=self._enough.is_set())
        n, total = self._progress.finished, self._progress.total
        self._strip.panel.show_running(tr("{n} of {total}", n=n, total=total), self._enough.set)
        if not self.dialog.isVisible():
            self.working.emit(tr("Batch: {how_far}", how_far=self._progress.line))

    def _end(self, _: None) -> None:
        line, stopped = self._progress.line, self._enough.is_set()
        what = tr("Stopped: {line}", line=line) if stopped else tr("Ended: {line}", line=line)
        self.dialog.show_idle(what, again=stopped)
        self._go_on()

    def _refuse(self, problem: Exception) -> None:
        self.dialog.show_idle(sentence(problem))
        self._go_on()

    def _go_on(self) -> None:
        self._strip.panel.show_running("")
        then, self._then = self._then, None
        if then is not None:
            then()
