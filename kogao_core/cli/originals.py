"""``kogao-cli originals``: list and export the stored originals of photos changed in place."""

from __future__ import annotations

import shutil
from datetime import UTC, datetime
from pathlib import Path

import click

from kogao_core.base.atomic import put
from kogao_core.base.language import Text, tr
from kogao_core.cli import common, ending, words
from kogao_core.photo.originals import Originals


@words.command("originals")
@click.argument("photo", metavar="[PHOTO]", required=False, type=common.PHOTO)
@words.option(
    "--export", "folder", type=common.FOLDER, metavar="FOLDER",
    help="Copy the listed originals into FOLDER.",
)  # fmt: skip
def command(photo: Path | None, folder: Path | None) -> None:
    """List the stored originals, newest first.

    Columns: number, date, size, file, photo. With PHOTO, list the originals that may belong to
    PHOTO; restore --original takes the number.
    """
    store = Originals.of_user()
    listed = store.all() if photo is None else store.of(photo)
    listed = [one for one in listed if one.file.is_file()]
    total = 0
    for number, one in enumerate(listed, start=1):
        about = one.file.stat()
        when = datetime.fromtimestamp(about.st_mtime, UTC).astimezone()
        total += about.st_size
        ending.print_text(
            f"{number}  {when:%Y-%m-%d %H:%M:%S}  {about.st_size / 1e6:.1f} MB  {one.file}  "
            f"{one.photo or '?'}"
        )
        if folder is not None:
            with ending.writing(folder):
                folder.mkdir(parents=True, exist_ok=True)
                copy = folder / one.file.name
                put(one.file.read_bytes(), copy, like=one.file)
                shutil.copystat(one.file, copy)
    count = Text.counted(len(listed), "{n} original", "{n} originals")
    ending.print_text(
        tr("{count}, {size:.1f} MB of at most {limit:.0f} MB, in {folder}", count=count,
           size=total / 1e6, limit=store.limit_bytes / 1e6, folder=store.folder)
    )  # fmt: skip
