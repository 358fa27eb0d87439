"""Edits of a photo: saved automatically, saved as a project, and loaded with the photo."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QTimer, Signal

from kogao_core.base.json_reader import BadFile
from kogao_core.faces.face import Face
from kogao_core.photo import Photo
from kogao_core.photo.model import Stamp
from kogao_core.projects import sidecar
from kogao_core.projects.edits import SUFFIX, Edits, own_place, sidecar_of
from kogao_core.projects.project import load, save

from ..document import State, UndoSteps
from ..i18n import reason, sentence, tr
from ..widgets.dialogs import ask_path
from ..widgets.messages import BarAction
from . import preferences
from .faces import Faces
from .feature import Context, Feature
from .files import Files, history
from .files.opening import (
    EarlierWork,
    Opened,
    is_project,
    is_sample,
    places_of,
    stamp_of,
    stamps_of,
    to_keep_beside,
)
from .files.saver import Request, Saver, Then


class _ChangedSince(Exception):
    """The project file changed on disk since the last access by this program."""

    def __init__(self, file: Path) -> None:
        super().__init__(tr("{file} was changed elsewhere.", file=file.name))


@dataclass(frozen=True, slots=True)
class Keeping:
    """Where edits go: beside the photo if possible, or in the user's folder."""

    edits: Edits
    beside: bool


