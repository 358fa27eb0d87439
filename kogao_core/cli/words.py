"""click's commands and options, whose help is in the user's language when it is shown."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any, TypeVar

import click

from kogao_core.base.language import Text, languages, looked_up, translated, use_language
from kogao_core.base.wording import shown

_Function = TypeVar("_Function", bound=Callable[..., Any])


class Option(click.Option):
    """An option.

    Parameters
    ----------
    *names : str
        As click has them.
    help : str or Text, optional
        What it does; a literal is found for the catalogues.
    needs : str, optional
        The option without which it says nothing.
    excludes : sequence of str
        Options that say nothing beside it.
    **settings : object
        As click has them.
    """

    def __init__(
        self,
        *names: Any,
        help: str | None = None,  # noqa: A002
        needs: str | None = None,
        excludes: Sequence[str] = (),
        **settings: Any,
    ) -> None:
        super().__init__(*names, **settings)
        self.help = help  # click itself would make a plain string of a `Text`
        self.needs, self.excludes = needs, excludes

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return the option and its help."""
        with _said_by(self, self.help):
            return super().get_help_record(ctx)


class Command(click.Command):
    """A command; its docstring is its help."""

    def __init__(self, *names: Any, **settings: Any) -> None:
        super().__init__(*names, **settings)
        self.help = inspect.cleandoc(self.help or "")
        self.codes = ""
        """What this and all commands that it leads to say below their own help."""

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

    def invoke(self, ctx: click.Context) -> Any:
        """Run it, unless an option is given that would say nothing."""
        given = [one for one in self.params if is_given(one, ctx)]
        spelled = {name for one in given for name in one.opts}
        for one in given:
            if isinstance(one, Option):
                _check_partners(one, spelled, ctx)
        return super().invoke(ctx)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write what stands below."""
        root = ctx.find_root().command
        codes = root.codes if isinstance(root, Command) else self.codes
        self.epilog = codes and f"\b\n{translated(codes)}"  # \b: lines stay as they are
        super().format_epilog(ctx, formatter)


class Group(Command, click.Group):
    """A command that leads to others.

    Parameters
    ----------
    *names : str
        As click has them.
    later : mapping of str to (str, Text), optional
        By the names of commands, their modules, which are loaded when a command is asked for, and
        their first sentences, which a list of all shows.
    **settings : object
        As click has them.
    """

    command_class = Command

    def __init__(
        self, *names: Any, later: Mapping[str, tuple[str, Text]] | None = None, **settings: Any
    ) -> None:
        super().__init__(*names, **settings)
        self._later = later or {}

    @property
    def every(self) -> dict[str, click.Command]:
        """All commands by their names, in the order in which they are declared."""
        for name in self._later:
            self._load(name)
        return {name: self.commands[name] for name in (*self._later, *self.commands)}

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands, sorted."""
        return sorted({*self._later, *super().list_commands(ctx)})

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of all commands."""
        if not self._later:
            super().format_commands(ctx, formatter)
            return
        listed = [Command(name, help=words) for name, (_, words) in self._later.items()]
        click.Group(commands=listed).format_commands(ctx, formatter)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of a name."""
        self._load(cmd_name)
        return super().get_command(ctx, cmd_name)

    def _load(self, name: str) -> None:
        if name in self._later and name not in self.commands:
            self.add_command(import_module(self._later[name][0]).command)


def is_given(one: click.Parameter, ctx: click.Context) -> bool:
    """Return whether somebody has typed an option or argument."""
    return ctx.get_parameter_source(one.name or "") is click.core.ParameterSource.COMMANDLINE


def _check_partners(option: Option, given: Collection[str], ctx: click.Context) -> None:
    name = option.opts[0]
    if option.needs is not None and option.needs not in given:
        raise click.UsageError(Text("{option} needs {other}", option=name, other=option.needs), ctx)
    for other in option.excludes:
        if other in given:
            raise click.UsageError(
                Text(
                    "{option} and {other} don't go together; leave one out",
                    option=name,
                    other=other,
                ),
                ctx,
            )


def command(name: str) -> Callable[[Callable[..., Any]], Command]:
    """Make a command of a function."""
    return click.command(name, cls=Command)


def group(name: str | None = None, **settings: Any) -> Callable[[Callable[..., Any]], Group]:
    """Make a command that leads to others of a function."""
    return click.group(name, cls=Group, **settings)


def option(*names: str, **settings: Any) -> Callable[[_Function], _Function]:
    """Add an option to a command; see `Option`."""
    return click.option(*names, cls=Option, **settings)


def together(*options: Callable[[_Function], _Function]) -> Callable[[_Function], _Function]:
    """Return what adds several options and arguments to a command, in their order."""

    def add(command: _Function) -> _Function:
        for one in reversed(options):
            command = one(command)
        return command

    return add


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
    help=Text(
        "Say everything in this language: {known} [the system's].", known=", ".join(languages())
    ),
)  # fmt: skip
