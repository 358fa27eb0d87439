"""Every save of the open photo, as a copy or as a project: one owner, one request each.

What a copy will need of the photo's own file is read before, while nobody waits for it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final, get_args

from PySide6.QtCore import QThreadPool
from PySide6.QtWidgets import QMessageBox

from kogao_core.photo import FORMATS, Photo, read_ahead
from kogao_core.projects.project import Mode

from ...document import Saving, State
from ...i18n import tr
from ...widgets.dialogs import question
from ...workers import Lane
from ..faces import Faces
from ..feature import Context, Feature

Then = Callable[[], object]
# Of memory, for as long as the photo is open: 26 megapixels of a JPEG at 4:4:4, 53 at 4:2:0.
MOST_BYTES: Final = 160_000_000
_SAMPLE_BYTES: Final = 2


@dataclass(frozen=True, eq=False)
class Request:
    """One save: what is written, where, and what comes after it."""

    photo: Photo  # the photo that was open
    saving: Saving  # what the file will hold
    file: Path  # where it goes
    # What the user wanted to do once everything is saved: close, or open another photo.
    then: Then | None


class Saver(Feature):
    """Writes one request after the other, in the order they were made, and guards unsaved changes.

    A request holds the committed state of the moment it was made in. Once written it marks what
    the file holds of that state as saved, and of no other. What comes after it asks again before
    anything is lost; it is forgotten when the save fails, when the user wants something else
    meanwhile, and when another photo is open by then.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        # One thread of its own: a slow disk holds nobody else up, and the order stays.
        self._one_thread = QThreadPool(self)
        self._one_thread.setMaxThreadCount(1)
        self._requests: dict[Request, Lane] = {}
        self._goes_on: Request | None = None
        self._save_copy: Callable[[Then | None], object] = lambda _: None
        self._save_project: Callable[[Then | None], object] = lambda _: None

    def offer(
        self, copy: Callable[[Then | None], object], project: Callable[[Then | None], object]
    ) -> None:
        """Take what the question offers: both save, then do what was to follow."""
        self._save_copy, self._save_project = copy, project

    @property
    def busy(self) -> bool:
        """True while something is written or waits for it."""
        return bool(self._requests)

    def stop(self) -> None:
        """Tell nobody how saving goes."""
        for lane in self._requests.values():
            lane.drop()

    def finish(self) -> None:
        """Write what was asked for."""
        self._one_thread.waitForDone()

    def guard(self, then: Then) -> None:
        """Do `then` at once, or after the user has saved or discarded unsaved changes."""
        self.forget()
        if not self.document.dirty:
            then()
            return
        buttons = QMessageBox.StandardButton
        box = question(self.window, tr("Save before the changes are lost?"))
        lines = [
            tr("A copy is the finished picture; a project keeps points and settings to go on with.")
        ] * self.actions["save-project"].isVisible()
        if self.document.state.draft:
            lines.append(tr("Points of a face that isn't complete yet are in neither."))
        box.setInformativeText("\n".join(lines))
        box.setStandardButtons(buttons.Save | buttons.Discard | buttons.Cancel)
        box.button(buttons.Save).setText(self.actions["save"].text())
        box.button(buttons.Save).clicked.connect(lambda: self._save_copy(then))
        box.button(buttons.Discard).clicked.connect(lambda: then())
        if self.actions["save-project"].isVisible():
            project = box.addButton(tr("Save &project"), QMessageBox.ButtonRole.AcceptRole)
            project.clicked.connect(lambda: self._save_project(then))
        box.setDefaultButton(buttons.Save)
        # It was asked about the photo that was open.
        self.document.opened.connect(box.reject)
        box.open()

    def forget(self) -> None:
        """Only save: the user wants something else than what was to come after."""
        self._goes_on = None

    def save(
        self,
        file: Path,
        write: Callable[[Photo, State], str],
        saved: Callable[[Request, str], object],
        failed: Callable[[Exception], object],
        then: Then | None = None,
        *,
        whole: bool = False,
    ) -> None:
        """End the gesture in hand and write the committed state."""
        photo = self.document.photo
        if photo is None:
            return
        self.document.commit()
        # Points of a face that isn't one yet are in no file.
        state = dataclasses.replace(self.document.committed, draft=())
        modes: tuple[Mode, ...] = get_args(Mode) if whole else (state.mode,)
        request = Request(photo, self.document.begin_saving(state, modes), file, then)
        lane = self._requests[request] = Lane(
            self._one_thread,
            lambda problem: self._end(request, lambda: failed(problem), False),
            self,
        )
        lane.done.connect(lambda notes: self._end(request, lambda: saved(request, notes), True))
        self._goes_on = request
        self.working.emit(tr("Saving {name}…", name=file.name))
        lane.submit(lambda: write(photo, state))

    def _end(self, request: Request, report: Callable[[], object], written: bool) -> None:
        self._requests.pop(request).deleteLater()
        self.document.end_saving(request.saving, written=written)
        then = request.then if request is self._goes_on else None
        if written:
            self.did.emit(tr("Saved {name}", name=request.file.name))
        else:
            self.working.emit("")
        report()
        if written and then is not None and self.document.photo is request.photo:
            self._goes_on = None
            self.guard(then)


class ReadAhead(Feature):
    """Reads ahead of saving, once faces are known; forgets it when another photo is opened."""

    def __init__(self, context: Context, faces: Faces) -> None:
        super().__init__(context)
        self._known: tuple[Photo, object] | None = None
        # Whoever saves tries again, and hears of it.
        self._reading = self.lane(self._take, lambda _: None)
        self.document.opened.connect(self._forget)
        faces.found.connect(self._read)

    def of(self, photo: Photo) -> object | None:
        """Return what was read of a photo; None where nothing was, or not yet."""
        known = self._known
        return known[1] if known is not None and known[0] is photo else None

    def _forget(self) -> None:
        self._reading.drop()
        self._known = None

    def _read(self, faces: int) -> None:
        photo = self.document.photo
        if not faces or photo is None or self.of(photo) is not None:
            return
        if _bytes_of(photo) <= MOST_BYTES:
            folder = self.storage.data
            self._reading.submit(lambda: (photo, _read(photo, folder)))

    def _take(self, known: tuple[Photo, object]) -> None:
        self._known = known


def _bytes_of(photo: Photo) -> int:
    """Return how much memory the coefficients of a photo take."""
    shares = {1: 2.0, 2: 1.5}  # of the luma, by Pillow's number of the subsampling
    samples = (
        1.0 if photo.channels == 1 else shares.get(photo.jpeg.subsampling if photo.jpeg else 0, 3.0)
    )
    return round(_SAMPLE_BYTES * samples * photo.width * photo.height)


def _read(photo: Photo, folder: Path) -> object:
    """Read in a worker; what has to be a file for a moment lies in a folder of the editor."""
    suffix = next((ending for ending, name in FORMATS.items() if name == photo.format), None)
    if suffix is None:
        return None
    folder.mkdir(parents=True, exist_ok=True)
    return read_ahead(photo, folder / f"copy{suffix}")
