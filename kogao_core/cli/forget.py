"""``kogao-cli forget``: delete originals, edits and results that Kogao stores about a photo."""

from __future__ import annotations

from pathlib import Path

import click

from kogao_core.base.language import Text, tr
from kogao_core.cli import common, ending, words
from kogao_core.projects.forgetting import forget


@words.command("forget")
@click.argument("photos", metavar="PHOTO...", nargs=-1, required=True, type=common.PHOTO)
def command(photos: tuple[Path, ...]) -> None:
    """Delete everything Kogao stores about a photo.

    Deleted: original, stored edits, list of results. PHOTO may be missing, or a file of the store
    of originals. Files next to the photo stay.
    """
    for photo in photos:
        with ending.writing(photo):
            gone = forget(photo)
        ending.print_text(
            tr("{photo}: deleted {originals}, {edits}, {results}", photo=photo,
               originals=Text.counted(gone.originals, "{n} original", "{n} originals"),
               edits=Text.counted(gone.edits, "{n} file of edits", "{n} files of edits"),
               results=Text.counted(gone.results, "{n} listed result", "{n} listed results"))
        )  # fmt: skip
