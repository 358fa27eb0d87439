"""``kogao [PHOTO ...]``: the editor."""

from __future__ import annotations

import argparse
import ctypes
import os
import socket
import sys
from collections.abc import Sequence
from itertools import chain
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Final

from kogao_core.base import installed, interrupts
from kogao_core.base.language import languages, system_languages, tr, translated, use_language
from kogao_core.base.stderr import open_standard_streams
from kogao_core.base.threads import end_at_once, take_short_turns, without_blas_threads
from kogao_core.base.wording import shown
from kogao_core.recipe.recipe import Recipe

from .workspaces import WORKSPACES

if TYPE_CHECKING:
    from kogao_core.faces.face import LandmarkSource

BROKEN: Final = 1
_OF_SCREENSHOT: Final = ("show", "percent", "protect")  # what only a picture can show


def main(argv: Sequence[str] | None = None, source: LandmarkSource | None = None) -> int:
    """Run the editor."""
    if argv is None:
        interrupts.end_when_told("kogao")
    open_standard_streams()
    without_blas_threads()
    take_short_turns()
    end_at_once()
    use_language(*([asked] if (asked := _language(argv)) else system_languages()))
    options = _options(argv)
    if options.screenshot is not None and not options.photos:
        options.sample = True
    try:
        if lacks := _lacking(options):
            return _end(lacks)
        return _run(options, source, hears=argv is None)
    except ImportError:
        if lacks := _incomplete():
            return _end(lacks)
        raise


def _incomplete() -> str:
    """Return what this installation lacks; empty if it is whole."""
    from kogao_core.cli.doctor import incomplete  # takes as long to load as most commands

    return incomplete()


def _lacking(options: argparse.Namespace) -> str:
    """Return why Qt would abort here, which nobody can catch; empty if it wouldn't."""
    if sys.platform != "linux":
        return ""
    if options.screenshot is not None:  # the same picture with a display and without
        os.environ["QT_QPA_PLATFORM"] = "offscreen"
    if "QT_QPA_PLATFORM" in os.environ:
        return ""
    if installed.missing_libraries():
        return _incomplete()
    return "" if _has_display() else tr("there is no display here; kogao-cli works without one")


def _has_display() -> bool:
    """Tell whether a Wayland compositor or an X server answers."""
    compositor, display = (os.environ.get(f"{name}DISPLAY") for name in ("WAYLAND_", ""))
    if compositor:
        place = Path(os.environ.get("XDG_RUNTIME_DIR", "/"), compositor)
        with socket.socket(socket.AF_UNIX) as asked:
            if asked.connect_ex(str(place)) == 0:
                return True
    if not display:
        return False
    xcb = ctypes.CDLL("libxcb.so.1")
    xcb.xcb_connect.restype = ctypes.c_void_p
    connection = ctypes.c_void_p(xcb.xcb_connect(None, None))
    is_open = xcb.xcb_connection_has_error(connection) == 0
    xcb.xcb_disconnect(connection)
    return bool(is_open)


def _end(line: str) -> int:
    print(f"kogao: {line}", file=sys.stderr)
    return BROKEN


def _run(options: argparse.Namespace, source: LandmarkSource | None, *, hears: bool) -> int:
    ahead = None
    if len(options.photos) == 1 and not os.path.isdir(options.photos[0]):
        # Qt and the views take as long to load as the photo to read; a wrong call needs neither.
        from .ahead import Ahead

        ahead = Ahead(options.photos[0])
    from kogao_core.faces import landmarks  # loads OpenCV

    source = source or landmarks.source()
    if ahead is not None:
        ahead.seek(source)
    from .start import start  # loads Qt

    return start(options, source, ahead, hears=hears)


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
    if installed.has_laboratory():
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
    from .screenshot import names  # loads Qt

    asked = frozenset(text.split(","))
    unknown = sorted(asked - names())
    if unknown:
        known = ", ".join(sorted(names()))
        raise argparse.ArgumentTypeError(
            tr("{name} can't be shown; known: {known}", name=shown(unknown[0]), known=known)
        )
    return asked


def _percent(text: str) -> float:
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
