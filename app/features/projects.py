"""What is done to a photo: kept by itself, saved as a project, and taken up again with it."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QTimer, Signal

from kogao_core.base.strict import BadFile
from kogao_core.photo import Photo
from kogao_core.photo.model import Stamp
from kogao_core.projects import sidecar
from kogao_core.projects.project import load, save

from ..document import State, UndoSteps
from ..i18n import reason, sentence, tr
from ..widgets.dialogs import ask_path
from ..widgets.messages import BarAction
from . import preferences
from .faces import Faces
from .feature import Context, Feature
from .files import Files, history
from .files.opening import EarlierWork, is_project, is_sample, to_keep_beside
from .files.saver import Request, Saver, Then


class _ChangedSince(Exception):
    """Somebody else has written the project since it was read or written here."""

    def __init__(self, file: Path) -> None:
        super().__init__(tr("{file} was changed elsewhere.", file=file.name))


class Projects(Feature):
    """Keeps what is done to the open photo after each step, and says what has come back with it.

    Edits lie beside the photo; in the user's own folder where that can't be written, where what
    lies there is no project of this photo, and where the user prefers it.
    """

    kept = Signal(object)

    def __init__(self, context: Context, saver: Saver, files: Files, faces: Faces) -> None:
        super().__init__(context)
        self._saver, self._files, self._faces = saver, files, faces
        self._keeping = False
        self._told: Path | None = None
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
        self.document.undo.indexChanged.connect(lambda _: self.keep())
        # The search counts as under way until this is over.
        faces.found.connect(lambda _: QTimer.singleShot(0, self.keep))
        files.resuming.connect(self._know)
        files.restored.connect(self._take_up)
        # What a copy was made with is there again with the photo.
        files.saved.connect(lambda _: self.keep(anyway=True))
        saver.offer(files.keep, self.keep, self._ask_elsewhere)

    # -- by itself -------------------------------------------------------------------------------

    def keep(
        self, then: Then | None = None, *, replace: bool = False, anyway: bool = False
    ) -> None:
        """Write the edits where they are kept; one write at a time, unless something waits for it.

        While faces are sought, the state lacks some of them.
        """
        path, held_up = self.document.path, self._keeping or self._faces.busy
        if path is None or not self._saver.keeps:
            return
        if then is None and not replace and (held_up or (self.document.saved and not anyway)):
            return
        self.document.commit()
        steps, places, state = self.document.steps, self.places(path), self.document.committed

        def write(photo: Photo, to_keep: State) -> str:
            return str(self._put(photo, to_keep, steps, places, replace))

        def kept(request: Request, file: str) -> None:
            self._keeping = False
            self._tell_where(request.photo.path, Path(file))
            self.kept.emit(request.photo.path)
            if self.document.committed is not state:
                self.keep()

        def failed(problem: Exception) -> None:
            self._keeping = False
            self._say_not_kept(path, problem)
            if then is not None and self.document.path == path:
                self._saver.ask(then, sentence(problem))

        self._keeping = True
        self._saver.save(places[0], write, kept, failed, then, holds="all", quiet=True)

    def places(self, path: Path) -> list[Path]:
        """Return where the edits of a photo may be kept, the user's own folder last."""
        own = sidecar.own_place(path, self.storage.edits)
        apart = is_sample(path) or preferences.preferred(self.settings, preferences.EDITS)
        return [own] if apart else [sidecar.sidecar_of(path), own]

    def _put(
        self, photo: Photo, state: State, steps: UndoSteps, places: list[Path], replace: bool
    ) -> Path:
        """Write to the first of the places that can be written. Raises OSError, _ChangedSince."""
        project = to_keep_beside(state, photo)
        for place in places:
            last = place == places[-1]
            if not (replace or self._is_ours(place, photo) or last):
                continue
            try:
                if last:
                    self.storage.edits.mkdir(parents=True, exist_ok=True)
                save(project, place)
                break
            except OSError:
                if last:
                    raise
        self._stamps[place] = _stamp(place)
        with suppress(OSError):  # the edits are there
            self.storage.edits.mkdir(parents=True, exist_ok=True)
            history.write(photo, self.storage.edits, steps)
        return place

    def _is_ours(self, place: Path, photo: Photo) -> bool:
        """Return whether a place is free, or holds what is known; not if it's no project of this.

        Raises _ChangedSince.
        """
        if _stamp(place) in (None, self._stamps.get(place)):
            return True
        try:
            sidecar.match(load(place), photo.pixels)
        except BadFile:
            return False
        raise _ChangedSince(place)

    def _tell_where(self, path: Path, file: Path) -> None:
        wanted = self.places(path)[0]
        if file != wanted and path.parent != self._told:
            self._told = path.parent
            text = tr("Edits of {name} are kept in a folder of your own", name=path.name)
            self.did.emit(text)

    def _say_not_kept(self, path: Path, problem: Exception) -> None:
        if self.document.path != path:
            return
        if isinstance(problem, _ChangedSince):
            steps = (
                BarAction(tr("Keep mine"), lambda: self.keep(replace=True)),
                BarAction(tr("Take theirs"), lambda: self._files.read(path)),
            )
            self.say(str(problem), *steps, applies=lambda: self.document.path == path)
        else:
            text = tr("The edits can't be kept: {problem}", problem=reason(problem))
            elsewhere = self._elsewhere(sidecar.sidecar_of(path))
            self.say(sentence(text), elsewhere, applies=lambda: not self.document.saved)

    def _ask_elsewhere(self, then: Then) -> None:
        path = self.document.path
        if path is not None:
            self._ask_place(sidecar.sidecar_of(path), then)

    # -- as a project ----------------------------------------------------------------------------

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
        known = file == self._own or _stamp(file) == self._stamps.get(file)
        if os.path.exists(file) and not (known or replace):
            text = tr("There is another project already: {file}.", file=file.name)
            self._ask_replace(file, text)
            return

        def write(photo: Photo, state: State) -> str:
            now = _stamp(file)
            if not replace and now not in (None, self._stamps.get(file)):
                raise _ChangedSince(file)
            save(to_keep_beside(state, photo), file)
            self._stamps[file] = _stamp(file)
            return ""

        def failed(problem: Exception) -> None:
            if isinstance(problem, _ChangedSince):
                self._ask_replace(file, str(problem))
            else:
                self._not_written(problem)

        self._saver.save(file, write, self._written, failed, then, holds="all")

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

    def _know(self, work: EarlierWork) -> None:
        """Note what lies where the work comes from, before anything is written there."""
        path = self.document.path
        places = [] if path is None else self.places(path)
        elsewhere = work.file is not None and work.file not in places
        for place in [work.file] if work.file is not None and elsewhere else places:
            self._stamps[place] = _stamp(place)
        if elsewhere:
            self._own = work.file

    def _take_up(self, work: EarlierWork, note: str) -> None:
        if work.file is None:
            return
        lines = [tr("Your edits of this photo are back.")]
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
