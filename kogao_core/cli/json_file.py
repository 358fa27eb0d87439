"""``--json [F]``: all that a command found, for programs; in every command the same."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from kogao_core.base.atomic import put
from kogao_core.base.language import Text
from kogao_core.base.wording import system_reason
from kogao_core.cli import common, ending, words

STDOUT: Final = Path("-")
_PLACE: Final = click.Path(path_type=Path, dir_okay=False, allow_dash=True)
_Command = TypeVar("_Command", bound=Callable[..., Any])


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


def check(file: Path | None, force: bool) -> None:
    """Check, before work begins, that the file can be written. Raises Stop."""
    if file is None or file == STDOUT:
        return
    common.check_free(file, force)
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
