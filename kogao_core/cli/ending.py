"""Exit codes and one-line errors. Imports only small modules, for a quick start."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Final

import click

from kogao_core.base.language import as_text, translated
from kogao_core.base.wording import printable, sentence, system_reason

BROKEN: Final = 1
USAGE: Final = 2
UNREADABLE: Final = 3
NO_FACE: Final = 4
SOME_FAILED: Final = 5
OWN_RESULT: Final = 7  # 6 is the editor's
UNEXPECTED: Final = 70  # EX_SOFTWARE of sysexits.h


class Stop(click.ClickException):
    """Ends the command with one line on stderr and an exit code, USAGE by default."""

    def __init__(self, message: object, code: int = USAGE, /, **values: object) -> None:
        super().__init__(as_text(message, **values))
        self.code = code


@contextmanager
def stopping(kinds: type[Exception] | tuple[type[Exception], ...], code: int) -> Iterator[None]:
    """Convert exceptions of these types to `Stop`."""
    try:
        yield
    except kinds as error:
        raise Stop(error, code) from error


@contextmanager
def refusing(message: str, **values: object) -> Iterator[None]:
    """Convert an OSError to `Stop`. The field ``reason`` of the message is the system's reason."""
    try:
        yield
    except OSError as error:
        raise Stop(message, UNREADABLE, reason=system_reason(error), **values) from error


def writing(path: Path) -> AbstractContextManager[None]:
    """Convert an OSError on writing a file or folder to `Stop`."""
    return refusing("{path} can't be written ({reason})", path=path)


def print_text(text: str, *, err: bool = False) -> None:
    """Print lines on stdout or stderr; replace control characters by '?'."""
    click.echo("\n".join(map(printable, text.split("\n"))), err=err)


def print_message(message: str, **values: object) -> None:
    """Print one line on stderr, in the user's language."""
    click.echo(f"kogao-cli: {sentence(translated(as_text(message, **values)))}", err=True)
