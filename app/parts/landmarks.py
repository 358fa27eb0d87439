"""The choice where landmarks come from, with what each source was measured to do."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QActionGroup
from PySide6.QtWidgets import QFileDialog

from kogao_core.face import LandmarkSource
from kogao_core.landmarks import CHOICES, ModelRefused, networks_are_here, source

from .. import actions
from ..controllers.files import Files
from ..i18n import tr
from ..views.bar import Message
from ..views.window import Window


class LandmarksPart(QObject):
    """Joins the actions of the Face menu to the source that `Files` asks.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    """

    said = Signal(object)

    def __init__(
        self, first: LandmarkSource, files: Files, window: Window, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._files, self._window = files, window
        choice = next((choice for choice in CHOICES if choice.name == first.name), None)
        # As `source` takes it; None for what it gives by itself.
        self.wanted = None if choice is None else choice.name
        if choice is not None and not choice.needs_networks and not networks_are_here():
            files.found.connect(self._tell_of_fallback)
        named = window.actions_by_name
        self._group = QActionGroup(self)
        uses: dict[str, Callable[[], None]] = {
            f"landmarks-{choice.name}": partial(self.use, choice.name) for choice in CHOICES
        }
        uses["landmarks-file"] = self.ask_for_file
        for name in uses:
            self._group.addAction(named[name])
        self._now = named.get(f"landmarks-{first.name}", named[next(iter(uses))])
        self._now.setChecked(True)
        actions.connect(named, uses)

    def use(self, wanted: str) -> None:
        """Find the faces again by a source: its name or a model file; a bad one changes nothing."""
        try:
            chosen = source(wanted)
        except ModelRefused as refusal:
            self._now.setChecked(True)
            self.said.emit(Message(str(refusal)))
            return
        self.wanted = wanted
        self._now = self._group.checkedAction()
        self._files.use(chosen)

    def ask_for_file(self) -> None:
        """Ask for a model that the user brings."""
        dialog = QFileDialog(self._window, tr("A landmark model for cv2.face"))
        dialog.setNameFilter(tr("Models (*.yaml *.dat)"))
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.fileSelected.connect(lambda name: self.use(str(Path(name))))
        dialog.rejected.connect(lambda: self._now.setChecked(True))
        dialog.open()

    def _tell_of_fallback(self) -> None:
        self._files.found.disconnect(self._tell_of_fallback)
        self.said.emit(
            Message(
                tr(
                    "The networks are missing, so landmarks come from the AAM, which is less "
                    "exact. kogao-cli doctor says how to get them."
                )
            )
        )
