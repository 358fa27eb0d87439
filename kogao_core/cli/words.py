"""click commands and options with translated help, option groups and examples."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from functools import wraps
from importlib import import_module
from types import SimpleNamespace
from typing import Any, TypeVar

import click

import kogao_core
from kogao_core.base.language import Text, as_text, languages, looked_up, translated, use_language
from kogao_core.base.wording import shown

_Function = TypeVar("_Function", bound=Callable[..., Any])


class Option(click.Option):
    """An option with translated help, below a heading `section`; without a section it comes first.

    `needs`: an option that must be given, too. `excludes`: options that can't be combined with it.
    """

    def __init__(
        self,
        names: Sequence[str],
        help: str | None = None,  # noqa: A002
        section: str = "",
        needs: str | None = None,
        excludes: Sequence[str] = (),
        **settings: Any,
    ) -> None:
        super().__init__(names, **settings)
        self.help = help  # click would convert a `Text` to a plain string
        self.section, self.needs, self.excludes = section, needs, excludes

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        with _translated_help(self, self.help):
            return super().get_help_record(ctx)

    def get_error_hint(self, *_: Any) -> str:
        return f"'{self.opts[0]}'"

    def get_help_extra(self, ctx: click.Context) -> Any:
        """Return default and range. A help without default states the range in words."""
        extra = super().get_help_extra(ctx)
        if not self.show_default:
            extra.pop("range", None)
        return extra

    def make_metavar(self, *args: Any, **context: Any) -> str:
        """Return the placeholder of the value: N for a number."""
        kinds = click.types.IntParamType, click.types.FloatParamType
        if self.metavar is None and isinstance(self.type, kinds):
            return "N"
        return super().make_metavar(*args, **context)


class Command(click.Command):
    """A command. The help is the function's docstring; command lines `examples` follow.

    The exit codes `codes` end the help.
    """

    def __init__(
        self, *names: Any, examples: Sequence[str] = (), codes: str = "", **settings: Any
    ) -> None:
        super().__init__(*names, **settings)
        self.help = inspect.cleandoc(self.help or "")
        self.examples, self.codes = examples, codes

    def get_short_help_str(self, limit: int = 45) -> str:
        with _translated_help(self, self.help):
            head, stop, _ = (self.help or "").partition("。")  # click knows only "."
            if stop:
                return head if len(head) <= limit else f"{head[: limit - 1]}…"
            return super().get_short_help_str(limit)

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with _translated_help(self, self.help):
            super().format_help_text(ctx, formatter)
        if self.examples:
            with formatter.section(looked_up(Text("Examples"))):
                for line in self.examples:
                    formatter.write(f"{'':{formatter.current_indent}}{line}\n")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        for section, options in self.sections(ctx).items():
            with formatter.section(translated(section)):
                formatter.write_dl([option.get_help_record(ctx) or ("", "") for option in options])

    def sections(self, ctx: click.Context) -> dict[str, list[click.Parameter]]:
        """Return the visible options by section. Options without a section come first."""
        found: dict[str, list[click.Parameter]] = {"": []}
        for option in self.get_params(ctx):
            if isinstance(option, click.Option) and option.get_help_record(ctx) is not None:
                found.setdefault(getattr(option, "section", ""), []).append(option)
        first = Text("Common options") if len(found) > 1 else Text("Options")
        return {section or first: options for section, options in found.items()}

    def get_help_option(self, ctx: click.Context) -> click.Option | None:
        """Return ``--help`` with help in the current language; click caches the first one."""
        option = super().get_help_option(ctx)
        if option is not None:
            option.help = looked_up("Show this message and exit.")
        return option

    def invoke(self, ctx: click.Context) -> Any:
        """Check that the given options can be combined, then run the command."""
        given = [one for one in self.params if is_given(one, ctx)]
        names = {name for one in given for name in one.opts}
        for one in given:
            if isinstance(one, Option):
                _check_partners(one, names, ctx)
        return super().invoke(ctx)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        self.epilog = self.codes and f"\b\n{translated(self.codes)}"  # \b: keep line breaks
        super().format_epilog(ctx, formatter)


class Group(Command, click.Group):
    """A command with subcommands. Without a subcommand it prints the help.

    The module `later`, if any, is imported with the first use and adds the subcommands.
    """

    command_class = Command
    group_class = type  # groups of this class

    def __init__(self, *names: Any, later: str = "", **settings: Any) -> None:
        super().__init__(*names, **{"no_args_is_help": False, **settings})
        self._later = later

    @property
    def every(self) -> Mapping[str, click.Command]:
        """All commands by name, in the order of declaration."""
        if self._later:
            import_module(self._later)
        return self.commands

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments; print the help if there are none."""
        if not args and not ctx.resilient_parsing:
            click.echo(ctx.get_help(), color=ctx.color)
            ctx.exit()
        return super().parse_args(ctx, args)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command of the first argument. Suggest similar names if there is none."""
        name = args[0]
        if not name.startswith("-") and self.get_command(ctx, name) is None:
            similar = get_close_matches(name, self.list_commands(ctx))
            if not similar:
                raise click.UsageError(Text("no command {name}", name=shown(name)), ctx)
            raise click.UsageError(
                Text(
                    "no command {name}; did you mean {similar}?",
                    name=shown(name),
                    similar=", ".join(similar),
                ),
                ctx,
            )
        return super().resolve_command(ctx, args)

    def list_commands(self, _: click.Context) -> list[str]:
        return sorted(self.every)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        self.format_commands(ctx, formatter)
        super().format_options(ctx, formatter)

    def get_command(self, _: click.Context, cmd_name: str) -> click.Command | None:
        return self.every.get(cmd_name)


def is_given(one: click.Parameter, ctx: click.Context) -> bool:
    """Return True if the option or argument was given on the command line."""
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


def command(name: str, **settings: Any) -> Callable[[Callable[..., Any]], Command]:
    """Return a decorator that makes a `Command` of a function."""
    return click.command(name, cls=Command, **settings)


def group(name: str | None = None, **settings: Any) -> Callable[[Callable[..., Any]], Group]:
    """Return a decorator that makes a `Group` of a function."""
    return click.group(name, cls=Group, **settings)


def loads(place: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator: the command imports MODULE:FUNCTION when it runs, and calls FUNCTION.

    FUNCTION receives the values of all options as the attributes of one object.
    """

    def add(declared: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(declared)
        def run(**given: Any) -> Any:
            module, _, function = place.partition(":")
            return getattr(import_module(module), function)(SimpleNamespace(**given))

        return run

    return add


def option(*names: str, **settings: Any) -> Callable[[_Function], _Function]:
    """Return a decorator that adds an `Option` to a command."""
    return click.option(*names, cls=Option, **settings)


def together(*options: Callable[[_Function], _Function]) -> Callable[[_Function], _Function]:
    """Return a decorator that adds several options and arguments in this order."""

    def add(command: _Function) -> _Function:
        for one in reversed(options):
            command = one(command)
        return command

    return add


def section(
    title: Text, *options: Callable[[_Function], _Function]
) -> Callable[[_Function], _Function]:
    """Return a decorator that adds options under a heading of the help."""

    def add(command: _Function) -> _Function:
        before = [*getattr(command, "__click_params__", ())]
        command = together(*options)(command)
        for one in getattr(command, "__click_params__", ()):
            if isinstance(one, Option) and one not in before and not one.section:
                one.section = title
        return command

    return add


def bad_value(why: str, **values: object) -> click.BadParameter:
    """Return the error for a bad value of an option; click puts the option's name in front."""
    return click.BadParameter(translated(as_text(why, **values)))


@contextmanager
def _translated_help(one: Option | Command, words: str | None) -> Iterator[None]:
    """Replace the help of an option or a command by the translation inside the block."""
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
            raise bad_value("{code} is none of {known}.", code=shown(code), known=among)
        use_language(code)


chooses_language = option(
    "--language", metavar="CODE", is_eager=True, expose_value=False, callback=_speak,
    help=Text(
        "Language of messages and help: {known} [language of the system]",
        known=", ".join(languages()),
    ),
)  # fmt: skip
shows_version = click.version_option(
    kogao_core.__version__,
    "-V",
    "--version",
    message="%(prog)s %(version)s",
    cls=Option,
    help=Text("Show the version and exit."),
)
