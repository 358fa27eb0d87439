"""``kogao-cli restore``: a photo that was written over in place, as it was before."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import click

from kogao_core.base.language import Text, tr
from kogao_core.base.originals import ChangedSince, NoOriginal, Originals
from kogao_core.cli import common, ending, words


@words.command("restore")
@click.argument("file", metavar="PHOTO", type=click.Path(path_type=Path, readable=False))
@words.option(
    "--list", "only_list", is_flag=True, excludes=("--original", "--force"),
    help="List what is kept of it, the newest first: there are several where another program has "
    "changed it between two times.",
)  # fmt: skip
@words.option(
    "--original", "number", type=click.IntRange(1), metavar="N",
    help="Bring back this one of the list [the one that it was made of].",
)  # fmt: skip
@words.option("--force", is_flag=True, help="Bring it back though the file has changed since.")
def command(file: Path, only_list: bool, number: int | None, force: bool) -> None:
    """Bring back, byte for byte, a photo that was changed in place.

    The original is the file as it was before Kogao wrote there for the first time.
    """
    common.check_free(file, force=True)
    store = Originals.of_user()
    with (
        ending.stopping(NoOriginal, ending.USAGE),
        ending.refusing(
            lambda reason: Text("{file} can't be brought back ({reason})", file=file, reason=reason)
        ),
    ):
        said = _listed(store, file) if only_list else _restored(store, file, number, force)
    ending.print_text(said)


def _listed(store: Originals, file: Path) -> str:
    lines = []
    for number, kept in enumerate(store.kept(file), start=1):
        about = kept.stat()
        when = datetime.fromtimestamp(about.st_mtime, UTC).astimezone()
        lines.append(f"{number}  {when:%Y-%m-%d %H:%M:%S}  {about.st_size / 1e6:.1f} MB  {kept}")
    return "\n".join(lines)


def _restored(store: Originals, file: Path, number: int | None, force: bool) -> str:
    try:
        there_was = store.restore(file, number, force=force)
    except ChangedSince:
        raise ending.Stop(
            Text(
                "{path} has changed since it was written in place; --force "
                "brings the original back all the same",
                path=file,
            )
        ) from None
    if there_was:
        return tr("{file} is as it was again", file=file)
    return tr("{file} is as it was", file=file)
