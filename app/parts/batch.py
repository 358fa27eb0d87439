"""The batch: its dialog, what it works with, and the question before it is cut short."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from PySide6.QtCore import QObject, QSettings, Qt
from PySide6.QtWidgets import QMessageBox

from .. import actions, presets, saving
from ..controllers.batch import Batch, Order, Standing
from ..document import Document
from ..i18n import tr
from ..views.batch import BatchDialog, standing_line
from ..views.window import Window
from .landmarks import LandmarksPart


class BatchPart(QObject):
    """Builds the batch and joins it to its dialog."""

    def __init__(
        self,
        document: Document,
        landmarks: LandmarksPart,
        window: Window,
        settings: QSettings,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._document, self._landmarks = document, landmarks
        self._window, self._settings = window, settings
        self._standing = Standing(0)
        self._then: Callable[[], object] | None = None
        self.batch = Batch(self)
        self.dialog = BatchDialog(window)
        self.dialog.wanted.connect(self._start)
        self.dialog.stopped.connect(self.batch.stop)
        self.batch.advanced.connect(self._advance)
        self.batch.troubled.connect(self.dialog.show_bad)
        self.batch.ended.connect(self._end)
        self.batch.refused.connect(self._refuse)
        actions.connect(window.actions_by_name, {"batch": self.show})

    @property
    def busy(self) -> bool:
        """True while a batch runs."""
        return self.batch.busy

    def stop(self) -> None:
        """Stop, once the photos in hand are finished."""
        self.batch.wait()
        self.dialog.close()

    def show(self) -> None:
        """Show the dialog with the settings of this moment."""
        now = self._document.state.recipe
        recipes = {tr("The settings of this moment, {p:g} %", p=now.percent): now}
        recipes |= presets.built_in() | presets.own(self._settings)
        if not self.busy:
            told = saving.words(saving.disclosure(self._settings))
            self.dialog.form.offer(recipes, told)
        self.dialog.show()
        self.dialog.raise_()
        self.dialog.activateWindow()

    def guard(self, then: Callable[[], object]) -> None:
        """Do `then` at once, or after a running batch was stopped with the user's consent."""
        if not self.busy:
            then()
            return
        buttons = QMessageBox.StandardButton
        box = QMessageBox(self._window)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(tr("Stop the batch?"))
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
        self._window.status.hint(tr("The photos in hand are finished first…"))
        self.batch.stop()

    def _start(self, order: Order) -> None:
        telling = saving.disclosure(self._settings)
        self.dialog.show_running()
        self.batch.start(
            dataclasses.replace(order, landmarks=self._landmarks.wanted, disclosure=telling)
        )

    def _advance(self, standing: Standing) -> None:
        self._standing = standing
        self.dialog.show_standing(standing, stopping=self.batch.stopping)
        if not self.dialog.isVisible():
            self._window.status.hint(tr("Batch: {how_far}", how_far=standing_line(standing)))

    def _end(self, stopped: bool) -> None:
        line = standing_line(self._standing)
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
