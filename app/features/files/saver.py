"""Every save of the open photo, its edits, copies and projects: one owner, one request each."""

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
# What a file will hold of a state: all of it, the mode at work, or its picture alone.
Holds = Literal["all", "mode", "picture"]


@dataclass(frozen=True, eq=False)
class Request:
    """One save: what is written, where, and what comes after it."""

    photo: Photo  # the photo that was open
    saving: Saving  # what the file will hold
    file: Path  # where it goes
    # What the user wanted to do once everything is saved: close, or open another photo.
    then: Then | None
    quiet: bool  # whether it goes without saying


class Saver(Feature):
    """Writes one request after the other, in the order they were made, and guards unsaved changes.

    A request holds the committed state of the moment it was made in. Once written it marks what
    the file holds of that state as saved, and of no other. What comes after it asks again before
    anything is lost; it is forgotten when the save fails, when the user wants something else
    meanwhile, and when another photo is open by then. Edits are kept without a wish, and only
    where they can't be is anything asked.
    """

    # Whether edits are kept; those of another program's photo aren't.
    keeps = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        # One thread for pictures and one for edits: a large copy holds no edit up, nor a slow disk
        # anybody else, and the order stays.
        self._threads = {of_edits: QThreadPool(self) for of_edits in (False, True)}
        for pool in self._threads.values():
            pool.setMaxThreadCount(1)
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
        """Take what saves a photo in place, keeps edits, and asks where else; then goes on."""
        self._save_copy, self._keep, self._save_elsewhere = copy, keep, elsewhere

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
        for pool in self._threads.values():
            pool.waitForDone()

    def guard(self, then: Then) -> None:
        """Do `then` at once, or once the edits are kept; ask only where they can't be."""
        self.forget()
        if not self.document.dirty:
            then()
        elif self.keeps:
            self._keep(then)
        else:
            self.ask(then)

    def ask(self, then: Then, why: str = "") -> None:
        """Do `then` after the user has saved or discarded what would be lost."""
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
        holds: Holds = "picture",
        quiet: bool = False,
    ) -> None:
        """End the gesture in hand and write the committed state; `quiet` where nobody asked."""
        photo = self.document.photo
        if photo is None:
            return
        self.document.commit()
        # Points of a face that isn't one yet are in no file.
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
