"""``--screenshot``: load, render, take a picture of the window, exit."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject, QTimer

from .actions import overlay_action
from .editor import Editor
from .layers import layers

UNREADABLE: Final = 3
NO_FACE: Final = 4


class Screenshot(QObject):
    """Waits for the editor to settle and photographs it.

    Parameters
    ----------
    editor : Editor
        Whose window; it is closed at the end, and with it the application.
    path : Path
        Where the picture goes.
    """

    def __init__(self, editor: Editor, path: Path) -> None:
        super().__init__(editor)
        self._editor, self._path = editor, path
        self._code, self._line = 0, ""
        for layer in layers():
            editor.window.actions_by_name[overlay_action(layer.name)].setChecked(True)
        editor.files.unreadable.connect(self._give_up)
        editor.files.found.connect(self._look)
        editor.live.settled.connect(self._take)
        self._found = False

    def finish(self) -> int:
        """Print what went wrong, if anything, and return the exit code."""
        if self._line:
            print(f"kogao: {self._line}", file=sys.stderr)
        return self._code

    def _look(self, faces: int) -> None:
        self._found = True
        if not faces:
            self._end(NO_FACE, f"no face in {self._editor.document.path}")
        if not self._editor.live.busy:
            self._take()

    def _take(self) -> None:
        if self._found:
            # The last signals must reach the panels first.
            QTimer.singleShot(0, self._shoot)

    def _shoot(self) -> None:
        if not self._editor.window.grab().save(str(self._path)):
            self._end(
                UNREADABLE, f"{self._path} can't be written; choose another name ending in .png"
            )
        self._editor.close()

    def _give_up(self, reason: str) -> None:
        self._end(UNREADABLE, reason)
        self._editor.close()

    def _end(self, code: int, line: str) -> None:
        self._code, self._line = code, line
