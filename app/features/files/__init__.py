"""Opening photos and saving copies in workers; the message bar shows errors."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from PySide6.QtCore import QStandardPaths, QThreadPool, Signal

from kogao_core.background.find import BackgroundFinder
from kogao_core.base import assets
from kogao_core.base.geometry import Image
from kogao_core.base.threads import give_back_freed_memory
from kogao_core.base.wording import printable
from kogao_core.photo import FORMATS, READABLE, CannotDisclose, Photo, RefusedOutput
from kogao_core.photo.disclosure.disclosing import Disclosure
from kogao_core.photo.export import AS_IT_IS, Export
from kogao_core.photo.originals import Originals
from kogao_core.photo.whereabouts import Replaced, to_save
from kogao_core.projects.edits import SUFFIX
from kogao_core.projects.project import Project, to_bytes
from kogao_core.projects.results import MARK, Provenance
from kogao_core.projects.sidecar import sheet_of
from kogao_core.recipe.recipe import SHAPE, Recipe
from kogao_core.retouch import Output, draw, over_itself, retouch, to_file

from ...actions import call
from ...ahead import Ahead, FaceSearch
from ...document import ReplaceState, State
from ...i18n import reason, sentence, tr, translated
from ...widgets.dialogs import ask_path, open_path, photo_filter
from ...widgets.messages import BarAction
from .. import preferences
from ..disclosure import SaveOptions
from ..faces import Faces
from ..feature import Context, Feature
from .opening import (
    EarlierWork,
    Opened,
    PhotoNotBeside,
    is_sample,
    open_photo,
    stamps_of,
    to_keep_beside,
)
from .saver import Holds, Request, Saver, Then

# First recipe for results of this program, so that no face is changed twice by accident.
UNTOUCHED: Final = Recipe(percent=0.0)


class Files(Feature):
    """Opens photos and saves results."""

    # (): a photo is being read.
    began = Signal()
    # (): the sample opened at the first start.
    welcomed = Signal()
    # (opened: Opened): a photo with earlier work is read, and not open yet.
    resuming = Signal(object)
    # (work: EarlierWork, note: str): earlier work is open again.
    restored = Signal(object, str)
    # (why: str): no photo could be opened.
    unreadable = Signal(str)
    # (): the open photo's own file has been replaced.
    saved_over = Signal()
    # (request: Request): a copy is written.
    saved = Signal(object)
    # (file: Path): the photo of a project isn't beside the project.
    wants_photo = Signal(object)
    # (): a copy was asked for, and the file holds another picture.
    stale = Signal()
    # Photos that no copy may replace, unless Kogao made them.
    photos: Callable[[], Sequence[Path]] = tuple
    # Settles open questions about the edits before a file is written.
    settle: Callable[[Callable[[], object]], object]

    def __init__(
        self,
        context: Context,
        saver: Saver,
        faces: Faces,
        options: SaveOptions,
    ) -> None:
        super().__init__(context)
        self._saver, self._faces, self._options = saver, faces, options
        # State at the request for another photo, and whether its edits may be discarded.
        self._left, self._given_up = self.document.state, False
        self._stop, self._card = 0, ""  # card of the tour: index and text
        self.document.undo.indexChanged.connect(lambda _: self._follow_tour())
        self._originals: Originals | None = None
        # Search for the faces of a photo that is still loading.
        self._sought: FaceSearch | None = None
        self._reading = self.lane(self._opened, self._not_opened)
        self.bind("tour", self.welcome)
        self.opening = self.bind("open", self._ask_open)
        self.sampling = self.bind("sample", self.open_sample)
        self.bind("save", self.keep)
        self.bind("quit", self.window.close)

    # -- opening ---------------------------------------------------------------------------------

    def _ask_open(self) -> None:
        filters = [photo_filter(READABLE, f"*{SUFFIX}")]
        ask_path(self.window, tr("Open a photo"), self.open, filters=filters, at=self.folder)

    @property
    def folder(self) -> Path:
        """Start folder of dialogs: the preferred one, the open photo's, or Pictures."""
        path, preferred = (
            self.document.path,
            preferences.folder(self.settings, preferences.OPEN_FOLDER),
        )
        if preferred is not None:
            return preferred
        if path is not None and not is_sample(path):
            return path.parent
        pictures = QStandardPaths.StandardLocation.PicturesLocation
        place = Path(QStandardPaths.writableLocation(pictures))
        return place if os.path.isdir(place) else Path.home()

    def open(self, path: Path, ahead: Ahead | None = None, *, afresh: bool = False) -> None:
        """Open a photo or a project after the current edits are saved."""
        # Absolute: recent files and recovery are used from other working directories.
        path = path.absolute()
        self._saver.guard(lambda: self.read(path, ahead=ahead, afresh=afresh))

    def stay(self) -> None:
        """Cancel the opening of another photo."""
        self._saver.forget()
        if self._reading.busy:
            self.stop()
            self.working.emit("")

    def open_sample(self, *, afresh: bool = False) -> bool:
        """Open the sample portrait; return False if the file is missing."""
        try:
            path = assets.sample()
        except assets.AssetMissing as problem:
            self._not_opened(problem)
            return False
        self.open(path, afresh=afresh)
        return True

    def read(
        self,
        path: Path,
        work: EarlierWork | None = None,
        *,
        afresh: bool = False,
        ahead: Ahead | None = None,
    ) -> None:
        """Read a photo without a question (see `open_photo`)."""
        self.window.bar.clear()
        self.began.emit()
        self.stop()
        self._sought = None if ahead is None else ahead.search
        self._left, self._given_up = self.document.state, self.document.dirty
        self.working.emit(tr("Opening {name}…", name=path.name))
        storage = self.storage
        self._reading.submit(lambda: open_photo(path, storage, work, afresh, ahead))

    def welcome(self) -> None:
        """Open the sample and start the tour; Escape ends the tour."""
        if self.open_sample(afresh=True):
            self._say_stop(0)
            self.welcomed.emit()

    def _say_stop(self, number: int) -> None:
        stops = (
            tr("Move the slider “Amount”: the face gets smaller."),
            tr("Drag a dot or a curve on the face: its outline follows."),
            tr("Hold F4 to see the photo as it was. Then open one of yours."),
        )
        last = number == len(stops) - 1
        further = BarAction(tr("Next"), lambda: self._say_stop(number + 1))
        text = tr("{n} of {count}: {stop}", n=number + 1, count=len(stops), stop=stops[number])
        self._stop, self._card = number, text
        self.say(
            text,
            self._open_step() if last else further,
            wrong=False,
            applies=lambda: self._stop == number and self.on_sample(),
        )

    def _follow_tour(self) -> None:
        """Show the next card after the user has completed a step of the tour."""
        index = self.document.undo.index()
        step = self.document.undo.command(index - 1) if index else None
        card = self.window.bar.shown
        if card is None or card.text != self._card or not isinstance(step, ReplaceState):
            return
        before, after = step.before, step.after
        shapes = ([getattr(one.recipe, name) for name in SHAPE] for one in (before, after))
        shaped = before.faces != after.faces or next(shapes) != next(shapes)
        changed = (before.recipe != after.recipe, shaped, False)
        if changed[self._stop] and not self._reading.busy:
            self._say_stop(self._stop + 1)

    def on_sample(self) -> bool:
        """Return whether the sample or no photo is open."""
        path = self.document.path
        return path is None or is_sample(path)

    def _opened(self, opened: Opened) -> None:
        # Save later edits of the old photo first. If the same photo is opened again, the edits read
        # before are then stale.
        path, work = opened.photo.path, opened.work
        kept_aside = work if work is not None and work.file is None else None
        same = not self.document.in_gesture and self.document.state is self._left
        if same and (self._given_up or not self.document.dirty):
            self._show(opened)
        elif path == self.document.path:
            self._saver.guard(lambda: self.read(path, kept_aside))
        else:
            self.working.emit("")
            self._saver.guard(lambda: self._show(opened))

    def _show(self, opened: Opened) -> None:
        if stamps_of(opened.stamps) != opened.stamps:
            # The edits were saved while the photo was read, e.g. by a sync.
            recovered = opened.work if opened.work and opened.work.file is None else None
            self.read(opened.photo.path, recovered)
            return
        self.document.open(opened.photo, opened.pyramid, UNTOUCHED if opened.origin else None)
        QThreadPool.globalInstance().start(give_back_freed_memory)  # of the photo before
        if opened.work is not None and opened.state is not None:
            self._give_up_search()
            self._go_on(opened, opened.work, opened.state)
            return
        if opened.note:
            text = tr("The photo starts without its edits: {problem}", problem=opened.note)
            self.say(sentence(text))
        if opened.foreign is not None:
            self._say_foreign(opened.photo, opened.foreign)
        if opened.origin is not None:
            self._say_result(opened.photo, opened.origin)
        search, self._sought = self._sought, None
        self._faces.look(search)

    def _say_foreign(self, photo: Photo, project: Project) -> None:
        def bring() -> None:
            self.document.commit()
            state = replace(self.document.committed, recipe=sheet_of(project).recipe)
            self.document.step(state, tr("Bring the settings along"))
            brought.append(state)

        brought = list[State]()
        text = tr("The edits here belong to another picture that was named {name}.",
                  name=photo.path.name)  # fmt: skip
        self.say(
            text,
            BarAction(tr("Bring the settings along"), bring),
            wrong=False,
            applies=lambda: self.document.photo is photo and not brought,
        )

    def _say_other(self, photo: Photo, project: Project) -> None:
        use = BarAction(
            tr("Use the older ones"), lambda: self.read(photo.path, EarlierWork(project))
        )
        text = tr("There are two versions of the edits, beside the photo and in Kogao's folder. "
                  "The newer ones are shown.")  # fmt: skip
        self.say(text, use, wrong=False, applies=lambda: self.document.photo is photo)

    def _say_result(self, photo: Photo, origin: Provenance) -> None:
        text = tr("{why}, so it starts at 0 %.", why=translated(origin.why))
        source, steps = origin.source, list[BarAction]()
        if source is not None:
            steps.append(BarAction(tr("Open {name}", name=source.name), lambda: self.open(source)))
        self.say(text, *steps, applies=lambda: self.document.photo is photo)

    def stop(self) -> None:
        """Cancel reading and the search that was started ahead."""
        self._give_up_search()
        super().stop()

    def _give_up_search(self) -> None:
        if self._sought is not None:
            self._sought.stop()

    def _go_on(self, opened: Opened, work: EarlierWork, state: State) -> None:
        self.resuming.emit(opened)
        if work.file is None:
            self.document.step(state, tr("Restore"))
            self.did.emit(tr("The unsaved changes are back"))
        else:
            self.document.begin_with(state, opened.steps)
            self.live.go_on()
            self.working.emit("")
        self.restored.emit(work, translated(opened.note))  # signals carry plain text only
        if opened.other is not None:
            self._say_other(opened.photo, opened.other)
        if state.sheet("automatic").faces or state.mode == "manual":
            self._faces.found.emit(len(state.faces))
        else:  # the photo was closed during face detection
            self._faces.look()

    def _not_opened(self, problem: Exception) -> None:
        self.working.emit("")
        if isinstance(problem, PhotoNotBeside):
            self._ask_photo(problem.work, problem.file)
            self.wants_photo.emit(problem.file)
            return
        self.say(sentence(problem), self._open_step())
        self.unreadable.emit(reason(problem))

    def _ask_photo(self, work: EarlierWork, file: Path) -> None:
        ask_path(
            self.window,
            tr("Which photo does {name} belong to?", name=file.name),
            lambda path: self.read(path, work),
            filters=[photo_filter()],
            at=file.parent,
        )

    def _open_step(self) -> BarAction:
        return BarAction(tr("Open a photo…"), self._ask_open)

    # -- saving ----------------------------------------------------------------------------------

    def save_over(self, originals: Originals) -> None:
        """Overwrite the photo itself on save; back up the original in `originals`."""
        self._originals, self._saver.keeps = originals, False
        save, tip = self.actions["save"], tr("Write the result over the photo itself")
        call(save, tr("&Save"))
        save.setStatusTip(tip)
        save.setToolTip(f"{tip} ({save.shortcut().toString()})")

    def keep(self, then: Then | None = None) -> None:
        """Save over the photo itself or as a copy, then call `then`."""
        if self._originals is None:
            self.ask_save(then)
        elif self.document.path is not None:
            self.window.bar.clear()
            path, originals = self.document.path, self._originals
            self.settle(lambda: self._write(path, then, originals))

    def ask_save(self, then: Then | None = None) -> None:
        """Request a path for the copy; at the first save, ask about the edit record before."""
        self._options.ask_once(lambda: self._ask_place(then))

    def _ask_place(self, then: Then | None) -> None:
        """Request a path for the copy; suggest a name next to the original."""
        suggested = self.suggested()
        if suggested is None:
            return
        self._saver.forget()
        dialog = ask_path(
            self.window,
            tr("Save a copy"),
            lambda path: self.save(path, then),
            "new",
            filters=[photo_filter(FORMATS)],
            endings=[suggested.suffix],
            at=suggested,
        )
        # The name belongs to the open photo only.
        self.document.opened.connect(dialog.reject)

    def suggested(self) -> Path | None:
        """Return a name for a copy, in the preferred folder or next to the original."""
        path = self.document.path
        if path is None:
            return None
        suffix = path.suffix if path.suffix.lower() in FORMATS else ".png"
        folder = preferences.folder(self.settings, preferences.SAVE_FOLDER) or path.parent
        return folder / f"{path.stem}{MARK}{suffix}"

    def save(self, path: Path, then: Then | None = None, export: Export = AS_IT_IS) -> None:
        """Render and write a copy at the photo's bit depth, or an export; refuse the original."""
        self.window.bar.clear()
        self.settle(lambda: self._write(path, then, export=export))

    def _write(
        self,
        path: Path,
        then: Then | None,
        originals: Originals | None = None,
        export: Export = AS_IT_IS,
    ) -> None:
        finder, options = self.live.finder, self._options
        disclosure = options.current if originals is None else options.in_place
        drawn = self.live.lent()

        results = self.storage.results if originals is None else None
        photos = self.photos()

        def is_photo(path: Path) -> bool:
            listed = os.path.realpath(path) in map(os.path.realpath, photos)
            return listed and self.storage.results.origin(path) is None

        def write_copy(photo: Photo, state: State) -> str:
            known = photo if results is None else to_save(photo, path, is_photo)
            if known is None:
                raise RefusedOutput(tr("That is the original; it is never written over."))
            notes = save_copy(known, state, disclosure, path, finder, drawn, originals, export)
            if results is not None:
                edit = hashlib.sha256(to_bytes(to_keep_beside(state, photo))).hexdigest()
                results.add(photo.path, path, edit)
            return notes

        holds: Holds = "picture" if self._saver.keeps else "mode"
        self._saver.save(path, write_copy, self._written, self._not_written, then, holds=holds)

    def _written(self, request: Request, notes: str) -> None:
        self.saved.emit(request)
        name, place = request.file.name, printable(str(request.file.parent))
        if request.file == request.photo.path:
            self.saved_over.emit()
            text = sentence(tr("Saved {name}", name=name))
        else:
            text = sentence(tr("Saved {name} in {folder}", name=name, folder=place))
        folder = BarAction(tr("Open folder"), lambda: open_path(request.file.parent))
        self.say(f"{text} {notes}".strip(), folder, wrong=False)

    def _not_written(self, problem: Exception) -> None:
        if isinstance(problem, Replaced):
            self.stale.emit()
        elif isinstance(problem, CannotDisclose):
            self.say(
                sentence(problem),
                BarAction(tr("Preferences…"), self.actions["preferences"].trigger),
            )
        else:
            self._refuse(sentence(problem))

    def _refuse(self, text: str) -> None:
        self.say(text, BarAction(tr("Choose another name…"), self.ask_save))


def save_copy(
    photo: Photo,
    state: State,
    disclosure: Disclosure,
    path: Path,
    finder: BackgroundFinder,
    drawn: Image | None,
    originals: Originals | None = None,
    export: Export = AS_IT_IS,
) -> str:
    """Write a copy and return notes for the user.

    `drawn` is the rendered result, if available. With `originals` the photo itself is overwritten
    and backed up in `originals`; otherwise the dialog has confirmed overwriting.
    """
    write = to_file(path, force=True) if originals is None else over_itself(originals)
    output = Output(write, disclosure, export)
    if drawn is None or output.needs_rendering(photo):
        made = retouch(photo, state.done, draw(photo, state.done, finder, export), output)
    else:
        made = retouch(photo, state.done, drawn, output)
    return " ".join(sentence(note) for note in (*made.notes, made.written) if note)
