"""The window: made, shown and left; `__main__` has read the arguments before this loads Qt."""

from __future__ import annotations

import argparse
import os
import signal
import socket
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSocketNotifier, Qt, QTemporaryDir
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QApplication

from kogao_core.base import assets
from kogao_core.base.originals import Originals
from kogao_core.faces.face import LandmarkSource

from .ahead import Ahead
from .editor import Editor
from .faults import Faults
from .features.screen import FIRST_PX
from .i18n import speak
from .preferences import LANGUAGE, SCALE, preferred
from .screenshot import Screenshot
from .storage import Storage

_DESKTOP_ID: Final = "org.kogao.Kogao"


def start(
    options: argparse.Namespace, source: LandmarkSource, ahead: Ahead | None, *, hears: bool
) -> int:
    """Run the editor by its options and return its exit code."""
    # A picture shows the program as it comes, whatever this user has made of it.
    aside = None if options.screenshot is None else QTemporaryDir()
    storage = Storage.of_user() if aside is None else Storage.in_folder(Path(aside.path()))
    app = QApplication.instance() or _application(storage)
    assert isinstance(app, QApplication)
    if hears:
        _hear_signals(app)
    speak(app, options.language or preferred(storage.settings(), LANGUAGE))
    faults = Faults(storage.log)
    store = Originals(storage.originals).for_now() if options.temporary else nullcontext()
    with faults.heard(), store as originals:
        return _edit(app, options, source, storage, faults, ahead, originals)


def _application(storage: Storage) -> QApplication:
    """Return the application at the preferred size of its text, which Qt reads but once."""
    percent = preferred(storage.settings(), SCALE)
    if percent:
        # Whoever has set it for this start means it.
        os.environ.setdefault("QT_SCALE_FACTOR", str(int(percent) / 100))
    app = QApplication(sys.argv[:1])
    app.setApplicationName("Kogao")
    # By this name a desktop knows whose window it is, and which icon that has.
    app.setDesktopFileName(_DESKTOP_ID)
    app.setWindowIcon(QIcon(str(assets.path(f"desktop/{_DESKTOP_ID}.svg"))))
    return app


def _hear_signals(app: QApplication) -> None:
    """Let a signal be seen while Qt waits: Python's handlers run between Python's instructions."""
    ours, pythons = socket.socketpair()
    for end in (ours, pythons):
        end.setblocking(False)
    signal.set_wakeup_fd(pythons.fileno(), warn_on_full_buffer=False)
    notifier = QSocketNotifier(ours.fileno(), QSocketNotifier.Type.Read, app)
    notifier.activated.connect(lambda *_, _kept=pythons: ours.recv(64))


def _edit(
    app: QApplication,
    options: argparse.Namespace,
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
        look = options.show, options.percent, options.protect
        shot = Screenshot(editor, options.screenshot, *look)
    # Queued: what has failed may be a picture in the middle of being painted.
    report = editor.admit if shot is None else shot.admit
    faults.caught.connect(report, Qt.ConnectionType.QueuedConnection)
    editor.window.show()
    if options.edit:
        editor.errand.begin(options.photos, ahead, originals)
    elif ahead is not None or (options.photos and shot is not None):
        editor.files.open(options.photos[0], ahead)
    elif options.photos:
        editor.strip.show_places(options.photos)
    elif options.sample:
        editor.files.open_sample()
    elif options.rate is not None:
        editor.rating.open(options.rate)
    else:
        editor.recent.begin()
        editor.strip.resume()
    editor.recovery.look()
    code = app.exec()
    if options.edit:
        return code or editor.errand.code
    return code if shot is None else shot.finish()
