"""Many photos with the same settings: the dialog, and the question before it is cut short."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from PySide6.QtWidgets import QMessageBox

from ...actions import Spec
from ...i18n import tr
from ...widgets.dialogs import question
from .. import presets
from ..feature import Context, Feature
from ..files.options import SaveOptions, words
from ..landmarks import LandmarkSources
from .dialog import BatchDialog, progress_line
from .run import BatchProgress, BatchRun, Order


class Batch(Feature):
    """Joins the batch to its dialog."""

    def __init__(self, context: Context, landmarks: LandmarkSources, options: SaveOptions) -> None:
        super().__init__(context)
        self._landmarks, self._options = landmarks, options
        self._progress = BatchProgress(0)
        self._then: Callable[[], object] | None = None
        self.runner = BatchRun(self)
        self.dialog = BatchDialog(self.window)
        self.dialog.wanted.connect(self._start)
        self.dialog.stopped.connect(self.runner.stop)
        self.runner.advanced.connect(self._advance)
        self.runner.troubled.connect(self.dialog.show_bad)
        self.runner.ended.connect(self._end)
        self.runner.refused.connect(self._refuse)
        self.add_actions(
            Spec(
                "batch", tr("&Batch…"), "Ctrl+B", tr("The same settings for many photos"), self.show
            )
        )

    @property
    def busy(self) -> bool:
        """True while a batch runs."""
        return self.runner.busy

    def stop(self) -> None:
        """Stop, once the photos in hand are finished."""
        self.runner.wait()
        self.dialog.close()

    def show(self) -> None:
        """Show the dialog with the settings of this moment."""
        now = self.document.state.recipe
        recipes = {tr("The settings of this moment, {p:g} %", p=now.percent): now}
        recipes |= presets.built_in() | presets.own(self.settings)
        if not self.busy:
            disclosure = words(self._options.current)
            self.dialog.form.offer(recipes, disclosure)
        self.dialog.show()
        self.dialog.raise_()
        self.dialog.activateWindow()

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
        self.runner.stop()

    def _start(self, order: Order) -> None:
        disclosure = self._options.current
        self.dialog.show_running()
        self.runner.start(
            dataclasses.replace(order, landmarks=self._landmarks.wanted, disclosure=disclosure)
        )

    def _advance(self, progress: BatchProgress) -> None:
        self._progress = progress
        self.dialog.show_progress(progress, stopping=self.runner.stopping)
        if not self.dialog.isVisible():
            self.working.emit(tr("Batch: {how_far}", how_far=progress_line(progress)))

    def _end(self, stopped: bool) -> None:
        line = progress_line(self._progress)
        what = tr("Stopped: {line}", line=line) if stopped else tr("Ended: {line}", line=line)
        self.dialog.show_idle(what, again=stopped)
        self._go_on()

    def _refuse(self, reason: str) -> None:
        self.dialog.show_idle(reason)
        self._go_on()

    def _go_on(self) -> None:
        then, self._then = self._then, None
        if then is not None:
            then()
