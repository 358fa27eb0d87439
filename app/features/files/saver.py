"""Save queue of the open photo: edits, copies and projects."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

from PySide6.QtCore import QThreadPool
from PySide6.QtWidgets import QMessageBox

from kogao_core.photo import Photo
from kogao_core.projects.project import Mode

from ...document import Saving, State
from ...i18n import tr
from ...widgets.dialogs import question
from ...workers import Lane
from ..feature import Context, Feature

Then = Callable[[], object]
# The part of a state in a file: all, the current mode, or the picture alone.
Holds = Literal["all", "mode", "picture"]


@dataclass(frozen=True, eq=False)
class Request:
    """One save: the photo, the file and the next step."""

    photo: Photo  # the photo to save
    saving: Saving  # the work in the file
    file: Path  # the path to write
    # The call after the save: close the window or open another photo.
    then: Then | None
    quiet: bool  # True: show no message


class Saver(Feature):
    """Writes requests in order and protects unsaved changes.

    A request contains the committed state at the time of the request. After writing, only this
    state is marked as saved. The next step (`then`) asks again about newer unsaved changes.
    The next step is dropped if the save fails, the user cancels, or another photo is open.
    Edits are saved automatically; a question appears only if saving fails.
    """

    # True if edits are saved automatically; False for a photo of another program.
    keeps = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        # One thread for pictures and one for edits: a large copy must not delay edits. A single
        # thread each keeps the order.
        self._threads = {of_edits: QThreadPool(self) for of_edits in (False, True)}
        for pool in self._threads.values():
            pool.setMaxThreadCount(1)
        self.edits_thread: QThreadPool = self._threads[True]
        self._requests: dict[Request, Lane] = {}
        self._goes_on: Request | None = None
        self._save_copy: Callable[[Then | None], object] = lambda _: None
        self._keep: Callable[[Then], object] = lambda _: None
        self._save_elsewhere: Callable[[Then], object] = lambda _: None

    def offer(
        self,
        copy: Callable[[Then | None], object],
        keep: Callable[[Then], object],
        elsewhere: Callable[[Then], object],
    ) -> None:
        """Set the functions that save in place, save edits, and ask for another path."""
        self._save_copy, self._keep, self._save_elsewhere = copy, keep, elsewhere

    @property
    def busy(self) -> bool:
        """True while requests are running or waiting."""
        return bool(self._requests)

    def stop(self) -> None:
        """Ignore the results of running saves."""
        for lane in self._requests.values():
            lane.drop()

    def finish(self) -> None:
        """Wait until all requests are written."""
        for pool in self._threads.values():
            pool.waitForDone()

    def guard(self, then: Then) -> None:
        """Call `then` after the edits are saved; ask the user only if saving fails."""
        self.forget()
        if not self.document.dirty:
            then()
        elif self.keeps:
            self._keep(then)
        else:
            self.ask(then)

    def ask(self, then: Then, why: str = "") -> None:
        """Ask the user to save or discard unsaved work, then call `then`."""
        buttons = QMessageBox.StandardButton
        box = question(self.window, tr("Save before the changes are lost?"))
        box.setInformativeText(why)
        box.setStandardButtons(buttons.Save | buttons.Discard | buttons.Cancel)
        save = box.button(buttons.Save)
        if self.keeps:
            save.setText(tr("Save the &project elsewhere…"))
            save.clicked.connect(lambda: self._save_elsewhere(then))
        else:
            save.setText(self.actions["save"].text())
            save.clicked.connect(lambda: self._save_copy(then))
        box.button(buttons.Discard).clicked.connect(lambda: then())
        box.setDefaultButton(buttons.Save)
        # The question is about the open photo only.
        self.document.opened.connect(box.reject)
        box.open()

    def forget(self) -> None:
        """Drop the next step after the current save."""
        self._goes_on = None

    def save(
        self,
        file: Path,
        write: Callable[[Photo, State], str],
        saved: Callable[[Request, str], object],
        failed: Callable[[Exception], object],
        then: Then | None = None,
        *,
        holds: Holds = "picture",
        quiet: bool = False,
    ) -> None:
        """End the current gesture and write the committed state; `quiet` shows no message."""
        photo = self.document.photo
        if photo is None:
            return
        self.document.commit()
        # No file contains the landmarks of an incomplete face.
        state = dataclasses.replace(self.document.committed, draft=())
        modes: dict[Holds, tuple[Mode, ...]] = {"all": get_args(Mode), "mode": (state.mode,)}
        saving = self.document.begin_saving(state, modes.get(holds, ()))
        request = Request(photo, saving, file, then, quiet)
        lane = self._requests[request] = Lane(
            self._threads[holds == "all"],
            lambda problem: self._end(request, lambda: failed(problem), False),
            self,
        )
        lane.done.connect(lambda notes: self._end(request, lambda: saved(request, notes), True))
        if then is not None or not quiet:
            self._goes_on = request
        if not quiet:
            self.working.emit(tr("Saving {name}…", name=file.name))
        lane.submit(lambda: write(photo, state))

    def _end(self, request: Request, report: Callable[[], object], written: bool) -> None:
        self._requests.pop(request).deleteLater()
        then = request.then if request is self._goes_on else None
        self.document.end_saving(request.saving, written=written)
        if request.quiet:
            pass
        elif written:
            self.did.emit(tr("Saved {name}", name=request.file.name))
        else:
            self.working.emit("")
        report()
        if written and then is not None and self.document.photo is request.photo:
            self._goes_on = None
            if self.keeps and self.document.committed.draft:
                self.ask(then, tr("Points of a face that isn't complete yet can't be kept."))
            else:
                self.guard(then)
