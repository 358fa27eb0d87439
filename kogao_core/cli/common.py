"""What the commands share: kinds of values, files that may be written, ``--json [F]``, progress."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from kogao_core.base.atomic import NotAFile, check_target, put
from kogao_core.base.language import Text, tr
from kogao_core.base.wording import sentence, system_reason
from kogao_core.cli import ending, words

# Whether it may be read is found, and said, by whoever reads it.
PHOTO: Final = click.Path(path_type=Path, readable=False)
FILE: Final = click.Path(path_type=Path, dir_okay=False)
FOLDER: Final = click.Path(path_type=Path, file_okay=False)
STDOUT: Final = Path("-")
CALM_S: Final = 2.0  # between two lines of progress off a terminal
_PLACE: Final = click.Path(path_type=Path, dir_okay=False, allow_dash=True)
_Command = TypeVar("_Command", bound=Callable[..., Any])


class Number(click.FloatRange):
    """A finite number within a range; click itself lets NaN through."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read a number; NaN and infinities are none."""
        number: float = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(Text("{value} is not a finite number.", value=value), param, ctx)
        return number


def check_free(file: Path, force: bool) -> None:
    """Stop when a file may not be written: one is there without `force`, or no file can be."""
    try:
        check_target(file)
    except NotAFile as error:
        raise ending.Stop(
            Text(
                "{file} can't be replaced: {reason}; name another file",
                file=file,
                reason=system_reason(error),
            )
        ) from None
    if file.exists() and not force:
        raise ending.Stop(Text("{file} exists; --force replaces it", file=file))


limits_megapixels = words.option(
    "--max-megapixels",
    type=Number(min=0, min_open=True),
    default=300.0,
    show_default=True,
    help="Refuse larger photos.",
)


forces = words.option("--force", is_flag=True, help="Replace existing files.")


def each(photos: Sequence[Path], work: Callable[[Path], None]) -> int:
    """Work on photos and return the exit code; what stops one of several is told, no more."""
    code = 0
    for photo in photos:
        try:
            work(photo)
        except ending.Stop as stop:
            if len(photos) == 1:
                raise
            ending.print_message(stop.message)
            code = ending.SOME_FAILED
    return code


def count_of_faces(count: int) -> Text:
    """Return ``1 face`` or ``2 faces``."""
    return Text.counted(count, "{n} face", "{n} faces")


def _no_photo(_: click.Context, __: click.Parameter, file: Path | None) -> Path | None:
    """Refuse a photo's name: with F left out, the photo that follows would be taken for it."""
    if file is None or file == STDOUT:
        return file

    from kogao_core.photo import READABLE  # of use where a file is named; loads numpy

    if file.suffix.lower() in READABLE:
        raise words.bad_value(
            Text("{file} is a photo's name; name another file, or - to print.", file=file)
        )
    return file


def writes(kind: str, what: Text) -> Callable[[_Command], _Command]:
    """Return what adds an option to write a kind of file, or to print it, to a command."""
    return words.option(
        f"--{kind}", f"{kind}_file", type=_PLACE, is_flag=False, flag_value="-", metavar="[F]",
        callback=_no_photo, help=what,
    )  # fmt: skip


writes_json = writes("json", Text("Write everything as JSON; without F, or with -, print it."))


def check_report(file: Path | None, force: bool) -> None:
    """Check, before work begins, that the file can be written. Raises Stop."""
    if file is None or file == STDOUT:
        return
    check_free(file, force)
    if not file.parent.is_dir():
        raise ending.Stop(
            Text("there is no folder {folder}; make it first", folder=file.parent),
            ending.UNREADABLE,
        )
    if not os.access(file.parent, os.W_OK | os.X_OK):
        raise ending.Stop(
            Text("the folder {folder} isn't writable; choose another one", folder=file.parent),
            ending.UNREADABLE,
        )


def deliver(found: Callable[[], Any], text: Callable[[], str], file: Path | None) -> None:
    """Print what was found for people, unless JSON is printed, and write it where asked to.

    Raises Stop.
    """
    if file == STDOUT:
        click.echo(json.dumps(found()))
        return
    ending.print_text(text())
    if file is not None:
        with ending.writing(file):
            put((json.dumps(found()) + "\n").encode(), file)


def tell(found: Callable[[], Any], text: Callable[[], str], file: Path | None) -> None:
    """Deliver what is known of a photo that is written: what fails now is a note, not an error."""
    try:
        deliver(found, text, file)
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except ending.Stop as stop:
        ending.print_message(Text("the photo is written; {problem}", problem=stop.message))
    except Exception as error:
        ending.print_message(
            Text(
                "the photo is written, but what was done can't be told ({problem})",
                problem=system_reason(error) if isinstance(error, OSError) else str(error),
            )
        )


class ProgressLine:
    """Shows what is being worked on.

    Off a terminal a line is printed for a step that ends at least `CALM_S` after the last line, or
    after the start: what is quickly done says nothing.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last = clock()
        self._what = ""

    def begin(self, what: str) -> None:
        """Begin something, such as a photo."""
        self._what = what
        self._show(what)

    def step(self, done: int, total: int) -> None:
        """Show how many of its steps are done."""
        self._show(tr("{what}, {done} of {total} steps", what=self._what, done=done, total=total))

    def end(self) -> None:
        """Clear the line of a terminal for what follows."""
        if sys.stderr.isatty():
            click.echo("\r\x1b[K", nl=False, err=True)

    def _show(self, line: str) -> None:
        if sys.stderr.isatty():
            click.echo(f"\r\x1b[K{sentence(line)}", nl=False, err=True)
        elif self._clock() >= self._last + CALM_S:
            self._last = self._clock()
            click.echo(sentence(line), err=True)
