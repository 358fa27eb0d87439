"""``kogao-cli``: the same rendering as the editor, without Qt.

It may use all rooms; of the laboratory it knows the name of one module.
"""

from __future__ import annotations

import io
import os
import shlex
import signal
import sys
import threading
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import click

import kogao_core
from kogao_core.base.installed import has_laboratory
from kogao_core.base.language import Text, system_languages, tr, translated, use_language
from kogao_core.base.memory import end_at_once, keep_freed
from kogao_core.base.stderr import open_standard_streams
from kogao_core.base.threads import without_blas_threads
from kogao_core.base.wording import system_reason
from kogao_core.cli import words
from kogao_core.cli.common import UNEXPECTED, UNREADABLE, USAGE, Stop, print_message

PROGRAM = "kogao-cli"
INTERRUPTED = 130
DEBUG = "KOGAO_DEBUG"
"""Name of the environment variable that makes tracebacks visible."""
_LONGEST_ERROR = 200
_ENDING = ("SIGTERM", "SIGHUP")

EPILOG = Text("""\
Exit codes:
  0  done
  1  the installation is incomplete (see kogao-cli doctor)
  2  wrong usage: an unknown option, a value out of range, a recipe or a
     project that can't be used, an output that exists (--force replaces
     it) or whose format can't hold the photo
  3  the photo can't be read, or the output can't be written (no such
     folder, no permission, disk full)
  4  no face found, or none but doubtful ones (--doubtful takes them)
  5  some photos of a batch weren't done; its report says why
  6  nothing was saved: kogao --edit was closed without
  70  an error in the program itself, or too little memory; with
     KOGAO_DEBUG=1 the traceback comes before the line
  130  interrupted; a batch goes on where it stopped when started again

Errors are one line on stderr; nothing half-written is left behind.
""")


# Each module that isn't needed makes the program start later.
_MODULES = (
    *("warp", "restore", "batch", "detect", "landmarks", "presets"),
    *("experiment", "integrate", "doctor"),
)
_LATER = {name: f"{__name__}.{name}" for name in _MODULES}
_LATER["licenses"] = f"{__name__}.licences"
# The door to the laboratory, whose command this is.
_LATER["experiment"] = "kogao_core.lab.commands.experiment"
if not has_laboratory():
    del _LATER["experiment"]


@words.group(no_args_is_help=False, later=_LATER)
@words.chooses_language
@click.version_option(
    kogao_core.__version__,
    prog_name=PROGRAM,
    cls=words.Option,
    help=Text("Show the version and exit."),
)
def program() -> None:
    """Make faces smaller, exactly (Seo, Chen and Aoki, 2011)."""


program.codes = EPILOG


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program and exit; `arguments` default to the process's own."""
    with _told_to_end():
        code = _run(arguments)
    sys.exit(code)


@contextmanager
def _told_to_end() -> Iterator[None]:
    """Let what ends a program from outside do so as Ctrl-C does: in a word, nothing left aside.

    Whoever has it ignored, as nohup has, is let alone.
    """
    numbers = [getattr(signal, name) for name in _ENDING if hasattr(signal, name)]
    mine = [number for number in numbers if signal.getsignal(number) is signal.SIG_DFL]
    if threading.current_thread() is not threading.main_thread():
        mine = []  # Python refuses
    for number in mine:
        signal.signal(number, signal.default_int_handler)
    try:
        yield
    finally:
        for number in mine:
            signal.signal(number, signal.SIG_DFL)


def _run(arguments: Sequence[str] | None) -> int:
    open_standard_streams()
    keep_freed()
    end_at_once()
    without_blas_threads()
    use_language(*system_languages())
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names of files may be any bytes
    try:
        given = list(sys.argv[1:] if arguments is None else arguments)
        command_line = shlex.join([PROGRAM, *given])  # reports tell it
        code = program.main(given, prog_name=PROGRAM, standalone_mode=False, obj=command_line)
        if sys.stdout:  # there is none where a program was started without
            sys.stdout.flush()
    except Stop as stop:
        return _end(_sentence(stop), stop.code)
    except click.UsageError as error:
        return _end(
            tr("{problem} (see {command} --help)", problem=_sentence(error), command=_path(error)),
            USAGE,
        )
    except click.Abort:
        return _end(tr("interrupted"), INTERRUPTED)
    except BrokenPipeError:  # the reader has had enough (| head)
        _drop_the_rest()
        return 0
    except OSError as error:
        reason = system_reason(error)
        if error.filename is not None:
            return _end(f"{os.fsdecode(error.filename)}: {translated(reason)}", UNREADABLE)
        _drop_the_rest()
        return _end(
            tr("what was done can't be printed ({reason}); print it elsewhere", reason=reason),
            UNREADABLE,
        )
    except Exception as error:  # whatever happens ends in one line
        return _unforeseen(error)
    return code if isinstance(code, int) else 0


def _unforeseen(error: Exception) -> int:
    from kogao_core.warp.limits import OutOfBounds

    if isinstance(error, OutOfBounds):
        return _end(translated(error), USAGE)
    if os.environ.get(DEBUG):
        traceback.print_exception(error)
    if isinstance(error, MemoryError):
        return _end(
            tr(
                "this doesn't fit into memory; close other programs, or take a smaller photo or "
                "fewer faces"
            ),
            UNEXPECTED,
        )
    text = " ".join(f"{type(error).__name__}: {error}".split())[:_LONGEST_ERROR]
    return _end(
        tr(
            "an error in the program itself ({text}); please report it with what is printed when "
            "{debug}=1 is set",
            text=text,
            debug=DEBUG,
        ),
        UNEXPECTED,
    )


def _drop_the_rest() -> None:
    # Python would complain again at exit.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _sentence(error: click.ClickException) -> str:
    return " ".join(translated(error.format_message()).split()).rstrip(".。")


def _path(error: click.UsageError) -> str:
    return error.ctx.command_path if error.ctx else PROGRAM


def _end(message: str, code: int) -> int:
    print_message(message)
    return code
