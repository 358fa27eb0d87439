"""How far a command is, on stderr: a line that changes on a terminal, a calm few elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Final

import click

from kogao_core.base import wording
from kogao_core.base.language import tr

CALM_S: Final = 2.0  # between two lines off a terminal


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
            click.echo(f"\r\x1b[K{wording.sentence(line)}", nl=False, err=True)
        elif self._clock() >= self._last + CALM_S:
            self._last = self._clock()
            click.echo(wording.sentence(line), err=True)
