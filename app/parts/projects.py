"""Saving and opening projects: actions, dialogs and messages joined."""

from __future__ import annotations

from PySide6.QtCore import QObject, QThreadPool

from .. import actions
from ..controllers.dialogs import Dialogs
from ..controllers.files import Files
from ..controllers.projects import Projects
from ..controllers.saver import Saver
from ..document import Document
from ..views.window import Window


class ProjectsPart(QObject):
    """Builds the controller and joins it to the window."""

    def __init__(
        self,
        document: Document,
        saver: Saver,
        files: Files,
        dialogs: Dialogs,
        window: Window,
        pool: QThreadPool,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._document, self._window = document, window
        self.projects = Projects(document, saver, files, dialogs.guard, pool, self)
        dialogs.take_projects(self.projects)
        actions.connect(window.actions_by_name, {"save-project": self.projects.save})
        self.projects.said.connect(window.bar.say)
        self.projects.working.connect(window.status.hint)
        document.opened.connect(self._show)
        self._show()

    @property
    def busy(self) -> bool:
        """True while a project is read."""
        return self.projects.busy

    def stop(self) -> None:
        """Start nothing more."""
        self.projects.stop()

    def _show(self) -> None:
        named = self._window.actions_by_name
        named["save-project"].setEnabled(self._document.photo is not None)
