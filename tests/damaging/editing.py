"""A short visit to the editor, without a screen: a program that `child` can run.

Arguments are steps, each of one word and a file: ``open``, ``paste``
(settings, from the clipboard) and ``restore`` (what a crash has left). Python and Qt tell on stderr
what they weren't asked to bear, and so does a job that failed with anything but a refusal of ours.
"""

from __future__ import annotations

import gc
import logging
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from kogao_app.editor import Editor
from kogao_app.faults import LOG
from kogao_app.storage import Storage
from PySide6.QtCore import QEvent
from PySide6.QtWidgets import QApplication, QDialog
from scenes import oval_face

from kogao_core.faces.face import Face, OnFace, ignored

HOME = "home"


class KnownFace:
    """A landmark source that finds the same face in every photo."""

    name = "known"

    def __init__(self, face: Face) -> None:
        self._face = face

    def find(self, rgb: object, on_face: OnFace = ignored) -> list[Face]:  # noqa: ARG002
        on_face(self._face)
        return [self._face]


class Unforeseen(logging.StreamHandler):
    """Prints what jobs of the editor raised, except for refusals, which are sentences."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record is printed."""
        problem = record.exc_info and record.exc_info[1]
        return not type(problem).__module__.startswith("kogao_core.")


LOG.addHandler(Unforeseen())


class Visit:
    """An editor with its home in the folder it is started in."""

    def __init__(self) -> None:
        self._app = QApplication.instance() or QApplication([])
        self.editor = Editor(self._app, KnownFace(oval_face(60, 80, size=0.5)),
                             Storage.in_folder(Path(HOME)))  # fmt: skip
        self.editor.window.show()
        self._settle()

    def step(self, word: str, file: Path) -> None:
        """Do one thing and wait for its end."""
        steps: dict[str, Callable[[Path], object]] = {
            "open": self.editor.files.open,
            "paste": self._paste,
            "restore": self._restore,
        }
        steps[word](file)
        self._settle()

    @property
    def opened(self) -> bool:
        """Whether a photo is open."""
        return self.editor.document.photo is not None

    @property
    def told(self) -> bool:
        """Whether the bar says something, or a dialog asks."""
        dialogs = self.editor.window.findChildren(QDialog)
        return self.editor.window.bar.isVisible() or any(one.isVisible() for one in dialogs)

    def end(self) -> None:
        """Close everything, so that the next visit finds nothing of it."""
        for dialog in self.editor.window.findChildren(QDialog):
            dialog.close()
        self.editor.close()
        self.editor.window.deleteLater()
        self.editor.deleteLater()
        self._app.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        gc.collect()

    def _paste(self, file: Path) -> None:
        self._app.clipboard().setText(file.read_bytes().decode("utf-8", "replace"))
        self.editor.recipe.paste()

    def _restore(self, _: Path) -> None:
        self.editor.recovery.look()
        self._settle()
        for button in self.editor.window.bar.buttons:
            if "Restore" in button.text():
                button.click()

    def _settle(self) -> None:
        self._app.processEvents()
        while self.editor.busy:
            time.sleep(0.001)
            self._app.processEvents()


def main(arguments: list[str]) -> None:
    """Take the steps and exit: 0 where a photo is open in the end, 3 where none is."""
    visit = Visit()
    for word, file in zip(arguments[::2], arguments[1::2], strict=True):
        visit.step(word, Path(file))
    opened, told = visit.opened, visit.told
    visit.end()
    if not opened and not told:
        sys.exit("nothing was opened, and nothing said")
    sys.exit(0 if opened else 3)
