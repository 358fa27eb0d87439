"""The rating session of a study, from the menu to its window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QFileDialog

from kogao_core.strict import BadFile

from .. import actions
from ..controllers.rating import Rating
from ..i18n import tr
from ..theme import Theme
from ..views.bar import Message
from ..views.rating import RatingWindow
from ..views.window import Window


class RatingPart(QObject):
    """Asks for a study's folder and opens its session.

    Parameters
    ----------
    window : Window
        The editor's.
    theme : callable
        Returns the theme of the moment, for its grey.
    parent : QObject
        Owner.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    """

    said = Signal(object)

    def __init__(self, window: Window, theme: Callable[[], Theme], parent: QObject) -> None:
        super().__init__(parent)
        self._window, self._theme = window, theme
        actions.connect(window.actions_by_name, {"rate": self.ask_folder})

    def ask_folder(self) -> None:
        """Ask which study to rate."""
        dialog = QFileDialog(self._window, tr("The folder of a study"))
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.fileSelected.connect(lambda name: self.open(Path(name)))
        dialog.open()

    def open(self, folder: Path) -> RatingWindow | None:
        """Open a study's session; say why a folder holds none."""
        try:
            rating = Rating(folder)
        except BadFile as problem:
            step = tr("Choose a folder that kogao-cli experiment study make has made.")
            self.said.emit(Message(f"{problem}. {step}"))
            return None
        window = RatingWindow(rating, self._theme().canvas, self._window)
        window.show()
        return window
