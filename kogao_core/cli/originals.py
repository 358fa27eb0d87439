"""``kogao-cli originals``, ``restore`` and ``forget``: the store of photos changed in place."""

from __future__ import annotations

from types import SimpleNamespace

from kogao_core.base.installed import data_folder
from kogao_core.base.language import Text, tr
from kogao_core.base.wording import local_time
from kogao_core.cli import common, ending
from kogao_core.photo.originals import NoOriginal, Originals
from kogao_core.projects import forgetting


def originals(args: SimpleNamespace) -> None:
    """List the stored originals."""
    store = Originals.of_user()
    listed = store.all() if args.photo is None else store.of(args.photo)
    listed = [one for one in listed if one.file.is_file()]
    total = 0
    for number, one in enumerate(listed, start=1):
        about = one.file.stat()
        when = local_time(about.st_mtime_ns)
        total += about.st_size
        ending.print_text(
            f"{number}  {when:%Y-%m-%d %H:%M:%S}  {about.st_size / 1e6:.1f} MB  {one.file}  "
            f"{one.photo or '?'}"
        )
    count = Text.counted(len(listed), "{n} original", "{n} originals")
    ending.print_text(
        tr("{count}, {size:.1f} MB of at most {limit:.0f} MB, in {folder}", count=count,
           size=total / 1e6, limit=store.limit_bytes / 1e6, folder=store.folder)
    )  # fmt: skip


def restore(args: SimpleNamespace) -> None:
    """Restore an original."""
    file = args.file
    common.check_free(file, force=True)
    with (
        ending.stopping(NoOriginal, ending.USAGE),
        ending.refusing("{file} can't be restored ({reason})", file=file),
    ):
        is_restored = Originals.of_user().restore(file, args.number, force=args.force)
    ending.print_text(
        tr("{file}: original restored", file=file)
        if is_restored
        else tr("{file} is already the original", file=file)
    )


def forget(args: SimpleNamespace) -> None:
    """List or delete what is kept."""
    photos = args.photos
    if not photos:
        found = forgetting.kept()
        for one in found:
            when = local_time(one.newest_ns)
            ending.print_text(
                f"{when:%Y-%m-%d %H:%M}  {one.size / 1e3:10.1f} kB  {one.photo}  "
                + Text.joined(", ", list(one.what))
            )
        count = Text.counted(len(found), "{n} photo", "{n} photos")
        ending.print_text(tr("{count}, kept in {folder}", count=count, folder=data_folder()))
        photos = [one.photo for one in found] if args.everything else []
    with ending.writing(data_folder()):
        every = forgetting.forget(photos) if photos else []
    for photo, gone in zip(photos, every, strict=True):
        ending.print_text(
            tr("{photo}: deleted {originals}, {edits}, {results}", photo=photo,
               originals=Text.counted(gone.originals, "{n} original", "{n} originals"),
               edits=Text.counted(gone.edits, "{n} file of edits", "{n} files of edits"),
               results=Text.counted(gone.results, "{n} listed result", "{n} listed results"))
        )  # fmt: skip
