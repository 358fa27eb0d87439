"""Rating studies: start the local server and open the page in the browser."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices, QGuiApplication

from kogao_core.base.json_reader import BadFile
from kogao_core.base.wording import system_reason
from kogao_core.lab.study.server import Server

from ...actions import Item
from ...i18n import tr
from ...widgets.dialogs import ask_path
from ...widgets.messages import BarAction
from ..feature import Context, Feature


class Rating(Feature):
    """Requests the folder of a study, serves the page and opens a browser."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._server: Server | None = None
        self.bind(
            Item(
                "rate",
                "&Rate pictures…",
                "Ctrl+R",
                "Rate the naturalness of faces (table 1, figure 11)",
            ),
            self._ask_folder,
        )

    def _ask_folder(self) -> None:
        ask_path(self.window, tr("The folder of a study"), self.open, "folder")

    def open(self, folder: Path) -> None:
        """Open the page of a study, or show why the folder has no page."""
        self.window.bar.clear()
        try:
            server = Server(folder)
        except BadFile as problem:
            step = tr("Choose a folder made by kogao-cli experiment study make.")
            self.say(f"{problem}. {step}")
            return
        except OSError as problem:
            reason = system_reason(problem)
            self.say(tr("The page can't be served: {reason}.", reason=reason))
            return
        self.stop()
        self._server = server
        server.start()
        self._browse(server.address)

    def stop(self) -> None:
        """Stop the server; all answers are already saved."""
        if self._server is not None:
            self._server.stop()
            self._server = None

    def _browse(self, address: str) -> None:
        if QDesktopServices.openUrl(QUrl(address)):
            text = tr("The study is open in your browser until Kogao is closed.")
            self.say(text, wrong=False)
            return
        copy = BarAction(
            tr("Copy the address"), lambda: QGuiApplication.clipboard().setText(address)
        )
        text = tr("No browser could be started. Open {address} in a browser.", address=address)
        self.say(text, copy)
