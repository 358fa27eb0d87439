"""``--screenshot``: load, render, take a picture of the window, exit."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import Final, get_args

from PySide6.QtCore import QCoreApplication, QObject, QTimer

from kogao_core.base.atomic import put
from kogao_core.base.geometry import Box
from kogao_core.base.wording import sentence, system_reason
from kogao_core.warp.limits import OutOfBounds, check_protection

from .canvas.overlays.listed import LISTED
from .editor import Editor
from .i18n import reason
from .render.pictures import encoded
from .view_state import CompareName, ToolName

_JAW: Final = 15
FAILED: Final = 1
USAGE: Final = 2
UNREADABLE: Final = 3
NO_FACE: Final = 4


def names() -> frozenset[str]:
    """Return the names of all overlays, ways to compare and tools that a picture can show."""
    overlays = (overlay.name for overlay in LISTED)
    return frozenset({*overlays, *get_args(CompareName), *get_args(ToolName), "loupe"} - {"off"})


class Screenshot(QObject):
    """Waits for the editor to settle and photographs it."""

    def __init__(
        self,
        editor: Editor,
        path: Path,
        show: frozenset[str] | None = None,
        percent: float | None = None,
        protect: tuple[tuple[float, float], ...] | None = None,
    ) -> None:
        super().__init__(editor)
        self._editor, self._path, self._percent, self._protect = editor, path, percent, protect
        self._code, self._line = 0, ""
        editor.saver.keeps = False  # whoever looks at a photo edits nothing
        if show is not None:
            editor.marks.show_all()
            self._show(show)
        editor.files.unreadable.connect(self._give_up)
        editor.files.wants_photo.connect(
            lambda file: self._give_up(f"the photo of {file} isn't beside it; put it there")
        )
        editor.faces.not_found.connect(lambda why: self._end(FAILED, f"no face was found: {why}"))
        editor.live.failed.connect(self._not_drawn)
        editor.surroundings.not_seen.connect(self._fail)
        editor.faces.found.connect(self._arrive)
        editor.live.settled.connect(self._take)
        editor.surroundings.seen.connect(self._take)
        self._found = self._over = False

    def finish(self) -> int:
        """Print what went wrong, if anything, and return the exit code."""
        if self._line:
            print(f"kogao: {sentence(self._line)}", file=sys.stderr)
        return self._code

    def _arrive(self, faces: int) -> None:
        self._found = True
        if not faces and not self._code:
            self._end(NO_FACE, f"no face in {self._editor.document.path}")
        self._edit()
        if not self._editor.live.busy:
            self._take()

    def _show(self, shown: frozenset[str]) -> None:
        for name, action in self._editor.window.actions_by_name.items():
            kind, _, what = name.partition("-")
            if kind == "overlay" or (kind == "compare" and what in get_args(CompareName)):
                action.setChecked(what in shown)
            elif kind == "tool" and what in shown:
                action.trigger()
        self._editor.window.actions_by_name["loupe"].setChecked("loupe" in shown)

    def _edit(self) -> None:
        state, photo = self._editor.document.state, self._editor.document.photo
        if self._percent is not None:
            state = state.with_choices(None, percent=self._percent)
        if self._protect is not None and photo is not None:
            radius = self._editor.view.brush.radius_px
            protection = state.protection.with_stroke(self._protect, radius)
            try:
                check_protection(protection, Box.of(photo.pixels))
            except OutOfBounds as problem:
                self._fail(reason(problem), USAGE)
                return
            state = dataclasses.replace(state, protection=protection)
        if state is not self._editor.document.state:
            self._editor.document.restore(state)
        if state.faces:
            # The loupe needs a cursor: on the jaw, where most moves.
            self._editor.view.cursor = state.faces[0].outline[_JAW]

    def _take(self) -> None:
        if self._found:
            # The last signals must reach the panels first.
            QTimer.singleShot(0, self._shoot)

    def _shoot(self) -> None:
        if self._over or self._editor.live.busy or self._editor.surroundings.busy:
            return  # it takes the picture when they are done
        # Layouts that follow the last figures are under way.
        QCoreApplication.sendPostedEvents()
        try:
            put(encoded(self._editor.window.grab(), self._path.suffix), self._path)
        except OSError as error:
            why = system_reason(error)
            self._end(
                UNREADABLE,
                f"{self._path} can't be written ({why}); choose another name ending in .png",
            )
        self._leave()

    def admit(self, why: str) -> None:
        """End without a picture: something has failed that nobody expected."""
        self._fail(f"something went wrong in the program itself ({why}); please report it")

    def _not_drawn(self, problem: Exception) -> None:
        self._fail(f"{self._editor.document.path} can't be rendered: {reason(problem)}")

    def _fail(self, line: str, code: int = FAILED) -> None:
        self._end(code, line)
        self._leave()

    def _give_up(self, why: str) -> None:
        self._fail(why, UNREADABLE)

    def _leave(self) -> None:
        self._over = True
        self._editor.close()

    def _end(self, code: int, line: str) -> None:
        self._code, self._line = code, line
