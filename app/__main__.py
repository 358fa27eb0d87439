"""``kogao [PHOTO ...]``: the editor."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Sequence
from itertools import chain
from math import isfinite
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Final

import click

from kogao_core.base import installed, interrupts
from kogao_core.base.language import Text, languages, system_languages, tr, translated, use_language
from kogao_core.base.stderr import open_standard_streams
from kogao_core.base.threads import (
    shorten_switch_interval,
    skip_final_collection,
    without_blas_threads,
)
from kogao_core.base.wording import sentence, shown
from kogao_core.cli import ending, words
from kogao_core.cli.options import recipe_of, sets_recipe
from kogao_core.recipe.recipe import SETTINGS

from .workspaces import WORKSPACES

if TYPE_CHECKING:
    from kogao_core.faces.face import LandmarkSource

BROKEN: Final = 1
_PATH: Final = click.Path(path_type=Path, readable=False)


def main(argv: Sequence[str] | None = None, source: LandmarkSource | None = None) -> int:
    """Run the editor."""
    if argv is None:
        interrupts.exit_on_signals("kogao")
    open_standard_streams()
    without_blas_threads()
    shorten_switch_interval()
    skip_final_collection()
    use_language(*system_languages())
    options = _parse(argv)
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
    """Return a message about missing files; empty if the installation is complete."""
    from kogao_core.cli.doctor import incomplete  # takes as long to load as most commands

    return incomplete()


def _lacking(options: SimpleNamespace) -> str:
    """Return why Qt would abort the process; empty if Qt can start."""
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
    """Return whether a Wayland compositor or an X server answers."""
    if sys.platform != "linux":
        return True
    if installed.has_compositor():
        return True
    if not os.environ.get("DISPLAY"):
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


def _run(options: SimpleNamespace, source: LandmarkSource | None, *, hears: bool) -> int:
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


def _parse(arguments: Sequence[str] | None) -> SimpleNamespace:
    """Return the options. Print help, version or an error and exit where these are requested."""
    try:
        found = _command().main(arguments, "kogao", standalone_mode=False)
    except click.UsageError as error:
        problem = " ".join(translated(error.format_message()).split()).rstrip(".。")
        print(sentence(tr("kogao: {problem} (see kogao --help)", problem=problem)), file=sys.stderr)
        sys.exit(error.exit_code)
    if not isinstance(found, SimpleNamespace):
        sys.exit(0)  # --help or --version
    return found


def _check(options: SimpleNamespace) -> None:
    """Raise UsageError for options that can't be combined."""
    if options.photos and options.sample:
        raise click.UsageError(Text("PHOTO and --sample can't be combined"))
    if options.screenshot is not None and len(options.photos) > 1:
        raise click.UsageError(Text("--screenshot shows one photo; name one"))
    if options.edit and (options.screenshot is not None or not options.photos):
        raise click.UsageError(Text("--edit needs photos and can't be combined with --screenshot"))
    try:
        recipe = recipe_of(options.recipe_file, vars(options))
    except ending.Stop as stop:
        raise click.UsageError(stop.message) from stop
    # Without --recipe, the other settings are the photo's own.
    given = (n for n in SETTINGS if options.recipe_file or getattr(options, n) is not None)
    options.settings = {name: getattr(recipe, name) for name in given}


def _picture_options() -> Callable[[Any], Any]:
    return words.section(
        Text("Picture of the window"),
        words.option(
            "--screenshot", type=_PATH, metavar="OUT.png",
            help="Save a picture of the window and exit",
        ),
        words.option(
            "--show", callback=_names, metavar="NAME,...", needs="--screenshot",
            help="Overlays, comparisons and tools to show (see docs/inspect.md) [overlays of the "
            "workspace]",
        ),
        words.option(
            "--protect", callback=_line, metavar="'X,Y X,Y'", needs="--screenshot",
            help="Protected line in the picture, px of the photo",
        ),
    )  # fmt: skip


def _host_options() -> Callable[[Any], Any]:
    return words.section(
        Text("For other programs"),
        words.option(
            "--edit", is_flag=True,
            help="Saving overwrites PHOTO; exit code 0, or 6 if closed without saving",
        ),
        words.option(
            "--temporary", is_flag=True, needs="--edit",
            help="With --edit: PHOTO is a temporary copy of another program; store no original",
        ),
        words.option(
            "--mask", type=_PATH, metavar="FILE", needs="--edit",
            help="With --edit: protect the white pixels of FILE, a picture of PHOTO's size",
        ),
    )  # fmt: skip


def _command() -> words.Command:
    kogao = words.command(
        "kogao",
        context_settings={"help_option_names": ["-h", "--help"]},
        examples=("kogao portrait.jpg", "kogao photos/", "kogao --sample --screenshot window.png"),
    )
    options = words.together(
        click.argument("photos", nargs=-1, type=_PATH, metavar="[PHOTO]..."),
        words.option("--sample", is_flag=True, help="Open the built-in portrait"),
        words.option(
            "--workspace", type=click.Choice(tuple(WORKSPACES)), help="Workspace [last used]"
        ),
        words.option(
            "--theme", type=click.Choice(("system", "light", "dark")),
            help="Colours of the window [preferences]",
        ),
        words.option(
            "--size", callback=_size, metavar="WxH", help="Size of the window, px [last used]"
        ),
        words.option(
            "--language", type=click.Choice(languages()), is_eager=True, callback=_speak,
            help="Language of all texts [preferences, else language of the system]",
        ),
        words.shows_version,
        _picture_options(),
        sets_recipe("--screenshot"),
        _host_options(),
    )  # fmt: skip

    def run(**given: Any) -> SimpleNamespace:
        """Make faces in photos slightly smaller.

        PHOTO is a photo, a project or a folder. Several photos open as a film strip. Settings need
        --screenshot.
        """
        found = SimpleNamespace(**given)
        _check(found)
        return found

    return kogao(options(run))


def _speak(_: click.Context, __: click.Parameter, code: str | None) -> str | None:
    if code is not None:
        use_language(code)
    return code


def _names(_: click.Context, __: click.Parameter, text: str | None) -> frozenset[str] | None:
    if text is None:
        return None
    from .start import names  # loads Qt

    asked = frozenset(text.split(","))
    unknown = sorted(asked - names())
    if unknown:
        known = ", ".join(sorted(names()))
        raise words.bad_value(
            Text("{name} can't be shown; known: {known}", name=shown(unknown[0]), known=known)
        )
    return asked


def _line(
    _: click.Context, __: click.Parameter, text: str | None
) -> tuple[tuple[float, float], ...] | None:
    if text is None:
        return None
    try:
        pairs = [point.split(",") for point in text.split()]
        line = tuple((float(x), float(y)) for x, y in pairs)
    except ValueError:
        line = ()
    if len(line) < 2 or not all(map(isfinite, chain(*line))):
        raise words.bad_value(Text("{text} isn't a line such as '80,40 80,600'.", text=shown(text)))
    return line


def _size(_: click.Context, __: click.Parameter, text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    width, height = (*text.split("x"), "")[:2]
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise words.bad_value(Text("{text} isn't a size such as 1280x800.", text=shown(text)))
    return int(width), int(height)


if __name__ == "__main__":
    sys.exit(main())
