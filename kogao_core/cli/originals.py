"""``kogao-cli originals``, ``restore`` and ``forget``: the store of photos changed in place."""

from __future__ import annotations

import shutil
from datetime import UTC, datetime
from pathlib import Path

import click

from kogao_core.base.atomic import atomic_write
from kogao_core.base.language import Text, tr
from kogao_core.cli import common, ending, words
from kogao_core.photo.originals import NoOriginal, Originals
from kogao_core.projects import forgetting


@words.command("originals")
@click.argument("photo", metavar="[PHOTO]", required=False, type=common.PHOTO)
@words.option(
    "--export", "folder", type=common.FOLDER, metavar="FOLDER",
    help="Copy the listed originals into FOLDER.",
)  # fmt: skip
def originals(photo: Path | None, folder: Path | None) -> None:
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
                atomic_write(one.file.read_bytes(), copy, like=one.file)
                shutil.copystat(one.file, copy)
    count = Text.counted(len(listed), "{n} original", "{n} originals")
    ending.print_text(
        tr("{count}, {size:.1f} MB of at most {limit:.0f} MB, in {folder}", count=count,
           size=total / 1e6, limit=store.limit_bytes / 1e6, folder=store.folder)
    )  # fmt: skip


@words.command("restore")
@click.argument("file", metavar="PHOTO", type=common.PHOTO)
@words.option(
    "--original", "number", type=click.IntRange(1), metavar="N",
    help="Bring back number N of the list that kogao-cli originals PHOTO prints.",
)  # fmt: skip
@words.option("--force", is_flag=True, help="Replace the file even if it has changed since")
def restore(file: Path, number: int | None, force: bool) -> None:
    """Restore the original of a photo that was changed in place.

    The original is the file as it was before Kogao wrote there for the first time.
    """
    common.check_free(file, force=True)
    with (
        ending.stopping(NoOriginal, ending.USAGE),
        ending.refusing(
            lambda reason: Text("{file} can't be restored ({reason})", file=file, reason=reason)
        ),
    ):
        is_restored = Originals.of_user().restore(file, number, force=force)
    ending.print_text(
        tr("{file}: original restored", file=file)
        if is_restored
        else tr("{file}: is the original already", file=file)
    )


@words.command("forget")
@click.argument("photos", metavar="PHOTO...", nargs=-1, required=True, type=common.PHOTO)
def forget(photos: tuple[Path, ...]) -> None:
    """Delete everything Kogao stores about a photo.

    Deleted: original, stored edits, list of results. PHOTO may be missing, or a file of the store
    of originals. Files next to the photo stay.
    """
    for photo in photos:
        with ending.writing(photo):
            gone = forgetting.forget(photo)
        ending.print_text(
            tr("{photo}: deleted {originals}, {edits}, {results}", photo=photo,
               originals=Text.counted(gone.originals, "{n} original", "{n} originals"),
               edits=Text.counted(gone.edits, "{n} file of edits", "{n} files of edits"),
               results=Text.counted(gone.results, "{n} listed result", "{n} listed results"))
        )  # fmt: skip
