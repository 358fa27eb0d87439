"""``kogao-cli restore``: a photo that was written over in place, as it was before."""

from __future__ import annotations

from pathlib import Path

import click

from kogao_core.cli import common, words
from kogao_core.language import Text, tr
from kogao_core.wording import system_reason


@words.command("restore")
@click.argument("file", metavar="PHOTO", type=click.Path(path_type=Path, readable=False))
@words.option("--force", is_flag=True, help="Bring it back though the file has changed since.")
def command(file: Path, force: bool) -> None:
    """Bring back, byte for byte, a photo that was changed in place.

    The original is the file as it was before Kogao wrote there for the first time.
    """
    from kogao_core.originals import NoOriginal, Originals

    common.check_free(file, force=True)
    with common.stopping(NoOriginal, common.USAGE):
        try:
            there_was = Originals.of_user().restore(file, force=force)
        except OSError as error:
            raise common.Stop(
                Text(
                    "{file} can't be brought back ({reason})",
                    file=file,
                    reason=system_reason(error),
                ),
                common.UNREADABLE,
            ) from error
    if there_was:
        common.print_text(tr("{file} is as it was again", file=file))
    else:
        common.print_text(tr("{file} is as it was", file=file))
