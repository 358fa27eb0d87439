"""The project file of the open photo: written beside it, and taken up again with it."""

from __future__ import annotations

import os
from pathlib import Path

from kogao_core.photo import Photo
from kogao_core.photo.model import Stamp
from kogao_core.projects import sidecar
from kogao_core.projects.project import save

from ..document import State
from ..i18n import reason, sentence, tr
from ..widgets.dialogs import ask_path
from ..widgets.messages import BarAction
from .feature import Context, Feature
from .files import Files
from .files.opening import EarlierWork, is_project, is_sample, to_keep_beside
from .files.saver import Request, Saver, Then


class _ChangedSince(Exception):
    """Somebody else has written the project since it was read or written here."""


class Projects(Feature):
    """Saves what was done to the open photo, and says what has come back with it."""

    def __init__(self, context: Context, saver: Saver, files: Files) -> None:
        super().__init__(context)
        self._saver, self._files = saver, files
        # What was read from there, or written there, may be written over without a question.
        self._own: Path | None = None
        # As it was then; whoever writes looks, one after the other.
        self._stamps: dict[Path, Stamp | None] = {}
        self.add_action(
            "save-project",
            tr("Save pro&ject"),
            "Ctrl+Alt+P",
            tr("Keep points and settings beside the photo, to go on with another time"),
            self.save,
            needs_photo=True,
        )
        self.document.opened.connect(self._forget)
        files.restored.connect(self._take_up)

    def save(self, then: Then | None = None) -> None:
        """Write the project beside its photo; ask where that isn't ours to write."""
        path = self.document.path
        if path is None:
            return
        file = self._own or sidecar.sidecar_of(path)
        if is_sample(path) and self._own is None:
            self._ask_place(Path.home() / file.name, then)
        else:
            self.save_to(file, then)

    def save_to(self, file: Path, then: Then | None = None, *, replace: bool = False) -> None:
        """Write the project to a file; one that isn't this photo's own is replaced if told to."""
        self.window.bar.clear()
        if not is_project(file):
            file, replace = file.with_name(file.name + sidecar.SUFFIX), False
        if os.path.exists(file) and file != self._own and not replace:
            text = tr("There is another project already: {file}.", file=file.name)
            self._ask_replace(file, text)
            return

        def write(photo: Photo, state: State) -> str:
            now = _stamp(file)
            if not replace and now not in (None, self._stamps.get(file)):
                raise _ChangedSince
            save(to_keep_beside(state, photo), file)
            self._stamps[file] = _stamp(file)
            return ""

        def failed(problem: Exception) -> None:
            if isinstance(problem, _ChangedSince):
                self._ask_replace(file, tr("{file} was changed elsewhere.", file=file.name))
            else:
                self._not_written(problem)

        self._saver.save(file, write, self._written, failed, then, whole=True)

    def _ask_replace(self, file: Path, why: str) -> None:
        instead = BarAction(tr("Replace it"), lambda: self.save_to(file, replace=True))
        self.say(why, instead, self._elsewhere(file))

    def _ask_place(self, suggested: Path, then: Then | None) -> None:
        self._saver.forget()
        dialog = ask_path(
            self.window,
            tr("Save the project"),
            # The dialog has asked before replacing a file.
            lambda path: self.save_to(path, then, replace=True),
            "new",
            filters=[tr("Projects ({patterns})", patterns=f"*{sidecar.SUFFIX}")],
            at=suggested,
        )
        # The name is for the photo that is open now, and for no other.
        self.document.opened.connect(dialog.reject)

    def _written(self, request: Request, _: str) -> None:
        if self.document.photo is request.photo:
            self._own = request.file

    def _not_written(self, problem: Exception) -> None:
        path = self.document.path
        text = tr("The project can't be saved there: {problem}", problem=reason(problem))
        steps = () if path is None else (self._elsewhere(sidecar.sidecar_of(path)),)
        self.say(sentence(text), *steps)

    def _elsewhere(self, file: Path) -> BarAction:
        return BarAction(tr("Choose another place…"), lambda: self._ask_place(file, None))

    def _forget(self) -> None:
        self._own = None

    def _take_up(self, work: EarlierWork, note: str) -> None:
        if work.file is None:
            return
        self._own = work.file
        self._stamps[work.file] = _stamp(work.file)
        lines = [tr("Your work on this photo is back, from {file}.", file=work.file.name)]
        if note:
            lines.append(sentence(note))
        afresh = BarAction(tr("Start afresh"), lambda: self._saver.guard(self._start_afresh))
        self.say("\n".join(lines), afresh, wrong=bool(note))

    def _start_afresh(self) -> None:
        path = self.document.path
        if path is not None:
            self._files.read(path, afresh=True)


def _stamp(file: Path) -> Stamp | None:
    try:
        return Stamp.of(file.stat())
    except OSError:
        return None
