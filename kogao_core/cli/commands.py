"""All commands of ``kogao-cli``, and how a run of one of them ends."""

from __future__ import annotations

import io
import os
import shlex
import sys
import traceback
from collections.abc import Sequence

import click

import kogao_core
from kogao_core.base.installed import has_laboratory
from kogao_core.base.interrupts import CODE
from kogao_core.base.language import Text, system_languages, tr, translated, use_language
from kogao_core.base.stderr import open_standard_streams
from kogao_core.base.threads import end_at_once, keep_freed, without_blas_threads
from kogao_core.base.wording import system_reason
from kogao_core.cli import words
from kogao_core.cli.ending import BROKEN, UNEXPECTED, UNREADABLE, USAGE, Stop, print_message

PROGRAM = "kogao-cli"
DEBUG = "KOGAO_DEBUG"
"""Name of the environment variable that makes tracebacks visible."""
_LONGEST_ERROR = 200

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
  7  a photo is one of Kogao's own results, and was left alone (--results
     works on it again)
  70  an error in the program itself, or too little memory; with
     KOGAO_DEBUG=1 the traceback comes before the line
  130  interrupted; a batch goes on where it stopped when started again

Errors are one line on stderr; nothing half-written is left behind.
""")


# Each command and its help's first sentence: a list of all takes 0.1 s, and 0.5 s where the module
# of each is loaded for its own.
_LATER = {
    "warp": Text(
        "Make the faces in the photo IN smaller and write the result to OUTPUT, or over IN itself."
    ),
    "restore": Text("Bring back, byte for byte, a photo that was changed in place."),
    "verify": Text(
        "Tell which blocks and which metadata of two JPEGs differ, and that nothing else does."
    ),
    "batch": Text(
        "Make the faces in many photos smaller: files, folders, patterns such as 'in/*.jpg'."
    ),
    "detect": Text("Find the faces in the photo IN."),
    "landmarks": Text("Give landmarks to other programs."),
    "presets": Text("List the recipes with names, and exchange them as files."),
    # The door to the laboratory, whose command this is.
    "experiment": Text("Repeat the paper's tables and figures on your own photos."),
    "integrate": Text(
        "Put Kogao into the menus of the desktop, or among the tools of darktable, GIMP or Krita."
    ),
    "doctor": Text("Check versions, face networks and, on Linux, the libraries that Qt needs."),
    "licenses": Text("Print the licences of the program, its dependencies and its assets."),
}
_MODULES = {
    **{name: f"kogao_core.cli.{name}" for name in _LATER},
    "experiment": "kogao_core.lab.commands.experiment",
    "licenses": "kogao_core.cli.licences",
}
if not has_laboratory():
    del _LATER["experiment"]


@words.group(
    no_args_is_help=False, later={name: (_MODULES[name], said) for name, said in _LATER.items()}
)
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


def run(arguments: Sequence[str] | None) -> int:
    """Run a command and return its exit code; `arguments` default to the process's own."""
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
            tr(
                "{problem} (see {command} --help)",
                problem=_sentence(error),
                command=error.ctx.command_path if error.ctx else PROGRAM,
            ),
            USAGE,
        )
    except click.Abort:
        return _end(tr("interrupted"), CODE)
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
    except ImportError as error:
        from kogao_core.cli.doctor import incomplete  # rarely needed, and slow to load

        lacks = incomplete()
        return _end(lacks, BROKEN) if lacks else _unforeseen(error)
    except Exception as error:  # whatever happens ends in one line
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


def _end(message: str, code: int) -> int:
    print_message(message)
    return code
