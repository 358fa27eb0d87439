"""click's commands and options, whose help is in the user's language when it is shown."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import click

from kogao_core.language import Text, languages, looked_up, translated, use_language
from kogao_core.wording import shown

_Function = TypeVar("_Function", bound=Callable[..., Any])
# Its text, or what makes it when it is shown, for what it comes from may load numpy.
Help = str | Callable[[], str] | None


class Option(click.Option):
    """An option.

    Parameters
    ----------
    *names : str
        As click has them.
    help : str, Text or callable, optional
        What it does; a literal is found for the catalogues.
    **settings : object
        As click has them.
    """

    def __init__(self, *names: Any, help: Help = None, **settings: Any) -> None:  # noqa: A002
        settings["help"] = None if callable(help) else help
        super().__init__(*names, **settings)
        self._words = help

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return the option and its help."""
        words = self._words() if callable(self._words) else self._words
        with _said_by(self, words):
            return super().get_help_record(ctx)


class Command(click.Command):
    """A command; its docstring is its help."""

    def __init__(self, *names: Any, **settings: Any) -> None:
        super().__init__(*names, **settings)
        self.help = inspect.cleandoc(self.help or "")
        self.codes = ""
        """What all commands say below their own help."""

    def get_short_help_str(self, limit: int = 45) -> str:
        """Return the first sentence of the help."""
        with _said_by(self, self.help):
            head, stop, _ = (self.help or "").partition("。")  # click knows of no stop but "."
            if stop:
                return head if len(head) <= limit else f"{head[: limit - 1]}…"
            return super().get_short_help_str(limit)

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the help."""
        with _said_by(self, self.help):
            super().format_help_text(ctx, formatter)

    def get_help_option(self, ctx: click.Context) -> click.Option | None:
        """Return ``--help``; click makes it once, in the language of that moment."""
        option = super().get_help_option(ctx)
        if option is not None:
            option.help = looked_up("Show this message and exit.")
        return option

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write what stands below."""
        self.epilog = self.codes and f"\b\n{translated(self.codes)}"  # \b: lines stay as they are
        super().format_epilog(ctx, formatter)


class Group(Command, click.Group):
    """A command that leads to others."""

    command_class = Command


def command(name: str) -> Callable[[Callable[..., Any]], Command]:
    """Make a command of a function."""
    return click.command(name, cls=Command)


def group(name: str | None = None, **settings: Any) -> Callable[[Callable[..., Any]], Group]:
    """Make a command that leads to others of a function."""
    return click.group(name, cls=Group, **settings)


def option(*names: str, **settings: Any) -> Callable[[_Function], _Function]:
    """Add an option to a command; see `Option`."""
    return click.option(*names, cls=Option, **settings)


def bad_value(why: Text) -> click.BadParameter:
    """Return what refuses an option's value; click puts its own words before."""
    return click.BadParameter(translated(why))


@contextmanager
def _said_by(one: Option | Command, words: str | None) -> Iterator[None]:
    """Let the help of an option or a command be words in the user's language meanwhile."""
    before = one.help
    one.help = translated(words) if isinstance(words, Text) else looked_up(words or "")
    try:
        yield
    finally:
        one.help = before


def _speak(_: click.Context, __: click.Parameter, code: str | None) -> None:
    if code is not None:
        known = languages()
        if code not in known:
            among = ", ".join(known)
            raise bad_value(Text("{code} is none of {known}.", code=shown(code), known=among))
        use_language(code)


chooses_language = option(
    "--language", metavar="CODE", is_eager=True, expose_value=False, callback=_speak,
    help=lambda: Text(
        "Say everything in this language: {known} [the system's].", known=", ".join(languages())
    ),
)  # fmt: skip
