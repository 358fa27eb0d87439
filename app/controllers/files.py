"""Opening, finding faces and saving, all in workers; what goes wrong is said in the bar."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, QThreadPool, Signal

from kogao_core import assets
from kogao_core.face import Face, LandmarkSource
from kogao_core.landmarks import template_face
from kogao_core.photo import FORMATS, CannotDisclose, Photo
from kogao_core.photo.disclosure import NOTHING_TOLD, Disclosure
from kogao_core.strict import BadFile

from .. import photos
from ..document import Document
from ..i18n import reason, sentence, tr
from ..projects import Work, state_of
from ..pyramid import Pyramid
from ..views.bar import Message, Step
from ..workers import Lane
from .editing import Editing

_TEMPLATE_SHARE = 0.35  # of the photo's shorter side
_Opened = tuple[Photo, Pyramid, Work | BadFile | None]


class Files(QObject):
    """Moves photos in and out of the document.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    working(str)
        What is under way or has just been done; empty for nothing.
    quiet
        Something is tried now: what was said of the last action no longer holds.
    wants_open, wants_save, wants_options
        A dialog is needed.
    found(int)
        The search for faces is over, with so many.
    not_found(str)
        The search for faces failed, and why; `found(0)` follows.
    unreadable(str)
        The photo that was asked for can't be opened, and why.
    saved(Path)
        A copy has been written.
    wants_leave(callable)
        The old photo was changed while the next one was read: ask before going on so.
    restored(Work)
        What this holds has been taken over.
    """

    said = Signal(object)
    working = Signal(str)
    quiet = Signal()
    wants_open = Signal()
    wants_save = Signal()
    wants_options = Signal()
    found = Signal(int)
    not_found = Signal(str)
    unreadable = Signal(str)
    saved = Signal(object)
    wants_leave = Signal(object)
    restored = Signal(object)

    def __init__(
        self,
        document: Document,
        editing: Editing,
        source: LandmarkSource,
        pool: QThreadPool,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._document, self._editing, self._source = document, editing, source
        # What table 2 calls the setting time of the automatic method.
        self.finding_s: float | None = None
        self._told = NOTHING_TOLD
        self._left = document.state
        self._reading = Lane(pool, self._not_opened, self)
        self._reading.done.connect(self._opened)
        self._finding = Lane(pool, self._not_found, self)
        self._finding.done.connect(self._take_faces)
        self._writing = Lane(pool, self._not_written, self)
        self._writing.done.connect(self._written)

    @property
    def busy(self) -> bool:
        """True while a file or a face is being worked on."""
        return any(lane.busy for lane in (self._reading, self._finding, self._writing))

    def stop(self) -> None:
        """Start nothing more, and forget what is under way."""
        for lane in (self._reading, self._finding, self._writing):
            lane.drop()

    # -- opening ---------------------------------------------------------------------------------

    def open(self, path: Path, work: Work | None = None, *, afresh: bool = False) -> None:
        """Read a photo and go on with what was done to it, or look for faces in it.

        Parameters
        ----------
        path : Path
            The photo.
        work : Work, optional
            What to go on with; what the project beside the photo holds when absent.
        afresh : bool
            Leave that project alone.
        """
        self.quiet.emit()
        self._finding.drop()
        self._reading.drop()
        self._left = self._document.state
        self.working.emit(tr("Opening {name}…", name=path.name))
        self._reading.submit(lambda: photos.opened(path, work, afresh))

    def open_sample(self) -> bool:
        """Open the portrait that travels with the program; return whether it is there."""
        try:
            path = assets.path(photos.SAMPLE)
        except assets.AssetMissing as problem:
            self._not_opened(problem)
            return False
        self.open(path)
        return True

    def welcome(self) -> None:
        """Open the sample and say what to try."""
        if self.open_sample():
            lines = (
                tr("Move the slider “Warp distance”: the face gets smaller."),
                tr("Drag a blue dot to correct the outline, an orange ring to say where it goes."),
                tr("Hold \\ to see the photo as it was."),
            )
            text, steps = "\n".join(lines), (self._open_step(),)
            self.said.emit(Message(text, steps, wrong=False, holds=self._on_sample))

    def _on_sample(self) -> bool:
        path = self._document.path
        return path is None or photos.is_sample(path)

    def _opened(self, opened: _Opened) -> None:
        # Whoever went on with the old photo meanwhile hasn't been asked about that.
        if self._document.in_gesture or self._document.state is not self._left:
            self.working.emit("")
            self.wants_leave.emit(lambda: self._show(opened))
        else:
            self._show(opened)

    def _show(self, opened: _Opened) -> None:
        photo, pyramid, work = opened
        self.finding_s = None
        self._document.open(photo, pyramid)
        if isinstance(work, Work):
            self._go_on_with(work, photo)
            return
        if work is not None:
            text = tr("The photo starts afresh, its project can't be used: {problem}", problem=work)
            self.said.emit(Message(sentence(text)))
        self._look()

    def _go_on_with(self, work: Work, photo: Photo) -> None:
        state = state_of(work.project.at_size(photo.width, photo.height))
        if work.file is None:
            self._editing.step(state, tr("Restore"))
            self.working.emit(tr("The unsaved changes are back"))
        else:
            self._document.begin_with(state)
            self.working.emit("")
        self.restored.emit(work)
        self.found.emit(len(state.faces))

    def _not_opened(self, problem: Exception) -> None:
        self.working.emit("")
        self.said.emit(Message(sentence(problem), (self._open_step(),)))
        self.unreadable.emit(reason(problem))

    # -- faces -----------------------------------------------------------------------------------

    def use(self, source: LandmarkSource) -> None:
        """Take landmarks from another source from now on, and look for faces again."""
        self._source = source
        self.find()

    def find(self) -> None:
        """Look for faces again."""
        self.quiet.emit()
        self._look()

    def _look(self) -> None:
        photo = self._document.photo
        if photo is not None:
            self._finding.drop()
            self.working.emit(tr("Looking for faces…"))
            self._finding.submit(lambda: photos.found(self._source, photo))

    def _take_faces(self, found: tuple[list[Face], float]) -> None:
        faces, self.finding_s = found
        if not faces:
            self._offer_placing(tr("No face was found in this photo."))
        elif self._document.undo.count():
            self._editing.replace_faces(faces)
        else:
            self._document.start_with(faces)
        self.working.emit("")
        self.found.emit(len(faces))

    def _not_found(self, problem: Exception) -> None:
        self._offer_placing(sentence(problem))
        self.working.emit("")
        self.not_found.emit(reason(problem))
        self.found.emit(0)

    def _offer_placing(self, text: str) -> None:
        place = Step(tr("Place a face by hand"), self.place)
        self.said.emit(Message(text, (place, self._open_step())))

    def place(self) -> None:
        """Put a mean face in the middle of the photo, to be dragged into place."""
        image = self._document.image
        if not image.area:
            return
        middle = np.array([image.width, image.height]) / 2.0
        width = _TEMPLATE_SHARE * min(image.width, image.height)
        self._editing.place(lambda: template_face(middle, width))
        done = Step(tr("It fits"), self._editing.end_placing)
        text = tr(
            "Drag the frame onto the face; a corner turns and sizes it. Then drag single points."
        )
        self.said.emit(Message(text, (done,), wrong=False, holds=lambda: self._editing.placing))

    # -- saving ----------------------------------------------------------------------------------

    def suggested(self) -> Path | None:
        """Return a name for a copy beside the original."""
        path = self._document.path
        if path is None:
            return None
        suffix = path.suffix if path.suffix.lower() in FORMATS else ".png"
        return path.with_name(f"{path.stem}_kogao{suffix}")

    def tell(self, told: Disclosure) -> None:
        """Let saved copies tell this of themselves."""
        self._told = told

    def save(self, path: Path) -> None:
        """Render the photo at its own depth and write it; the original is refused."""
        photo, original = self._document.photo, self._document.path
        if photo is None or original is None:
            return
        self.quiet.emit()
        if path.exists() and original.exists() and path.samefile(original):
            self._refuse(tr("That is the original; it is never written over."))
            return
        if self._writing.busy:
            self._refuse(tr("Another copy is still being written; save again when it is done."))
            return
        self._editing.commit()
        state, step, told = self._document.state, self._document.undo.index(), self._told

        def job() -> tuple[Path, int, Photo, str]:
            return path, step, photo, photos.saved(photo, state, told, path)

        self.working.emit(tr("Saving {name}…", name=path.name))
        self._writing.submit(job)

    def _written(self, written: tuple[Path, int, Photo, str]) -> None:
        path, step, photo, said = written
        if self._document.photo is photo and self._document.undo.index() == step:
            self._document.undo.setClean()
        text = tr("Saved {name}", name=path.name)
        self.working.emit(text)
        self.said.emit(Message(f"{sentence(text)} {said}".strip(), wrong=False))
        self.saved.emit(path)

    def _not_written(self, problem: Exception) -> None:
        self.working.emit("")
        if isinstance(problem, CannotDisclose):
            options = Step(tr("Save options…"), self.wants_options.emit)
            self.said.emit(Message(sentence(problem), (options,)))
        else:
            self._refuse(sentence(problem))

    def _refuse(self, text: str) -> None:
        self.said.emit(Message(text, (Step(tr("Choose another name…"), self.wants_save.emit),)))

    def _open_step(self) -> Step:
        return Step(tr("Open a photo…"), self.wants_open.emit)
