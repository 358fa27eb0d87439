"""A user, a disk and a crash at random, and an oracle that knows what must not be lost.

The oracle keeps books of its own: what each edit, undo and redo made of the photo, what was
discarded, and what a crash still owes. It reads project and recovery files as plain JSON and
compares copies with a fresh render, so it shares nothing with the editor's own idea of "saved".
"""

from __future__ import annotations

import contextlib
import gc
import shutil
import sqlite3
import time
from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType

import cv2
import numpy as np
from crash_oracle import POINT, Books, Disk, Lost, Sign, sign_in, sign_of, through
from kogao_app.editor import Editor
from kogao_app.features.strip.film import FilmStrip
from kogao_app.storage import Storage
from kogao_app.view_state import Handle
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QFileDialog, QMessageBox, QPushButton
from scenes import KnownFaces, oval_face, textured_photo
from timeouts import LONGEST_S

from kogao_core.base.index import NAME

_SIZE = (240, 180)


class Interleaving:
    """One run: random acts on the real editor, each followed by the oracle.

    The same seed makes the same acts; how they fall between the workers' is up to the machine.
    """

    def __init__(self, app: QApplication, folder: Path, seed: int) -> None:
        self._app, self._folder = app, folder
        self._rng = np.random.default_rng(seed)
        self._photos = [folder / f"{name}.png" for name in ("one", "two")]
        for number, path in enumerate(self._photos):
            cv2.imwrite(str(path), textured_photo(*_SIZE, seed=number)[..., ::-1])
        self._broken = folder / "broken.png"
        self._broken.write_bytes(b"\x89PNG not a photo")
        self._books, self._known = Books(), set()
        self._asked: dict[str, Path] = {}
        # What was last made of each photo that was left, by its name.
        self._left: dict[str, Sign] = {}
        # Work that one undo must bring back after a sync, by photo.
        self._synced: dict[str, Sign] = {}
        # Work before and after syncs, by photo: undo in another photo leads from one to the other.
        self._by_sync: dict[str, set[Sign]] = {}
        self._saved: set[Path] = set()
        self._disks: list[Disk] = []
        self._homes = self._copies = 0
        self._gesture = False
        self.counts: Counter[str] = Counter()
        self._problem = ""
        self.log: list[str] = []

    def run(self, acts: int, least: Mapping[str, int] = MappingProxyType({})) -> None:
        """Do so many acts, and more until each kind has happened at least so often.

        How often a kind happens in a number of acts depends on the machine's speed. Raises Lost if
        an edit is nowhere, or the editor calls saved what isn't.
        """
        with through(self._disks):
            self._start(self._home())
            try:
                self._open(self._photos[0])
                self._check()
                left = acts
                while left > 0 or any(self.counts[kind] < n for kind, n in least.items()):
                    left -= 1
                    assert left > -9 * acts, (least, self.counts)
                    self._act()
                    self._pump_a_little()
                    self._follow()
                    self._check()
            except Lost as lost:
                lost.add_note(" · ".join(self.log[-60:]))
                raise
            finally:
                self._end()

    # -- programs --------------------------------------------------------------------------------

    def _home(self) -> Path:
        self._homes += 1
        return self._folder / f"home{self._homes}"

    def _start(self, home: Path) -> None:
        self._disks.append(Disk())
        self._storage = Storage.in_folder(home)
        self._editor = editor = Editor(self._app, KnownFaces(oval_face(*_SIZE)), self._storage)
        self._opened = self._restored = False
        editor.document.opened.connect(self._note_opened)
        editor.files.restored.connect(self._note_restored)
        editor.saver.did.connect(self._note_report)
        editor.document.undo.indexChanged.connect(self._note_step)
        editor.window.resize(800, 500)
        editor.window.show()
        self._books.begin("", [editor.document.committed], 0)
        editor.recovery.look()
        self._until(lambda: not editor.busy)

    def _end(self) -> None:
        self._disk.mode = dict.fromkeys(Disk.kinds, "dead")
        self._disk.open.set()
        self._editor.close()
        self._editor.window.deleteLater()
        # Here, not on a worker of the next program.
        gc.collect()

    def _crash(self) -> None:
        if self._needs_recovery() and self._disk.mode["recovery"] != "quick":
            return
        wanted = (self._books.name, self._books.work) if self._books.name else None
        is_writing = self._editor.saver.busy
        if wanted and is_writing and wanted not in self._kept():
            return  # an older state may be put in place of this one at this very moment
        may_owe = is_writing or self._needs_recovery()
        home = self._home()
        storage = Storage.in_folder(home)
        storage.recovery.mkdir(parents=True)
        # A dead program's lock is free; here its process lives on, so the lock stays behind.
        for path in self._storage.recovery.glob("*.json"):
            with contextlib.suppress(FileNotFoundError):  # being removed at this moment
                shutil.copy2(path, storage.recovery)
        kept = _signs(storage.recovery)
        if wanted and may_owe and wanted in kept:
            # An earlier crash may have left this very work, and its file is the only one.
            if kept.count(wanted) > self._books.owed.count(wanted):
                self._books.owed.append(wanted)
            self._left.pop(self._books.name, None)
        else:
            self._leave("the program was killed")
        edits = self._storage.edits.folder
        if edits.exists():
            # What is being written aside goes at any moment.
            aside = shutil.ignore_patterns(".kogao-*")
            shutil.copytree(edits, storage.edits.folder, ignore=aside)
        if (index := self._storage.data / NAME).exists():
            with (
                contextlib.closing(sqlite3.connect(index)) as before,
                contextlib.closing(sqlite3.connect(home / NAME)) as after,
            ):
                before.backup(after)
        self._end()
        self._gesture = False
        self._start(home)

    @property
    def _disk(self) -> Disk:
        return self._disks[-1]

    # -- time ------------------------------------------------------------------------------------

    def _until(self, condition: Callable[[], bool], most_s: float = LONGEST_S) -> bool:
        end = time.monotonic() + most_s
        while not condition():
            if time.monotonic() > end:
                return False
            self._app.processEvents()
            time.sleep(0.001)
        return True

    def _pump_a_little(self) -> None:
        end = time.monotonic() + float(self._rng.choice([0.0, 0.002, 0.02]))
        self._app.processEvents()
        while time.monotonic() < end:
            self._app.processEvents()

    # -- what the editor tells ---------------------------------------------------------------------

    def _note_opened(self) -> None:
        self._leave("another photo was opened")
        self._opened, self._restored = True, False

    def _note_restored(self, work: object) -> None:
        self._restored = work.file is None

    def _note_step(self) -> None:
        # A save ends the gesture in hand; it may be over, and the window gone, before `_follow`.
        document = self._editor.document
        if self._gesture and document.undo.count() and not document.in_gesture:
            self._push()

    def _note_report(self, text: str) -> None:
        if text.startswith("Saved "):
            path = self._asked.get(text.removeprefix("Saved "), self._folder / text)
            held = sign_in(path) if path.suffix == ".json" else None
            if not path.exists() or (held is not None and held[1] not in self._known):
                self._problem = f"{path.name} was reported saved and holds {held}"
            self._saved.add(path)
            self.counts["saved"] += 1

    def _leave(self, why: str) -> None:
        """The photo at hand goes: its work must be somewhere else, or not wanted any more."""
        books = self._books
        if not books.name:
            return
        if books.work not in self._by_sync.get(books.name, ()):
            self._by_sync.pop(books.name, None)  # newer edits stay, whatever is undone elsewhere
        if books.discarded == books.work:
            self._left.pop(books.name, None)
        elif self._is_kept():
            self._left[books.name] = books.work
        elif self._is_safe():
            self._left.pop(books.name, None)
        else:
            # Raised by `_follow`: Qt swallows what a slot raises.
            self._problem = f"{why}, and {books.work} of {books.name} is nowhere"

    def _follow(self) -> None:
        """Bring the books up to date with what has happened since the last act."""
        editor = self._editor
        if not editor.window.isVisible():
            self._leave("the window was closed")
            self._raise_problem()
            self.counts["closed"] += 1
            self._gesture = False
            # A program that is closed reads no further photo.
            editor.document.opened.disconnect(self._note_opened)
            editor.document.undo.indexChanged.disconnect(self._note_step)
            editor.window.deleteLater()
            self._start(self._storage.data)
            return
        self._raise_problem()
        if self._opened:
            self._until(lambda: not (editor.files.busy or editor.faces.busy))
            self._begin()
        if self._gesture and not editor.document.in_gesture:
            self._push()

    def _raise_problem(self) -> None:
        if self._problem:
            raise Lost(self._problem)

    def _begin(self) -> None:
        document, books = self._editor.document, self._books
        self._opened = self._gesture = False
        steps, synced = document.steps, self._synced.pop(document.path.name, None)
        books.begin(document.path.name, steps.states, steps.index)
        if self._restored:
            # Faces that were still sought then are found again.
            percent, _, strokes = books.work
            for work in (books.work, (percent, None, strokes)):
                if (books.name, work) in books.owed:
                    books.owed.remove((books.name, work))
                    break
            self.counts["restored"] += 1
        else:
            last, turned = self._left.get(books.name), self._by_sync.get(books.name, set())
            if last is not None and last != books.work and {last, books.work} <= turned:
                last, synced = books.work, None
            if last is not None and not (
                _as_if_sought(books.work, last) == last or (books.name, last) in books.owed
            ):
                raise Lost(f"{books.name} is opened again with {books.work} instead of {last}")
            self.counts["reopened"] += last is not None
            if synced is not None and last is not None:
                signs = [sign_of(state) for state in steps.states]
                undone = signs[steps.index - 1] if steps.index else None
                if undone is None or _as_if_sought(undone, synced) != synced:
                    raise Lost(f"undo of a sync brings {synced} of {books.name} not back: {signs}")
                self.counts["undone sync"] += 1
        books.afresh = self._restored or self._newest() is None
        self._known |= {sign_of(state) for state in books.states}

    def _push(self) -> None:
        self._gesture = False
        self._books.push(self._editor.document.committed)
        self._known.add(self._books.work)

    def _sidecar(self) -> Path:
        return self._folder / f"{self._books.name}.kogao.json"

    # -- the oracle --------------------------------------------------------------------------------

    def _is_safe(self) -> bool:
        """Tell whether the work at hand can be had again without the editor and its recovery."""
        books = self._books
        if self._is_kept() or (books.afresh and books.work == sign_of(books.states[0])):
            return True
        wanted = (books.name, books.work)
        return any(sign_in(path) == wanted for path in self._saved if path.suffix == ".json")

    def _is_kept(self) -> bool:
        """Tell whether opening the photo brings the work at hand."""
        newest, (percent, point, strokes) = self._newest(), self._books.work
        held = None if newest is None else sign_in(newest)
        if held is None or held[0] != self._books.name:
            return False
        # In what was kept while faces were still sought they are found again, as they were.
        again = point == sign_of(self._books.states[0])[1] and held[1] == (percent, None, strokes)
        return again or held[1] == self._books.work

    def _newest(self) -> Path | None:
        return self._storage.edits.newest(self._folder / self._books.name)

    def _needs_recovery(self) -> bool:
        return bool(self._books.name) and not self._is_safe()

    def _kept(self) -> list[tuple[str, Sign] | None]:
        return _signs(self._storage.recovery)

    def _check(self) -> None:
        books, editor = self._books, self._editor
        if not books.name or self._opened or self._gesture:
            return
        if sign_of(editor.document.committed) != books.work:
            raise Lost(f"{books.work} isn't in the document")
        if self._needs_recovery():
            if not editor.document.dirty:
                newest = self._newest()
                held = None if newest is None else (newest.name, sign_in(newest))
                raise Lost(f"{books.work} counts as saved and is in no file; {held} is")
            if self._disk.mode["recovery"] != "full":
                wanted = (books.name, books.work)
                # A save that was on its way makes it safe, too.
                if not self._until(lambda: wanted in self._kept() or self._is_safe()):
                    raise Lost(f"{wanted} is in no recovery file")
        for owed in books.owed:
            if owed not in self._kept():
                raise Lost(f"{owed}, which a crash has left, is gone")

    # -- acts --------------------------------------------------------------------------------------

    def _act(self) -> None:
        dialogs = [it for it in self._editor.window.findChildren(QDialog) if it.isVisible()]
        act: Callable[[], None]
        if self._rng.random() < 0.15:
            act = self._change_disk
        elif dialogs:
            act = partial(self._answer, dialogs[-1])
        elif self._books.name:
            acts, shares = zip(
                *((self._slide, 6), (self._drag, 3), (self._protect, 2), (self._hold, 2)),
                *((self._undo, 4), (self._redo, 3), (self._press_bar, 3)),
                *((self._save_copy, 3), (self._save_project, 2), (self._open_another, 3)),
                *((self._move_along, 3), (self._close, 2), (self._crash, 3)),
                *((self._sync, 3), (self._reset, 1)),
                strict=True,
            )
            act = acts[self._rng.choice(len(acts), p=np.divide(shares, sum(shares)))]
        else:
            act = self._press_bar if self._rng.random() < 0.6 else self._open_another
        name = getattr(act, "__name__", "answer").strip("_")
        self.counts[name] += 1
        self.log.append(name)
        act()

    def _one_of(self, things: list) -> object:
        return things[self._rng.integers(len(things))]

    def _change_disk(self) -> None:
        kind = self._one_of(list(Disk.kinds))
        mode = str(self._rng.choice(["quick", "slow", "full"], p=[0.5, 0.3, 0.2]))
        self._disk.mode[kind] = "quick" if (kind, mode) == ("photo", "full") else mode
        (self._disk.open.set if self._rng.random() < 0.5 else self._disk.open.clear)()
        self.log.append(f"  {kind} {mode}")

    def _slide(self) -> None:
        self._hold()
        self._editor.document.commit()
        self._push()

    def _hold(self) -> None:
        """Begin a gesture that ends with whatever comes next."""
        self._editor.recipe.set_field("percent", round(float(self._rng.uniform(1.0, 9.0)), 2))
        self._gesture = True
        # What ends it may be a save that is over before the books are brought up to date.
        self._known.add(sign_of(self._editor.document.state))

    def _drag(self) -> None:
        canvas, state = self._editor.window.canvas, self._editor.document.state
        if state.faces:
            point_px = state.faces[0].outline[POINT]
            canvas.begin("points", Handle("outline", 0, POINT), point_px)
            self._follow()
            to_px = point_px + np.array([1.0, self._rng.uniform(-1.0, 1.0)])
            canvas.move(to_px)
            canvas.end(to_px)
            self._push()

    def _protect(self) -> None:
        protecting, canvas = self._editor.protect, self._editor.window.canvas
        self._editor.document.commit()
        self._push()
        protecting.take("brush")
        canvas.begin("brush", None, self._rng.uniform(10.0, 170.0, 2))
        to_px = self._rng.uniform(10.0, 170.0, 2)
        canvas.move(to_px)
        canvas.end(to_px)
        protecting.take("points")
        self._push()

    def _undo(self) -> None:
        # Undo of a sync changes other photos' files meanwhile; `test_sync` holds that.
        if self._editor.document.undo.undoText().startswith("Apply to"):
            return
        if self._gesture:
            self._gesture = False
        elif self._books.at:
            self._books.at -= 1
        self._editor.history.undo()

    def _redo(self) -> None:
        if self._editor.document.undo.redoText().startswith("Apply to"):
            return
        if not self._gesture and self._books.at + 1 < len(self._books.states):
            self._books.at += 1
        self._editor.history.redo()

    def _save_copy(self) -> None:
        self._editor.window.actions_by_name["save"].trigger()

    def _save_project(self) -> None:
        self._asked[self._sidecar().name] = self._sidecar()
        self._editor.window.actions_by_name["save-project"].trigger()

    def _open_another(self) -> None:
        self._open(self._one_of([*self._photos, self._broken]))

    def _move_along(self) -> None:
        self._film().step(int(self._rng.choice([-1, 1])))

    def _film(self) -> FilmStrip:
        """Return the strip with all photos."""
        film = self._editor.strip.film
        if film.count() < len(self._photos):
            self._editor.strip.show_places([*self._photos, self._broken])
            self._until(lambda: film.count() >= len(self._photos))
        return film

    def _others(self) -> list[Path]:
        """Photos that aren't open and of which no crash has left unsaved work."""
        owed = {name for name, _ in self._books.owed}
        return [one for one in self._photos if one.name not in {self._books.name, *owed}]

    def _sync(self) -> None:
        """Sync the settings to the other photos on the strip."""
        editor, others = self._editor, self._others()
        film = self._film()
        if not others or editor.files.busy:
            return
        editor.document.commit()
        self._push()
        for row in range(film.count()):
            film.item(row).setSelected(film.path(row) in others)
        percent = round(editor.document.state.recipe.percent, 4)
        files = {path: self._storage.edits.newest(path) for path in others}
        signs = {path: sign_in(file) for path, file in files.items() if file is not None}
        editor.sync.start()
        self._push()
        self._until(lambda: not editor.sync.busy)
        for path in others:
            if self._restored and path == editor.document.path:
                continue  # it was opened meanwhile, with other edits
            newest, before = self._storage.edits.newest(path), signs.get(path)
            held = None if newest is None else sign_in(newest)
            if held is None or held[0] != path.name:
                continue  # the strip doesn't show this photo, or its faces aren't found yet
            if before is not None:
                after = _as_if_sought(held[1], before[1])
                if after not in (before[1], (percent, *before[1][1:])):
                    raise Lost(f"sync made {held[1]} of {before} of {path.name}")
                if after != before[1]:
                    self._synced[path.name] = before[1]
                    self._by_sync.setdefault(path.name, set()).update((before[1], held[1]))
            self._left[path.name] = held[1]

    def _reset(self) -> None:
        editor = self._editor
        editor.document.commit()
        self._push()
        editor.projects.reset()
        self._until(lambda: not editor.projects.busy)
        self._push()

    def _open(self, path: Path) -> None:
        self._editor.files.open(path)
        if not self._books.name:
            self._until(lambda: not (self._editor.files.busy or self._editor.faces.busy))
            self._follow()

    def _close(self) -> None:
        self._editor.window.close()

    def _press_bar(self) -> None:
        unwanted = ("Open a photo", "Place a face", "It fits", "Finish", "Undo")
        if not self._editor.window.bar.isVisible():
            return
        buttons = self._editor.window.bar.buttons
        wanted = [one for one in buttons if not one.text().startswith(unwanted)]
        if wanted:
            self._press(self._one_of(wanted))

    def _press(self, button: QPushButton) -> None:
        self.log.append(f"  {button.text()}")
        if button.text() == "Take theirs":
            self._books.discarded = self._books.work
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)

    def _answer(self, dialog: QDialog) -> None:
        if isinstance(dialog, QMessageBox):
            button = self._one_of(dialog.buttons())
            if "for good" in dialog.text():
                self._answer_discard(button)
                return
            if "Discard" in button.text():
                self._books.discarded = self._books.work
            self._press(button)
        elif isinstance(dialog, QFileDialog):
            self._name(dialog)

    def _answer_discard(self, button: QPushButton) -> None:
        before, agreed = Counter(self._kept()), "Discard" in button.text()
        self._press(button)
        self._app.processEvents()
        for gone in before - Counter(self._kept()):
            if agreed and gone in self._books.owed:
                self._books.owed.remove(gone)

    def _name(self, dialog: QFileDialog) -> None:
        kind = str(self._rng.choice(["good", "cancel", "bad", "original"], p=[0.6, 0.2, 0.1, 0.1]))
        self.log.append(f"  {kind}")
        if kind == "cancel":
            dialog.reject()
            return
        self._copies += 1
        path = self._folder / f"copy{self._copies}.{'png' if kind == 'good' else 'odd'}"
        if "project" in dialog.windowTitle():
            path = path.with_name(f"{path.name}.kogao.json")
        self._asked[path.name] = path
        chosen = self._folder / self._books.name if kind == "original" else path
        dialog.filesSelected.emit([str(chosen)])
        dialog.reject()


def _signs(folder: Path) -> list[tuple[str, Sign] | None]:
    """Return the photo and the work of each recovery file."""
    return [sign_in(path) for path in folder.glob("*.json")]


def _as_if_sought(work: Sign, before: Sign) -> Sign:
    """Return work without its faces where they were still sought before: they are found again."""
    return (work[0], before[1] and work[1], work[2])
