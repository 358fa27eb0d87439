"""``--json [F]``: all that a command found, for programs; in every command the same."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from kogao_core.base.language import Text
from kogao_core.cli import common, words

STDOUT: Final = Path("-")
_PLACE: Final = click.Path(path_type=Path, dir_okay=False, allow_dash=True)
_Command = TypeVar("_Command", bound=Callable[..., Any])


def _no_photo(_: click.Context, __: click.Parameter, file: Path | None) -> Path | None:
    """Refuse a photo's name: with F left out, the photo that follows would be taken for it."""
    if file is None or file == STDOUT:
        return file
    from kogao_core.photo import READABLE

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
        raise common.Stop(
            Text("there is no folder {folder}; make it first", folder=file.parent),
            common.UNREADABLE,
        )
    if not os.access(file.parent, os.W_OK | os.X_OK):
        raise common.Stop(
            Text("the folder {folder} isn't writable; choose another one", folder=file.parent),
            common.UNREADABLE,
        )


def deliver(found: Callable[[], Any], text: Callable[[], str], file: Path | None) -> None:
    """Print what was found for people, unless JSON is printed, and write it where asked to.

    Raises Stop.
    """
    from kogao_core.base.atomic import put

    if file == STDOUT:
        click.echo(json.dumps(found()))
        return
    common.print_text(text())
    if file is not None:
        with common.writing(file):
            put((json.dumps(found()) + "\n").encode(), file)
