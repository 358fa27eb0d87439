"""``kogao-cli restore``: undo an in-place change of a photo."""

from __future__ import annotations

from pathlib import Path

import click

from kogao_core.base.language import Text, tr
from kogao_core.cli import common, ending, words
from kogao_core.photo.originals import ChangedSince, NoOriginal, Originals


@words.command("restore")
@click.argument("file", metavar="PHOTO", type=common.PHOTO)
@words.option(
    "--original", "number", type=click.IntRange(1), metavar="N",
    help="Bring back number N of the list that kogao-cli originals PHOTO prints.",
)  # fmt: skip
@words.option("--force", is_flag=True, help="Replace the file even if it has changed since")
def command(file: Path, number: int | None, force: bool) -> None:
    """Restore the original of a photo that was changed in place.

    The original is the file as it was before Kogao wrote there for the first time.
    """
    common.check_free(file, force=True)
    try:
        with (
            ending.stopping(NoOriginal, ending.USAGE),
            ending.refusing(
                lambda reason: Text("{file} can't be restored ({reason})", file=file, reason=reason)
            ),
        ):
            is_restored = Originals.of_user().restore(file, number, force=force)
    except ending.Stop as stop:
        if not isinstance(stop.__cause__, ChangedSince):
            raise
        raise ending.Stop(
            Text("{path} has changed since it was written in place; --force restores the original "
                 "all the same", path=file)
        ) from None  # fmt: skip
    ending.print_text(
        tr("{file}: original restored", file=file)
        if is_restored
        else tr("{file}: is the original already", file=file)
    )
