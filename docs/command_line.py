"""Write `docs/command-line.md` from the program's own commands.

``python docs/command_line.py`` after an option has changed; a test compares the two.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import click

from kogao_core.cli.commands import EPILOG, PROGRAM, program
from kogao_core.cli.words import Group

PAGE: Final = Path(__file__).with_name("command-line.md")
_HEAD: Final = """# The command line

[日本語](ja/command-line.md)

Made by `python docs/command_line.py` from what `kogao-cli COMMAND --help` knows; defaults are in
brackets. The editor's own options are in [editor.md](editor.md).

```sh
kogao-cli warp portrait.jpg -o four.jpg      # 4 %, centre 2, as the paper found most natural
kogao-cli warp portrait.jpg -o six.jpg --percent 6 --center 3 --face largest --save-project
kogao-cli warp big.jpg -o big-small.jpg --project portrait.jpg.kogao.json    # its large original
kogao-cli batch photos/ 'more/*.jpg' -o small/ --jobs 4     # again: goes on where it stopped
kogao-cli detect portrait.jpg --json -       # the 27 landmarks of every face
kogao-cli landmarks export portrait.jpg --format tem -o points/    # for WebMorph
kogao-cli experiment timing portrait.jpg -o report/                # table 2
kogao-cli experiment study make portrait.jpg -o study/             # pictures for people to rate
kogao-cli doctor                             # what is missing, and the command that mends it
kogao-cli --language ja warp --help          # in another language than the system's
```

![The four centre candidates](pictures/figure-centers.jpg)

*`--center 1` to `4`; each landmark's target lies on its line to the centre.*

D is the distance between a landmark and the centre that it moves towards. Above 6 % of it the
paper's raters saw that something had been done. HEIC and raw files are read where their libraries
are installed (`pip install '.[heic,raw]'`); the rivals of `experiment methods` come with
`'.[experiments]'`.

`kogao-cli` never overwrites a file without `--force`. It ends with one of these codes; errors are
one line on stderr, and nothing half-written is left behind.
"""


def text() -> str:
    """Return the page."""
    codes = EPILOG.partition("Exit codes:\n")[2].partition("\n\n")[0]
    parts = [_HEAD, f"```\n{codes}\n```\n"]
    return "\n".join([*parts, *_sections(program, click.Context(program, info_name=PROGRAM))])


def _sections(command: click.Command, context: click.Context) -> Iterator[str]:
    """Yield a section for each command; groups only lead to theirs."""
    if isinstance(command, Group):
        for name, inner in command.every.items():
            yield from _sections(inner, click.Context(inner, context, info_name=name))
        return
    pieces = [piece for piece in command.collect_usage_pieces(context) if piece != "[OPTIONS]"]
    usage = " ".join([context.command_path, *pieces])
    lead = " ".join((command.help or "").partition("\n\n")[0].split())
    options = [param for param in command.params if isinstance(param, click.Option)]
    rows = ["| option | meaning |", "|---|---|", *(_row(option, context) for option in options)]
    table = "\n".join(rows) + "\n" if options else ""
    yield f"## `{usage}`\n\n{lead}\n" + (f"\n{table}" if table else "")


def _row(option: click.Option, context: click.Context) -> str:
    declared, meaning = option.get_help_record(context) or ("", "")
    declared, meaning = (" ".join(cell.replace("|", r"\|").split()) for cell in (declared, meaning))
    return f"| `{declared}` | {meaning} |"


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
