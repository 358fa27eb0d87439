"""The ``kogao-cli`` program: all commands, error messages and exit codes."""

from __future__ import annotations

import io
import logging
import os
import shlex
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress

import click

from kogao_core.base.interrupts import CODE
from kogao_core.base.language import system_languages, translated, use_language
from kogao_core.base.stderr import open_standard_streams
from kogao_core.base.threads import reuse_freed_memory, skip_final_collection, without_blas_threads
from kogao_core.base.wording import system_reason
from kogao_core.cli.declarations import PROGRAM, program
from kogao_core.cli.ending import BROKEN, UNEXPECTED, UNREADABLE, USAGE, Stop, print_message

DEBUG = "KOGAO_DEBUG"
"""Environment variable that enables tracebacks."""
_LONGEST_ERROR = 200


def run(arguments: Sequence[str] | None) -> int:
    """Run a command and return the exit code. `arguments` default to ``sys.argv[1:]``."""
    open_standard_streams()
    reuse_freed_memory()
    skip_final_collection()
    without_blas_threads()
    use_language(*system_languages())
    if logging.lastResort:  # the handler of warnings if no other handler is installed
        logging.lastResort.setFormatter(logging.Formatter(f"{PROGRAM}: %(message)s"))
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # file names can contain any bytes
    try:
        given = list(sys.argv[1:] if arguments is None else arguments)
        command_line = shlex.join([PROGRAM, *given])  # stored in reports
        code = program.main(given, prog_name=PROGRAM, standalone_mode=False, obj=command_line)
        if sys.stdout:  # None if the program was started without stdout
            sys.stdout.flush()
    except Stop as stop:
        return _end(_sentence(stop), stop.code)
    except click.UsageError as error:
        return _end(
            "{problem} (see {command} --help)",
            USAGE,
            problem=_sentence(error),
            command=error.ctx.command_path if error.ctx else PROGRAM,
        )
    except click.Abort:
        return _end("interrupted", CODE)
    except (BrokenPipeError, SystemExit):  # the reader closed the pipe, as in | head: click exits
        _drop_the_rest()
        return 0
    except OSError as error:
        reason = system_reason(error)
        if error.filename is not None:
            file = os.fsdecode(error.filename)
            return _end("{path}: {problem}", UNREADABLE, path=file, problem=reason)
        _drop_the_rest()
        return _end("the report can't be printed: {reason}", UNREADABLE, reason=reason)
    except Exception as error:  # every error ends in one line
        return _unforeseen(error)
    return code if isinstance(code, int) else 0


def _unforeseen(error: Exception) -> int:
    with suppress(ImportError):  # of numpy, which may be the error
        from kogao_core.additions.limits import OutOfBounds

        if isinstance(error, OutOfBounds):
            return _end(translated(error), USAGE)
    if os.environ.get(DEBUG):
        traceback.print_exception(error)
    if isinstance(error, MemoryError):
        return _end(
            "not enough memory; close other programs, or use a smaller photo or fewer faces",
            UNEXPECTED,
        )
    from kogao_core.cli.doctor import incomplete  # slow to import and rarely needed

    if lacks := incomplete():
        return _end(lacks, BROKEN)
    text = " ".join(f"{type(error).__name__}: {error}".split())[:_LONGEST_ERROR]
    return _end(
        "internal error ({text}); please report the output of the same command with {debug}=1",
        UNEXPECTED,
        text=text,
        debug=DEBUG,
    )


def _drop_the_rest() -> None:
    # Otherwise Python reports the same error again at exit.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _sentence(error: click.ClickException) -> str:
    return " ".join(translated(error.format_message()).split()).rstrip(".。")


def _end(message: str, code: int, /, **values: object) -> int:
    print_message(message, **values)
    return code
