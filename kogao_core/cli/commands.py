"""The ``kogao-cli`` program: all commands, error messages and exit codes."""

from __future__ import annotations

import io
import logging
import os
import shlex
import sys
import traceback
from collections.abc import Sequence

import click

from kogao_core.base.installed import has_laboratory
from kogao_core.base.interrupts import CODE
from kogao_core.base.language import Text, system_languages, tr, translated, use_language
from kogao_core.base.stderr import open_standard_streams
from kogao_core.base.threads import reuse_freed_memory, skip_final_collection, without_blas_threads
from kogao_core.base.wording import system_reason
from kogao_core.cli import words
from kogao_core.cli.ending import BROKEN, UNEXPECTED, UNREADABLE, USAGE, Stop, print_message

PROGRAM = "kogao-cli"
DEBUG = "KOGAO_DEBUG"
"""Environment variable that enables tracebacks."""
_LONGEST_ERROR = 200
_REMOVED = (
    *("--label-picture", "--label-corner", "--label-share"),
    *("--sign-certificate", "--sign-key"),
)

EPILOG = Text("""\
Exit codes:
  0    done
  1    incomplete installation (see kogao-cli doctor)
  2    wrong usage: unknown option, value out of range, unusable recipe or
       project, existing output (overwrite with --force), or a format that
       can't hold the photo
  3    unreadable input or unwritable output
  4    no face, or only doubtful faces (include these with --doubtful)
  5    some photos of a batch failed; see the report
  6    kogao --edit was closed without saving
  7    input is a result of Kogao (accept with --results)
  70   internal error or too little memory (traceback with KOGAO_DEBUG=1)
  130  interrupted; run the same batch again to resume

An error prints one line on stderr and leaves no partial file.
""")


# Each command with the first sentence of its help. Listing them takes 0.1 s instead of the 0.5 s
# that loading all modules takes.
_LATER = {
    "warp": Text("Make the faces in a photo smaller and save the result."),
    "restore": Text("Restore the original of a photo that was changed in place."),
    "originals": Text("List the stored originals, newest first."),
    "forget": Text("Delete everything Kogao stores about a photo."),
    "verify": Text("Compare two JPEGs and list the blocks and metadata that differ."),
    "batch": Text("Make the faces in many photos smaller."),
    "detect": Text("Find the faces in a photo."),
    "read": Text("Measure how a retouch moved the faces of a photo."),
    "landmarks": Text("Export landmarks for other programs."),
    "presets": Text("List the presets, or print the recipe of preset NAME as JSON."),
    "experiment": Text("Repeat the paper's tables and figures on your own photos."),
    "integrate": Text("Add Kogao to the desktop, darktable, GIMP or Krita."),
    "doctor": Text("Check the installation: versions, networks, libraries."),
    "licenses": Text("Print the licences of the program and its components."),
}
_DECLARED = (
    *("warp", "restore", "originals", "forget", "verify", "batch", "detect", "read", "landmarks"),
)
_MODULES = {
    **{name: f"kogao_core.cli.{name}" for name in _LATER},
    **{name: f"kogao_core.cli.declarations:{name}" for name in _DECLARED},
    "experiment": "kogao_core.lab.commands.experiment",
    "licenses": "kogao_core.cli.licences",
}
if not has_laboratory():
    del _LATER["experiment"]


HELP_NAMES = {"help_option_names": ["-h", "--help"]}


@words.group(
    later={name: (_MODULES[name], first) for name, first in _LATER.items()},
    context_settings=HELP_NAMES,
    examples=(
        "kogao-cli warp portrait.jpg -o slim.jpg",
        "kogao-cli batch photos/ -o slim/",
        "kogao-cli warp --help",
    ),
)
@words.chooses_language
@words.shows_version
def program() -> None:
    """Make faces in photos slightly smaller (method of Seo, Chen and Aoki, 2011)."""


program.codes = EPILOG


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
        problem = _sentence(error)
        if isinstance(error, click.NoSuchOption) and error.option_name in _REMOVED:
            problem = tr(
                "{option} was removed; use --label or --disclose", option=error.option_name
            )
        return _end(
            tr(
                "{problem} (see {command} --help)",
                problem=problem,
                command=error.ctx.command_path if error.ctx else PROGRAM,
            ),
            USAGE,
        )
    except click.Abort:
        return _end(tr("interrupted"), CODE)
    except BrokenPipeError:  # the reader closed the pipe, as in | head
        _drop_the_rest()
        return 0
    except OSError as error:
        reason = system_reason(error)
        if error.filename is not None:
            return _end(f"{os.fsdecode(error.filename)}: {translated(reason)}", UNREADABLE)
        _drop_the_rest()
        return _end(
            tr("the report can't be printed: {reason}", reason=reason),
            UNREADABLE,
        )
    except ImportError as error:
        from kogao_core.cli.doctor import incomplete  # slow to import and rarely needed

        lacks = incomplete()
        return _end(lacks, BROKEN) if lacks else _unforeseen(error)
    except Exception as error:  # every error ends in one line
        return _unforeseen(error)
    return code if isinstance(code, int) else 0


def _unforeseen(error: Exception) -> int:
    from kogao_core.warp.limits import OutOfBounds  # loads numpy

    if isinstance(error, OutOfBounds):
        return _end(translated(error), USAGE)
    if os.environ.get(DEBUG):
        traceback.print_exception(error)
    if isinstance(error, MemoryError):
        return _end(
            tr("not enough memory; close other programs, or use a smaller photo or fewer faces"),
            UNEXPECTED,
        )
    text = " ".join(f"{type(error).__name__}: {error}".split())[:_LONGEST_ERROR]
    return _end(
        tr(
            "internal error ({text}); please report the output of the same command with {debug}=1",
            text=text,
            debug=DEBUG,
        ),
        UNEXPECTED,
    )


def _drop_the_rest() -> None:
    # Otherwise Python reports the same error again at exit.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _sentence(error: click.ClickException) -> str:
    return " ".join(translated(error.format_message()).split()).rstrip(".。")


def _end(message: str, code: int) -> int:
    print_message(message)
    return code
