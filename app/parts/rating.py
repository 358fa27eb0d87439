"""A study's pictures to rate, from the menu to the page in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QUrl, Signal
from PySide6.QtGui import QDesktopServices, QGuiApplication
from PySide6.QtWidgets import QFileDialog

from kogao_core.strict import BadFile

from .. import actions
from ..i18n import tr
from ..views.bar import Message, Step
from ..views.window import Window

if TYPE_CHECKING:
    from kogao_core.experiments.study.server import Server


class RatingPart(QObject):
    """Asks for a study's folder, serves its page and opens it.

    Parameters
    ----------
    window : Window
        The editor's.
    parent : QObject
        Owner.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    """

    said = Signal(object)

    def __init__(self, window: Window, parent: QObject) -> None:
        super().__init__(parent)
        self._window = window
        self._server: Server | None = None
        actions.connect(window.actions_by_name, {"rate": self.ask_folder})

    def ask_folder(self) -> None:
        """Ask which study to rate."""
        dialog = QFileDialog(self._window, tr("The folder of a study"))
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.fileSelected.connect(lambda name: self.open(Path(name)))
        dialog.open()

    def open(self, folder: Path) -> None:
        """Open a study's page in the browser; say why a folder has none."""
        from kogao_core.experiments.study.server import Server

        try:
            server = Server(folder)
        except BadFile as problem:
            step = tr("Choose a folder that kogao-cli experiment study make has made.")
            self.said.emit(Message(f"{problem}. {step}"))
            return
        except OSError as problem:
            reason = problem.strerror or str(problem)
            self.said.emit(Message(tr("The page can't be served: {reason}.", reason=reason)))
            return
        self.stop()
        self._server = server
        server.start()
        self._browse(server.address)

    def stop(self) -> None:
        """Serve no more; every answer is on the disk already."""
        if self._server is not None:
            self._server.stop()
            self._server = None

    def _browse(self, address: str) -> None:
        if QDesktopServices.openUrl(QUrl(address)):
            text = tr("The study is open in your browser, for as long as Kogao runs.")
            self.said.emit(Message(text, wrong=False))
            return
        copy = Step(tr("Copy the address"), lambda: QGuiApplication.clipboard().setText(address))
        text = tr("No browser could be opened. Open {address} in one.", address=address)
        self.said.emit(Message(text, (copy,)))
