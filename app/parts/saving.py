"""What saved copies tell of themselves: the dialog, and who has to know."""

from __future__ import annotations

from PySide6.QtCore import QObject, QSettings

from .. import actions, saving
from ..controllers.files import Files
from ..views.saving import SavingDialog
from ..views.window import Window


class SavingPart(QObject):
    """Joins the save options to `Files`."""

    def __init__(self, files: Files, window: Window, settings: QSettings, parent: QObject) -> None:
        super().__init__(parent)
        self._files, self._window, self._settings = files, window, settings
        actions.connect(window.actions_by_name, {"save-options": self._ask})
        files.wants_options.connect(self._ask)
        files.tell(saving.disclosure(settings))

    def _ask(self) -> None:
        now = saving.disclosure(self._settings)
        dialog = SavingDialog(now, saving.label(self._settings), self._window)
        dialog.chosen.connect(self._take)
        dialog.open()

    def _take(self, record: bool, labelled: bool, label: str) -> None:
        saving.remember(self._settings, record=record, labelled=labelled, label=label)
        self._files.tell(saving.disclosure(self._settings))
