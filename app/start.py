"""Start of the window: runs the event loop or takes a screenshot. This module loads Qt."""

from __future__ import annotations

import dataclasses
import os
import signal
import socket
import sys
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import Final, get_args

from PySide6.QtCore import QCoreApplication, QObject, QSocketNotifier, Qt, QTemporaryDir, QTimer
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QApplication

from kogao_core.additions.limits import OutOfBounds, check_protection
from kogao_core.base import assets
from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Box
from kogao_core.base.wording import sentence, system_reason
from kogao_core.faces.face import LandmarkSource
from kogao_core.photo.originals import Originals

from .ahead import Ahead
from .canvas.overlays.listed import LISTED
from .editor import Editor
from .faults import Faults
from .features.preferences import LANGUAGE, SCALE, preferred
from .features.screen import FIRST_PX
from .i18n import reason, speak
from .render.pictures import encoded
from .storage import Storage
from .view_state import CompareName, ToolName

_DESKTOP_ID: Final = "org.kogao.Kogao"
_JAW: Final = 0.72  # share of the outline
_LAYOUT_PASSES: Final = 4
FAILED: Final = 1
USAGE: Final = 2
UNREADABLE: Final = 3
NO_FACE: Final = 4


def start(
    options: SimpleNamespace, source: LandmarkSource, ahead: Ahead | None, *, hears: bool
) -> int:
    """Run the editor with the options and return the exit code."""
    # A screenshot shows the program with default settings.
    aside = None if options.screenshot is None else QTemporaryDir()
    storage = Storage.of_user() if aside is None else Storage.in_folder(Path(aside.path()))
    app = QApplication.instance() or _application(storage)
    assert isinstance(app, QApplication)
    if hears:
        _hear_signals(app)
    speak(app, options.language or preferred(storage.settings(), LANGUAGE))
    faults = Faults(storage.log)
    store = Originals(storage.originals).temporary() if options.temporary else nullcontext()
    with faults.heard(), store as originals:
        return _edit(app, options, source, storage, faults, ahead, originals)


def _application(storage: Storage) -> QApplication:
    """Return the application at the preferred text scale, which Qt reads only once."""
    percent = preferred(storage.settings(), SCALE)
    if percent:
        # The environment variable overrides the preference.
        os.environ.setdefault("QT_SCALE_FACTOR", str(int(percent) / 100))
    app = QApplication(sys.argv[:1])
    app.setApplicationName("Kogao")
    # Desktops find the program and the icon by this name.
    app.setDesktopFileName(_DESKTOP_ID)
    app.setWindowIcon(QIcon(str(assets.path(f"desktop/{_DESKTOP_ID}.svg"))))
    return app


def _hear_signals(app: QApplication) -> None:
    """Wake Qt on signals: Python's handlers run only between Python instructions."""
    ours, pythons = socket.socketpair()
    for end in (ours, pythons):
        end.setblocking(False)
    signal.set_wakeup_fd(pythons.fileno(), warn_on_full_buffer=False)
    notifier = QSocketNotifier(ours.fileno(), QSocketNotifier.Type.Read, app)
    notifier.activated.connect(lambda *_, _kept=pythons: ours.recv(64))


def _edit(
    app: QApplication,
    options: SimpleNamespace,
    source: LandmarkSource,
    storage: Storage,
    faults: Faults,
    ahead: Ahead | None,
    originals: Originals | None,
) -> int:

    editor = Editor(app, source, storage, options.theme, options.workspace)
    if options.size is not None or options.screenshot is not None:
        editor.window.resize(*(options.size or FIRST_PX))
    shot = None
    if options.screenshot is not None:
        look = options.show, options.settings, options.protect
        shot = Screenshot(editor, options.screenshot, *look)
    # Queued: the exception may come from the middle of a repaint.
    report = editor.admit if shot is None else shot.admit
    faults.caught.connect(report, Qt.ConnectionType.QueuedConnection)
    editor.window.show()
    if options.edit:
        editor.errand.begin(options.photos, ahead, originals, options.mask)
    elif ahead is not None or (options.photos and shot is not None):
        editor.files.open(options.photos[0], ahead)
    elif options.photos:
        editor.strip.show_places(options.photos)
    elif options.sample:
        editor.files.open_sample()
    else:
        editor.recent.begin()
    editor.recovery.look()
    editor.sync.look()
    code = app.exec()
    if options.edit:
        return code or editor.errand.code
    return code if shot is None else shot.finish()


