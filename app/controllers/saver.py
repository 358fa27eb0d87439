"""Every save of the open photo, as a copy or as a project: one owner, one request each."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from PySide6.QtCore import QObject, QThreadPool, Signal

from kogao_core.photo import Photo
from kogao_core.project import Mode

from ..document import Document, Saving, State
from ..i18n import tr
from ..workers import Lane
from .editing import Editing

Then = Callable[[], object]


@dataclass(frozen=True, eq=False)
class Request:
    """One save: what is written, where, and what comes after it.

    Parameters
    ----------
    photo : Photo
        The photo that was open.
    saving : Saving
        What the file will hold.
    file : Path
        Where it goes.
    then : callable, optional
        What the user wanted to do once everything is saved: close, or open another photo.
    """

    photo: Photo
    saving: Saving
    file: Path
    then: Then | None


class Saver(QObject):
    """Writes one request after the other, in the order they were made.

    A request holds the committed state of the moment it was made in. Once written it marks what
    the file holds of that state as saved, and of no other. What comes after it asks again before
    anything is lost; it is forgotten when the save fails, when the user wants something else
    meanwhile, and when another photo is open by then.

    Signals
    -------
    working(str)
        What is under way, or was done.
    wants_leave(callable)
        Go on with this, unless there are new changes: then ask first.
    """

    working = Signal(str)
    wants_leave = Signal(object)

    def __init__(self, document: Document, editing: Editing, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document, self._editing = document, editing
        # One thread of its own: a slow disk holds nobody else up, and the order stays.
        self._pool = QThreadPool(self)
        self._pool.setMaxThreadCount(1)
        self._lanes: dict[Request, Lane] = {}
        self._goes_on: Request | None = None

    @property
    def busy(self) -> bool:
        """True while something is written or waits for it."""
        return bool(self._lanes)

    def stop(self) -> None:
        """Write what was asked for, and tell nobody."""
        for lane in self._lanes.values():
            lane.drop()
        self._pool.waitForDone()

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
        """End the gesture in hand and write the committed state.

        Parameters
        ----------
        file : Path
            Where it goes, for messages.
        write : callable
            Takes photo and state, writes them in a worker and returns notes for the user.
        saved, failed : callable
            Called when it is over, with the request and its notes, or with what went wrong.
        then : callable, optional
            What comes after.
        whole : bool
            True for a file that holds both modes, False for a picture made in the one at work.
        """
        photo = self._document.photo
        if photo is None:
            return
        self._editing.commit()
        # Points of a face that isn't one yet are in no file.
        state = dataclasses.replace(self._document.committed, draft=())
        modes: tuple[Mode, ...] = get_args(Mode) if whole else (state.mode,)
        request = Request(photo, self._document.begin_saving(state, modes), file, then)
        lane = self._lanes[request] = Lane(
            self._pool, lambda problem: self._end(request, lambda: failed(problem), False), self
        )
        lane.done.connect(lambda notes: self._end(request, lambda: saved(request, notes), True))
        self._goes_on = request
        self.working.emit(tr("Saving {name}…", name=file.name))
        lane.submit(lambda: write(photo, state))

    def _end(self, request: Request, tell: Callable[[], object], written: bool) -> None:
        self._lanes.pop(request).deleteLater()
        self._document.end_saving(request.saving, written=written)
        then = request.then if request is self._goes_on else None
        if written:
            self.working.emit(tr("Saved {name}", name=request.file.name))
        else:
            self.working.emit("")
        tell()
        if written and then is not None and self._document.photo is request.photo:
            self._goes_on = None
            self.wants_leave.emit(then)
