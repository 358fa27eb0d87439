"""Parts shared by the commands: value types, output checks, ``--json [F]``, pipes, progress."""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from math import isfinite
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from kogao_core.base import assets
from kogao_core.base.atomic import NotAFile, atomic_write, check_target
from kogao_core.base.language import Text, tr
from kogao_core.base.wording import sentence, shown, system_reason
from kogao_core.cli import ending, words

# The reader checks the permission and prints a better message than click.
PHOTO: Final = click.Path(path_type=Path, readable=False)
FILE: Final = click.Path(path_type=Path, dir_okay=False)
FOLDER: Final = click.Path(path_type=Path, file_okay=False)
STDIN: Final = Path("-")
STDOUT: Final = STDIN
CALM_S: Final = 2.0  # least time between two progress lines if stderr is no terminal
_PLACE: Final = click.Path(path_type=Path, dir_okay=False, allow_dash=True)
_Command = TypeVar("_Command", bound=Callable[..., Any])


class Number(click.FloatRange):
    """A finite number within a range. click accepts NaN."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Convert the value. Reject NaN and infinity."""
        with suppress(click.BadParameter):
            number = float(super().convert(value, param, ctx))
            if isfinite(number):
                return number
        raise words.bad_value(
            "{value} is not a number in the range {limits}.",
            value=shown(value),
            limits=_limits(self),
        )


class Whole(click.IntRange):
    """A whole number within a range. click calls it a valid integer range."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Convert the value."""
        with suppress(click.BadParameter):
            return int(super().convert(value, param, ctx))
        raise words.bad_value(
            "{value} is not a whole number in the range {limits}.",
            value=shown(value),
            limits=_limits(self),
        )


def _limits(numbers: Number | Whole) -> str:
    """Return a range as in the help: ``1..100``, ``>=1`` or ``>0``."""
    if numbers.max is not None:
        return f"{numbers.min:g}..{numbers.max:g}"
    return f"{'>' if numbers.min_open else '>='}{numbers.min:g}"


def check_free(file: Path, force: bool) -> None:
    """Raise Stop if the file exists (without `force`) or can't be replaced."""
    try:
        check_target(file)
    except NotAFile as error:
        raise ending.Stop(
            "{file} can't be replaced: {reason}; name another file",
            file=file,
            reason=system_reason(error),
        ) from None
    if file.exists() and not force:
        raise ending.Stop("{file} already exists; use --force to overwrite", file=file)


limits_megapixels = words.option(
    "--max-megapixels",
    type=Number(min=0, min_open=True),
    default=300.0,
    help="Refuse larger photos, above 0 [300]",
)


forces = words.option("--force", is_flag=True, help="Overwrite existing files")


def each(photos: Sequence[Path], work: Callable[[Path], None]) -> int:
    """Call `work` for each photo and return the exit code. With several, print errors, continue."""
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


def no_photo(_: click.Context, parameter: click.Parameter, file: Path | None) -> Path | None:
    """Reject the name of a photo. Without F, click takes the next argument for F."""
    if file is None or file == STDOUT:
        return file

    from kogao_core.photo import READABLE  # loads numpy

    if file.suffix.lower() in READABLE:
        if parameter.type is not _PLACE:
            raise words.bad_value("{file} is a photo; name another file.", file=file)
        raise words.bad_value(
            "{file} is a photo; name a report file, or - for standard output.", file=file
        )
    return file


def writes(kind: str, what: Text) -> Callable[[_Command], _Command]:
    """Return a decorator that adds an option to write or print a kind of report."""
    return words.option(
        f"--{kind}", f"{kind}_file", type=_PLACE, is_flag=False, flag_value="-", metavar="[F]",
        callback=no_photo, help=what,
    )  # fmt: skip


writes_json = writes("json", Text("Write a JSON report to F; print it without F or with -"))


def check_report(file: Path | None, force: bool) -> None:
    """Check that a report file can be written. Raises Stop."""
    if file is None or file == STDOUT:
        return
    check_free(file, force)
    if not file.parent.is_dir():
        raise ending.Stop(
            "folder {folder} doesn't exist; create the folder first",
            ending.UNREADABLE,
            folder=file.parent,
        )
    if not os.access(file.parent, os.W_OK | os.X_OK):
        raise ending.Stop(
            "folder {folder} isn't writable; choose another folder",
            ending.UNREADABLE,
            folder=file.parent,
        )


def input_path(source: Path | None, sample: bool) -> Path:
    """Return the path of the photo or the sample. Raises Stop unless exactly one is given."""
    if (source is None) != sample:
        raise ending.Stop("name one photo, or use --sample")
    if source is not None:
        return source

    with ending.stopping(assets.AssetMissing, ending.BROKEN):
        return assets.sample()


@contextmanager
def received() -> Iterator[Path]:
    """Copy standard input to a temporary file and yield the path."""
    with tempfile.TemporaryDirectory(prefix="kogao-") as folder:
        path = Path(folder, "stdin")
        with path.open("wb") as file:
            shutil.copyfileobj(sys.stdin.buffer, file)
        if path.stat().st_size == 0:
            raise ending.Stop(
                "standard input is empty; pipe a photo into the command", ending.UNREADABLE
            )
        yield path


@contextmanager
def sent(suffix: str) -> Iterator[Path]:
    """Yield a temporary path; copy the file to standard output if the block succeeds."""
    with tempfile.TemporaryDirectory(prefix="kogao-") as folder:
        path = Path(folder, f"stdout{suffix}")
        yield path
        with path.open("rb") as file:
            shutil.copyfileobj(file, sys.stdout.buffer)


def deliver(
    found: Callable[[], Any], text: Callable[[], str], file: Path | None, *, err: bool = False
) -> None:
    """Print the text, or the JSON if `file` is STDOUT. Write the JSON to any other `file`.

    With `err`, the text goes to stderr. An empty text prints nothing. Raises Stop.
    """
    if file == STDOUT:
        click.echo(json.dumps(found()))
        return
    if said := text():
        ending.print_text(said, err=err)
    if file is not None:
        with ending.writing(file):
            atomic_write((json.dumps(found()) + "\n").encode(), file)


def tell(
    found: Callable[[], Any], text: Callable[[], str], file: Path | None, *, err: bool = False
) -> None:
    """Print the report after the photo was saved. A failure prints a message, keeps the code 0."""
    try:
        deliver(found, text, file, err=err)
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        raise
    except Exception as error:
        problem = system_reason(error) if isinstance(error, OSError) else str(error)
        ending.print_message("photo saved, but the report failed: {problem}", problem=problem)


class ProgressLine:
    """Shows the current photo and step on stderr.

    If stderr is no terminal, a line is printed at most every `CALM_S` seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last = clock()
        self._what = ""

    def begin(self, what: str) -> None:
        """Show the name of the next item, such as a photo."""
        self._what = what
        self._show(what)

    def step(self, done: int, total: int) -> None:
        """Show the number of completed steps of the item."""
        self._show(tr("{what}, {done} of {total} steps", what=self._what, done=done, total=total))

    def end(self) -> None:
        """Clear the line on a terminal."""
        if sys.stderr.isatty():
            click.echo("\r\x1b[K", nl=False, err=True)

    def _show(self, line: str) -> None:
        if sys.stderr.isatty():
            click.echo(f"\r\x1b[K{sentence(line)}", nl=False, err=True)
        elif self._clock() >= self._last + CALM_S:
            self._last = self._clock()
            click.echo(sentence(line), err=True)