def names() -> frozenset[str]:
    """Return the names of all overlays, comparison modes and tools for a screenshot."""
    overlays = (overlay.name for overlay in LISTED)
    return frozenset({*overlays, *get_args(CompareName), *get_args(ToolName), "loupe"} - {"off"})


class Screenshot(QObject):
    """Waits until the editor is idle and takes a screenshot."""

    def __init__(
        self,
        editor: Editor,
        path: Path,
        show: frozenset[str] | None = None,
        settings: Mapping[str, object] = MappingProxyType({}),
        protect: tuple[tuple[float, float], ...] | None = None,
    ) -> None:
        super().__init__(editor)
        self._editor, self._path, self._settings, self._protect = editor, path, settings, protect
        self._code, self._line = 0, ""
        editor.saver.keeps = False  # a screenshot must not save edits
        if show is not None:
            editor.marks.show_all()
            self._show(show)
        editor.files.unreadable.connect(self._give_up)
        editor.files.wants_photo.connect(
            lambda file: self._give_up(f"the photo of {file} isn't beside it; put it there")
        )
        editor.faces.not_found.connect(lambda why: self._end(FAILED, f"no face was found: {why}"))
        editor.live.failed.connect(self._not_drawn)
        editor.surroundings.not_seen.connect(self._fail)
        editor.faces.found.connect(self._arrive)
        editor.live.settled.connect(self._take)
        editor.surroundings.seen.connect(self._take)
        self._found = self._over = False

    def finish(self) -> int:
        """Print the error, if any, and return the exit code."""
        if self._line:
            print(f"kogao: {sentence(self._line)}", file=sys.stderr)
        return self._code

    def _arrive(self, faces: int) -> None:
        self._found = True
        if not faces and not self._code:
            self._end(NO_FACE, f"no face in {self._editor.document.path}")
        self._edit()
        if not self._editor.live.busy:
            self._take()

    def _show(self, shown: frozenset[str]) -> None:
        for name, action in self._editor.window.actions_by_name.items():
            kind, _, what = name.partition("-")
            if kind == "overlay" or (kind == "compare" and what in get_args(CompareName)):
                action.setChecked(what in shown)
            elif kind == "tool" and what in shown:
                action.trigger()
        self._editor.window.actions_by_name["loupe"].setChecked("loupe" in shown)

    def _edit(self) -> None:
        state, photo = self._editor.document.state, self._editor.document.photo
        if self._settings:
            state = state.with_choices(None, **self._settings)
        if self._protect is not None and photo is not None:
            radius = self._editor.view.brush.radius_px
            protection = state.protection.with_stroke(self._protect, radius)
            try:
                check_protection(protection, Box.of(photo.pixels))
            except OutOfBounds as problem:
                self._fail(reason(problem), USAGE)
                return
            state = dataclasses.replace(state, protection=protection)
        if state is not self._editor.document.state:
            self._editor.document.restore(state)
        if state.faces:
            # The loupe needs a cursor: use the jaw, where the displacement is largest.
            outline = state.faces[0].outline
            x, y = outline[int(_JAW * len(outline))].tolist()
            self._editor.view.set(cursor=(x, y))

    def _take(self) -> None:
        if self._found:
            # Deliver pending signals to the panels first.
            QTimer.singleShot(0, self._shoot)

    def _shoot(self) -> None:
        if self._over or self._editor.live.busy or self._editor.surroundings.busy:
            return  # called again when rendering has ended
        # Nested layouts pass on a new width one event at a time.
        for _ in range(_LAYOUT_PASSES):
            QCoreApplication.sendPostedEvents()
        try:
            atomic_write(encoded(self._editor.window.grab(), self._path.suffix), self._path)
        except OSError as error:
            why = system_reason(error)
            self._end(
                UNREADABLE,
                f"{self._path} can't be written ({why}); choose another name ending in .png",
            )
        self._leave()

    def admit(self, why: str) -> None:
        """End without a screenshot after an unexpected error."""
        self._fail(f"something went wrong in the program itself ({why}); please report it")

    def _not_drawn(self, problem: Exception) -> None:
        self._fail(f"{self._editor.document.path} can't be rendered: {reason(problem)}")

    def _fail(self, line: str, code: int = FAILED) -> None:
        self._end(code, line)
        self._leave()

    def _give_up(self, why: str) -> None:
        self._fail(why, UNREADABLE)

    def _leave(self) -> None:
        self._over = True
        self._editor.close()

    def _end(self, code: int, line: str) -> None:
        self._code, self._line = code, line
