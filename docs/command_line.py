"""Write `docs/command-line.md` from the commands of the program.

Run ``python docs/command_line.py`` after a change of an option. A test compares the page.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import click

from kogao_core.cli import words
from kogao_core.cli.declarations import EPILOG, PROGRAM, program

PAGE: Final = Path(__file__).with_name("command-line.md")
_SHARED: Final = 3
"""Options of at least so many commands are listed once, in a section of their own."""
_HEAD: Final = """# Command line

[日本語](ja/command-line.md)

`kogao-cli` does the same work as the editor, without a window. This page lists all options;
`python docs/command_line.py` writes it from the program. Defaults are in brackets. N is a number.

```sh
kogao-cli warp portrait.jpg -o six.jpg                      # amount 6 %
kogao-cli warp portrait.jpg -o four.jpg --amount 4 --face largest --save-project
kogao-cli warp big.jpg -o big-small.jpg --project portrait.jpg.kogao.json
kogao-cli warp - -o - < portrait.jpg > piped.jpg
kogao-cli batch photos/ 'more/*.jpg' -o small/ --jobs 4     # run again to resume
kogao-cli detect portrait.jpg --json -                      # 27 landmarks per face
kogao-cli landmarks export portrait.jpg --format csv -o points/
kogao-cli experiment timing portrait.jpg -o report/         # Table 2
kogao-cli experiment study make portrait.jpg -o study/      # pictures for a survey
kogao-cli doctor                                            # check the installation
kogao-cli --language ja warp --help
```

## Output

`warp` prints one line per photo: output file, faces, change, unchanged share of a JPEG.

```text
six.jpg: 1 face, 6 % smaller; 45.0 % of the JPEG unchanged
```

*Amount* is the distance that landmarks move, in % of their distance to the centre of the face.
*reshaped* means that other settings changed the face, too. Warnings and errors go to stderr. `-q`
prints only these; `-v` adds measurements and timings; `--json` prints all figures for programs.

Above 6 %, many people in the survey of the paper called a face unnatural. `kogao-cli` overwrites no
file without `--force`.

## Pipes

`warp -` reads the photo from standard input. `-o -` writes to standard output in the format of the
photo (JPEG for HEIC and raw) and prints the line on stderr.

## Several computers

`batch --cluster` runs a batch on the workers of a [Dask](https://distributed.dask.org) scheduler,
with the plan, report and resuming of a batch on one computer. All need this version of Kogao with
the extra `[cluster]`, and photos and results in a folder that all see at one path. Run the batch in
that folder.

```text
dask scheduler --protocol tls                                   on one computer
dask worker tls://host:8786 --nworkers 4 --nthreads 1           on each computer that works
kogao-cli batch photos/ -o small/ --cluster tls://host:8786     in the shared folder
```

Each of them reads the certificates from `~/.config/dask/distributed.yaml`:

```yaml
distributed:
  comm:
    require-encryption: true
    tls:
      ca-file: ca.pem
      scheduler: {cert: host.pem, key: host-key.pem}
      worker: {cert: host.pem, key: host-key.pem}
      client: {cert: host.pem, key: host-key.pem}
```

Give full paths of files there. Without TLS (`tcp://`), whoever reaches the scheduler can run any
program on its workers: use it only within one computer. Dask runs the photos of a worker that died
on others. A photo at which four workers died is tried once more in the end, then it fails. `dask
worker` starts dead workers again. If the scheduler stops, start it and run the batch again.
`--projects` isn't possible: earlier names of photos are known on one computer only.

## Completion

Add one line to the configuration of your shell:

```text
eval "$(_KOGAO_CLI_COMPLETE=bash_source kogao-cli)"         ~/.bashrc
eval "$(_KOGAO_CLI_COMPLETE=zsh_source kogao-cli)"          ~/.zshrc
_KOGAO_CLI_COMPLETE=fish_source kogao-cli | source          ~/.config/fish/config.fish
```

For the editor, write `_KOGAO_COMPLETE` and `kogao`.

## Exit codes
"""


def text() -> str:
    """Return the page."""
    codes = EPILOG.partition("Exit codes:\n")[2].partition("\n\n")[0]
    # Without the settings, click would forget -h for the whole process.
    root = click.Context(program, info_name=PROGRAM, **program.context_settings)
    found = list(_commands(program, root))
    uses = Counter(row for command, context in found for row in _rows(command, context))
    shared = [row for row, count in uses.items() if count >= _SHARED]
    parts = [
        _HEAD,
        f"```text\n{codes}\n```\n",
        "## Options of several commands\n",
        "Commands take the options that `kogao-cli COMMAND --help` lists.\n",
        _table(shared),
    ]
    pair = [context for context in found if context[0].name in ("warp", "batch")]
    both = [row for row, count in uses.items() if count == 2 and _in_all(row, pair)]
    parts += ["## Options of `warp` and `batch`\n", _grouped(both, *pair[0])]
    known = {*shared, *both}
    for command, context in found:
        parts.append(f"## `{_usage(command, context)}`\n")
        parts.append(" ".join((command.help or "").partition("\n\n")[0].split()) + "\n")
        own = [row for row in _rows(command, context) if row not in known]
        if own:
            parts.append(_table(own))
    return "\n".join(parts)


def _commands(
    command: click.Command, context: click.Context
) -> Iterator[tuple[words.Command, click.Context]]:
    """Yield each command that is no group, with its context."""
    if isinstance(command, words.Group):
        for name, inner in command.every.items():
            yield from _commands(inner, click.Context(inner, context, info_name=name))
    elif isinstance(command, words.Command):
        yield command, context


def _usage(command: click.Command, context: click.Context) -> str:
    pieces = [piece for piece in command.collect_usage_pieces(context) if piece != "[OPTIONS]"]
    return " ".join([context.command_path, *pieces])


def _rows(command: words.Command, context: click.Context) -> list[str]:
    """Return the rows of all options but ``--help``, in the order of the help."""
    found = [one for options in command.sections(context).values() for one in options]
    return [_row(one, context) for one in found if isinstance(one, words.Option)]


def _grouped(rows: list[str], command: words.Command, context: click.Context) -> str:
    """Return tables of some rows below the headings of a command's help."""
    parts = []
    for section, options in command.sections(context).items():
        inside = [row for one in options if (row := _row(one, context)) in rows]
        if inside:
            parts += [f"### {section}\n", _table(inside)]
    return "\n".join(parts)


def _in_all(row: str, commands: list[tuple[words.Command, click.Context]]) -> bool:
    return all(row in _rows(command, context) for command, context in commands)


def _table(rows: list[str]) -> str:
    return "\n".join(["| option | meaning |", "|---|---|", *rows]) + "\n"


def _row(option: click.Parameter, context: click.Context) -> str:
    declared, meaning = option.get_help_record(context) or ("", "")
    declared, meaning = (" ".join(cell.replace("|", r"\|").split()) for cell in (declared, meaning))
    return f"| `{declared}` | {meaning} |"


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
