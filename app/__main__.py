"""``kogao [PHOTO ...]``: the editor."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from itertools import chain
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Final

from kogao_core.base.installed import has_laboratory
from kogao_core.base.language import languages, system_languages, tr, translated, use_language
from kogao_core.base.memory import end_at_once
from kogao_core.base.stderr import open_standard_streams
from kogao_core.base.threads import take_short_turns, without_blas_threads
from kogao_core.base.wording import shown

from .workspaces import WORKSPACES

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

    from kogao_core.base.originals import Originals
    from kogao_core.faces.face import LandmarkSource

    from .ahead import Ahead
    from .faults import Faults
    from .storage import Storage

_DESKTOP_ID: Final = "org.kogao.Kogao"
_OF_SCREENSHOT: Final = ("show", "percent", "protect")  # what only a picture can show


def main(argv: Sequence[str] | None = None, source: LandmarkSource | None = None) -> int:
    """Run the editor."""
    open_standard_streams()
    without_blas_threads()
    take_short_turns()
    end_at_once()
    use_language(*([asked] if (asked := _language(argv)) else system_languages()))
    options = _options(argv)
    if options.screenshot is not None and not options.photos:
        options.sample = True
    ahead = None
    if len(options.photos) == 1 and not os.path.isdir(options.photos[0]):
        # Qt and the views take as long to load as the photo to read; a wrong call needs neither.
        from .ahead import Ahead

        ahead = Ahead(options.photos[0])
    from kogao_core.base.originals import Originals
    from kogao_core.faces import landmarks

    source = source or landmarks.source()
    if ahead is not None:
        ahead.seek(source)
    from PySide6.QtCore import QTemporaryDir
    from PySide6.QtWidgets import QApplication

    from .faults import Faults
    from .i18n import speak
    from .preferences import LANGUAGE, preferred
    from .storage import Storage

    # A picture shows the program as it comes, whatever this user has made of it.
    aside = None if options.screenshot is None else QTemporaryDir()
    storage = Storage.of_user() if aside is None else Storage.in_folder(Path(aside.path()))
    app = QApplication.instance() or _application(storage)
    assert isinstance(app, QApplication)
    speak(app, options.language or preferred(storage.settings(), LANGUAGE))
    faults = Faults(storage.log)
    store = Originals.for_now() if options.temporary else nullcontext()
    with faults.heard(), store as originals:
        return _edit(app, options, source, storage, faults, ahead, originals)


def _application(storage: Storage) -> QApplication:
    """Return the application at the preferred size of its text, which Qt reads but once."""
    from PySide6.QtGui import QIcon
    from PySide6.QtWidgets import QApplication

    from kogao_core.base import assets

    from .preferences import SCALE, preferred

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


def _edit(
    app: QApplication,
    options: argparse.Namespace,
    source: LandmarkSource,
    storage: Storage,
    faults: Faults,
    ahead: Ahead | None,
    originals: Originals | None,
) -> int:
    from PySide6.QtCore import Qt

    from .editor import Editor
    from .features.screen import FIRST_PX
    from .screenshot import Screenshot

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
    editor.recovery.look()
    code = app.exec()
    if options.edit:
        return code or editor.errand.code
    return code if shot is None else shot.finish()


def _language(argv: Sequence[str] | None) -> str | None:
    """Return the language that is asked for, which what is said of all else is said in."""
    first = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    first.add_argument("--language", nargs="?")
    asked: str | None = first.parse_known_args(argv)[0].language
    return asked


def _options(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = _parser()
    options = parser.parse_args(argv)
    if options.screenshot is not None and (len(options.photos) > 1 or options.rate is not None):
        parser.error(tr("--screenshot shows one photo; name one"))
    for name in _OF_SCREENSHOT if options.screenshot is None else ():
        if getattr(options, name) is not None:
            parser.error(tr("{option} needs {other}", option=f"--{name}", other="--screenshot"))
    if options.edit and (options.screenshot is not None or not options.photos):
        parser.error(
            tr("--edit takes the photos to be written over; name them, and no --screenshot")
        )
    if options.temporary and not options.edit:
        parser.error(tr("{option} needs {other}", option="--temporary", other="--edit"))
    return options


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="kogao", description=tr("Make faces a little smaller."))
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "photos",
        nargs="*",
        default=(),
        type=Path,
        metavar="PHOTO",
        help=tr("photo or project to open; a folder, or several photos, make a film strip"),
    )
    what.add_argument(
        "--sample", action="store_true", help=tr("open the portrait that is built in")
    )
    parser.set_defaults(rate=None)
    if has_laboratory():
        what.add_argument(
            "--rate",
            type=Path,
            metavar="FOLDER",
            help=tr("rate the pictures of a study (docs/study.md)"),
        )
    parser.add_argument(
        "--screenshot",
        type=Path,
        metavar="OUT.png",
        help=tr("save a picture of the window, and exit"),
    )
    parser.add_argument(
        "--edit",
        action="store_true",
        help=tr(
            "for other programs: saving writes over PHOTO; ends with 0, or 6 if nothing was saved"
        ),
    )
    parser.add_argument(
        "--temporary",
        action="store_true",
        help=tr(
            "with --edit: PHOTO is a copy that another program made for this; keep no original"
        ),
    )
    parser.add_argument(
        "--workspace",
        choices=tuple(WORKSPACES),
        help=tr(
            "what the window shows: the photo and its faces, both ways to set points, or "
            "everything (see docs/editor.md); what was shown last when absent"
        ),
    )
    parser.add_argument(
        "--show",
        type=_names,
        metavar="NAME,...",
        help=tr(
            "what the picture shows: overlays, ways to compare, tools (see docs/editor.md); "
            "the overlays of the workspace when absent"
        ),
    )
    parser.add_argument(
        "--percent", type=_percent, metavar="P", help=tr("warp distance in the picture, %% of D")
    )
    parser.add_argument(
        "--protect",
        type=_line,
        metavar="'X,Y X,Y'",
        help=tr("a line in the picture's photo, px, that must not move"),
    )
    parser.add_argument("--size", type=_size, metavar="WxH", help=tr("size of the window in px"))
    parser.add_argument(
        "--theme",
        choices=("system", "light", "dark"),
        help=tr("colours of the window; those of the preferences when absent"),
    )
    parser.add_argument(
        "--language",
        choices=languages(),
        help=tr("of all words and numbers; that of the preferences when absent, else the system's"),
    )
    return parser


def _names(text: str) -> frozenset[str]:
    from .screenshot import names

    asked = frozenset(text.split(","))
    unknown = sorted(asked - names())
    if unknown:
        known = ", ".join(sorted(names()))
        raise argparse.ArgumentTypeError(
            tr("{name} can't be shown; known: {known}", name=shown(unknown[0]), known=known)
        )
    return asked


def _percent(text: str) -> float:
    from kogao_core.recipe.recipe import Recipe

    try:
        return Recipe(percent=float(text)).percent
    except ValueError as error:
        raise argparse.ArgumentTypeError(translated(error)) from error


def _line(text: str) -> tuple[tuple[float, float], ...]:
    try:
        pairs = [point.split(",") for point in text.split()]
        line = tuple((float(x), float(y)) for x, y in pairs)
    except ValueError:
        line = ()
    if len(line) < 2 or not all(map(isfinite, chain(*line))):
        raise argparse.ArgumentTypeError(
            tr("{text} isn't a line such as '80,40 80,600'", text=shown(text))
        )
    return line


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise argparse.ArgumentTypeError(
            tr("{text} isn't a size such as 1280x800", text=shown(text))
        )
    return int(width), int(height)


if __name__ == "__main__":
    sys.exit(main())
