"""Opening, finding faces and saving copies, in workers; what goes wrong is said in the bar."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, QThreadPool, Signal

from kogao_core import assets
from kogao_core.face import Face, LandmarkSource
from kogao_core.landmarks import template_face
from kogao_core.photo import FORMATS, CannotDisclose, Photo
from kogao_core.photo.disclosure import NO_DISCLOSURE, Disclosure
from kogao_core.strict import BadFile

from .. import photos
from ..document import Document, State
from ..i18n import reason, sentence, tr
from ..projects import Work, state_of
from ..pyramid import Pyramid
from ..views.bar import Message, Step
from ..workers import Lane
from .editing import Editing
from .saver import Request, Saver, Then

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
    wants_leave = Signal(object)
    restored = Signal(object)

    def __init__(
        self,
        document: Document,
        editing: Editing,
        saver: Saver,
        source: LandmarkSource,
        pool: QThreadPool,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._document, self._editing, self._saver = document, editing, saver
        self._source = source
        # What table 2 calls the setting time of the automatic method.
        self.finding_s: float | None = None
        self._told = NO_DISCLOSURE
        self._left = document.state
        self._reading = Lane(pool, self._not_opened, self)
        self._reading.done.connect(self._opened)
        self._finding = Lane(pool, self._not_found, self)
        self._finding.done.connect(self._take_faces)

    @property
    def busy(self) -> bool:
        """True while a file or a face is being worked on."""
        return self._reading.busy or self._finding.busy

    def stop(self) -> None:
        """Start nothing more, and forget what is under way."""
        self._reading.drop()
        self._finding.drop()

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
        self._reading.drop()
        self._left = self._document.state
        self.working.emit(tr("Opening {name}…", name=path.name))
        self._reading.submit(lambda: photos.opened(path, work, afresh))

    def open_sample(self) -> bool:
        """Open the portrait that travels with the program; return whether it is there."""
        try:
            path = assets.sample()
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
        # Only now: faces of the old photo were wanted until the new one could be read.
        self._finding.drop()
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
        elif self._document.undo.count() or self._document.in_gesture:
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

    def save(self, path: Path, then: Then | None = None) -> None:
        """Render the photo at its own depth and write it; the original is refused.

        Parameters
        ----------
        path : Path
            Where; a file there is written over.
        then : callable, optional
            What to do once it is written, see `Saver`.
        """
        self.quiet.emit()
        original, told = self._document.path, self._told
        there = original is not None and path.exists() and original.exists()
        if original is not None and there and path.samefile(original):
            self._refuse(tr("That is the original; it is never written over."))
            return

        def write(photo: Photo, state: State) -> str:
            return photos.saved(photo, state, told, path)

        self._saver.save(path, write, self._written, self._not_written, then)

    def _written(self, request: Request, notes: str) -> None:
        text = sentence(tr("Saved {name}", name=request.file.name))
        self.said.emit(Message(f"{text} {notes}".strip(), wrong=False))

    def _not_written(self, problem: Exception) -> None:
        if isinstance(problem, CannotDisclose):
            options = Step(tr("Save options…"), self.wants_options.emit)
            self.said.emit(Message(sentence(problem), (options,)))
        else:
            self._refuse(sentence(problem))

    def _refuse(self, text: str) -> None:
        self.said.emit(Message(text, (Step(tr("Choose another name…"), self.wants_save.emit),)))

    def _open_step(self) -> Step:
        return Step(tr("Open a photo…"), self.wants_open.emit)
