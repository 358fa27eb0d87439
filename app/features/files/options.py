"""Asks what saved pictures tell about themselves, and keeps the answer."""

from __future__ import annotations

from kogao_core.photo.disclosure import NO_DISCLOSURE, Disclosure

from ...actions import Spec
from ...i18n import tr
from ..feature import Context, Feature
from .saving_dialog import SavingDialog
from .told import Told


class SaveOptions(Feature):
    """Asks what saved copies tell of themselves, and keeps the answer."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._asked = False
        self.add_actions(
            Spec(
                "save-options",
                tr("Save opt&ions…"),
                "Ctrl+Alt+O",
                tr("What saved pictures tell of themselves"),
                self.ask,
            )
        )

    @property
    def current(self) -> Disclosure:
        """What saved copies tell of themselves."""
        return Told.remembered(self.settings).disclosure

    @property
    def in_place(self) -> Disclosure:
        """What a photo tells that is written over: nothing, unless chosen since the start."""
        return self.current if self._asked else NO_DISCLOSURE

    def ask(self) -> None:
        """Show the dialog."""
        dialog = SavingDialog(Told.remembered(self.settings), self.window)
        dialog.chosen.connect(self._take)
        dialog.open()

    def _take(self, told: Told) -> None:
        self._asked = True
        told.remember(self.settings)
