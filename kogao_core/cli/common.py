"""What the commands share: exit codes, one-line errors, the input and its faces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path
from typing import Any, Final

import click

from kogao_core.base.atomic import NotAFile, check_target
from kogao_core.base.language import Text
from kogao_core.base.wording import system_reason
from kogao_core.cli import ending, words

# Whether it may be read is found, and said, by whoever reads it.
PHOTO: Final = click.Path(path_type=Path, readable=False)
FILE: Final = click.Path(path_type=Path, dir_okay=False)
FOLDER: Final = click.Path(path_type=Path, file_okay=False)


class Number(click.FloatRange):
    """A finite number within a range; click itself lets NaN through."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read a number; NaN and infinities are none."""
        number: float = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(Text("{value} is not a finite number.", value=value), param, ctx)
        return number


def check_free(file: Path, force: bool) -> None:
    """Stop when a file may not be written: one is there without `force`, or no file can be."""
    try:
        check_target(file)
    except NotAFile as error:
        raise ending.Stop(
            Text(
                "{file} can't be replaced: {reason}; name another file",
                file=file,
                reason=system_reason(error),
            ),
            ending.USAGE,
        ) from None
    if file.exists() and not force:
        raise ending.Stop(Text("{file} exists; --force replaces it", file=file), ending.USAGE)


limits_megapixels = words.option(
    "--max-megapixels",
    type=Number(min=0, min_open=True),
    default=300.0,
    show_default=True,
    help="Refuse larger photos.",
)


forces = words.option("--force", is_flag=True, help="Replace existing files.")


def each(photos: Sequence[Path], work: Callable[[Path], None]) -> int:
    """Work on photos and return the exit code; what stops one of several is told, no more."""
    code = 0
    for photo in photos:
        try:
            work(photo)
        except ending.Stop as stop:
            if len(photos) == 1:
                raise
            ending.print_message(stop.message)
            code = ending.SOME_FAILED
    return code


def count_of_faces(count: int) -> Text:
    """Return ``1 face`` or ``2 faces``."""
    return Text.counted(count, "{n} face", "{n} faces")