class Projects(Feature):
    """Saves the edits of the open photo after each edit, and reports loaded edits.

    Edits are stored next to the photo. They go to the data folder if the photo's folder is
    read-only, if the file there belongs to another photo, or by preference.
    """

    # (photo: Path): the edits of a photo are saved beside the photo.
    kept = Signal(object)

    def __init__(self, context: Context, saver: Saver, files: Files, faces: Faces) -> None:
        super().__init__(context)
        self._saver, self._files, self._faces = saver, files, faces
        self._keeping = False
        self._told: Path | None = None
        self._resetting = self.lane(self._reset, lambda problem: self.say(sentence(problem)))
        # Stamps at the last access, to detect changes by other programs.
        self._stamps: dict[Path, Stamp | None] = {}
        self.bind("save-project", self.save)
        self.bind("reset-photo", self.reset)
        self.document.undo.indexChanged.connect(lambda _: self.keep())
        # Deferred: the search is busy until this slot returns.
        faces.found.connect(lambda _: QTimer.singleShot(0, self.keep))
        files.resuming.connect(self._know)
        files.restored.connect(self._take_up)
        # Save the edits of a saved copy, to restore the edits with the photo.
        files.saved.connect(lambda _: self.keep(anyway=True))
        saver.offer(files.keep, self.keep, self.save)

    # -- automatic saving ------------------------------------------------------------------------

    def keep(
        self, then: Then | None = None, *, replace: bool = False, anyway: bool = False
    ) -> None:
        """Save the edits; skip the call if a save is in progress, unless a caller waits.

        During face detection the state is incomplete, so no edits are saved.
        """
        path, held_up = self.document.path, self._keeping or self._faces.busy
        if path is None or not self._saver.keeps:
            return
        if then is None and not replace and (held_up or (self.document.saved and not anyway)):
            return
        self.document.commit()
        steps, keeping, state = self.document.steps, self.keeping(path), self.document.committed

        def write(photo: Photo, to_keep: State) -> str:
            return str(self._put(photo, to_keep, steps, keeping, replace))

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
        self._saver.save(sidecar_of(path), write, kept, failed, then, holds="all", quiet=True)

    def keeping(self, path: Path) -> Keeping:
        """Return where the edits of a photo go."""
        apart = is_sample(path) or preferences.preferred(self.settings, preferences.EDITS)
        return Keeping(self.storage.edits, not apart)

    def _put(
        self, photo: Photo, state: State, steps: UndoSteps, keeping: Keeping, replace: bool
    ) -> Path:
        """Save beside the photo or in the user's folder. Raises OSError, _ChangedSince."""
        project, edits, path = to_keep_beside(state, photo), keeping.edits, photo.path
        beside = keeping.beside and edits.holds(path, photo)
        beside = beside and (replace or self._is_ours(sidecar_of(path), photo))
        if not (beside or replace):
            self._is_ours(own_place(path, edits.folder), photo)
        packed = history.packed(steps, (photo.width, photo.height))
        place = edits.keep(project, path, packed, beside=beside)
        self._stamps[place] = stamp_of(place)
        return place

    def _is_ours(self, place: Path, photo: Photo) -> bool:
        """Return True if the file is missing, unchanged since the last access, or of another photo.

        Return False if the file is no project for this photo. Raises _ChangedSince.
        """
        if stamp_of(place) in (None, self._stamps.get(place)):
            return True
        try:
            project = load(place)
            if self.storage.edits.name_in(project, photo) != project.original.sha256:
                return True
            sidecar.match(project, photo.pixels)
        except BadFile:
            return False
        raise _ChangedSince(place)

    def _tell_where(self, path: Path, file: Path) -> None:
        is_apart = file.name != sidecar_of(path).name
        if self.keeping(path).beside and is_apart and path.parent != self._told:
            self._told = path.parent
            text = tr("{name}: edits saved in Kogao's folder", name=path.name)
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
            elsewhere = BarAction(tr("Choose another place…"), self.save)
            self.say(sentence(text), elsewhere, applies=lambda: not self.document.saved)

    # -- as a project ----------------------------------------------------------------------------

    def save(self, then: Then | None = None) -> None:
        """Request a path for the project, write the project, then call `then`."""
        path = self.document.path
        if path is None:
            return
        self._saver.forget()
        file = sidecar_of(path)
        dialog = ask_path(
            self.window,
            tr("Save the project"),
            lambda chosen: self.save_to(chosen, then),
            "new",
            filters=[tr("Projects ({patterns})", patterns=f"*{SUFFIX}")],
            at=Path.home() / file.name if is_sample(path) else file,
        )
        # The name belongs to the open photo only.
        self.document.opened.connect(dialog.reject)

    def save_to(self, file: Path, then: Then | None = None) -> None:
        """Write the project to a file that the dialog may overwrite."""
        self.window.bar.clear()
        elsewhere = BarAction(tr("Choose another place…"), self.save)
        if not is_project(file):
            # The dialog has confirmed the name without the suffix only.
            file = file.with_name(file.name + SUFFIX)
            if os.path.exists(file):
                text = tr("There is another project already: {file}.", file=file.name)
                self.say(text, elsewhere)
                return

        def write(photo: Photo, state: State) -> str:
            save(to_keep_beside(state, photo), file)
            self._stamps[file] = stamp_of(file)
            return ""

        def failed(problem: Exception) -> None:
            text = tr("The project can't be saved there: {problem}", problem=reason(problem))
            self.say(sentence(text), elsewhere)

        self._saver.save(file, write, lambda *_: None, failed, then, holds="all")

    def _know(self, opened: Opened) -> None:
        """Store the stamps of the files for the edits."""
        self._stamps |= opened.stamps

    def adopt(self, path: Path) -> bool:
        """Accept files that this program wrote for the open photo; return True for a new file."""
        before, now = {**self._stamps}, stamps_of(places_of(path, self.storage.edits))
        self._stamps |= now
        return any(before.get(place) != stamp for place, stamp in now.items())

    def follow(self, _: Path, now: Path) -> None:
        """Accept the edits beside a renamed photo, which came along."""
        self._stamps |= stamps_of(places_of(now, self.storage.edits))

    def _take_up(self, work: EarlierWork, note: str) -> None:
        if work.file is None:
            return
        if note:
            self.say(sentence(note))
        elif work.moved_from is None:
            self.did.emit(tr("Edits restored"))
        else:
            text = tr("Edits restored: this photo was {name} before", name=work.moved_from.name)
            self.did.emit(text)

    # -- from the start ----------------------------------------------------------------------------

    def reset(self) -> None:
        """Detect faces again and restore default settings, as one undo step."""
        photo, search = self.document.photo, self._faces.search()
        if photo is not None:
            self.document.commit()
            self.working.emit(tr("Resetting {name}…", name=photo.path.name))
            self._resetting.submit(lambda: (photo, search.run(photo)))

    def _reset(self, found: tuple[Photo, list[Face]]) -> None:
        photo, faces = found
        self.working.emit("")
        if photo is self.document.photo:
            state = State(recipe=self.document.first_recipe).with_found(faces, self.document.image)
            self.document.step(state, tr("Reset photo"))
