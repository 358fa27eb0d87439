"""Overwrite a photo with the result in the same format, and store the original."""

from __future__ import annotations

import dataclasses
import math
import os
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Final

from kogao_core.base.atomic import Chunks
from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.base.wording import system_reason
from kogao_core.photo import formats
from kogao_core.photo.errors import CannotWrite, RefusedOutput, UnreadablePhoto
from kogao_core.photo.formats import FORMATS, suffix_of
from kogao_core.photo.formats.colour import CONVERTED
from kogao_core.photo.metadata import kinds
from kogao_core.photo.metadata.tiff import LOSSLESS, compression_name
from kogao_core.photo.model import Photo, Stamp, is_same
from kogao_core.photo.originals import Originals, StoreFull
from kogao_core.photo.reading import read
from kogao_core.photo.writing import check_output, write

_UNCOMPRESSED: Final = 1
_PICTURES: Final = (kinds.LAYERS, kinds.CHANNELS, kinds.FURTHER)


def check_in_place(photo: Photo) -> None:
    """Check that a changed photo can be saved in place without losing data.

    Raises RefusedOutput, CannotWrite.
    """
    path, form = photo.path, formats.BY_NAME[photo.format]
    if form.encode is None:
        raise RefusedOutput(
            "{path} is a {format} photo, which can't be written in place; write "
            "the result as .jpg or .tif with -o",
            path=path,
            format=form.title,
        )
    if FORMATS.get(suffix_of(path)) != photo.format:
        raise RefusedOutput(
            "{path} is a {format} photo by its content; name it {stem}{suffix}",
            path=path,
            format=form.title,
            stem=path.stem,
            suffix=form.suffixes[0],
        )
    check_output(path, force=True)
    if not os.access(path, os.W_OK):
        raise CannotWrite(
            "{path} may not be written; change its permissions, or write to another", path=path
        )
    converted = [note for note in photo.notes if note.startswith(CONVERTED)]
    number = photo.tiff_compression
    if number is not None and number not in LOSSLESS:
        name = compression_name(number)
        converted.append(Text("compressed by LZW instead of {compression}", compression=name))
    if number not in (None, _UNCOMPRESSED) and photo.channels == 2:
        converted.append(Text("uncompressed"))
    if form.becomes_colour(photo.pixels):
        converted.append(Text("as RGB instead of grey"))
    more = dict.fromkeys(extra.name for extra in photo.extras if extra.kind in _PICTURES)
    if more and photo.format != "JPEG":
        converted.append(Text("without {names}", names=Text.joined(", ", more)))
    if converted:
        raise RefusedOutput(
            "{path} wouldn't come back as it is, but {other}; write the result "
            "to another file with -o",
            path=path,
            other=converted[0],
        )


def write_in_place(photo: Photo, pixels: Image, originals: Originals | None) -> str:
    """Overwrite the photo's file with new pixels. `write` lists the preserved data.

    A photo may be saved several times: metadata and unchanged blocks come from the stored original.
    Without a store, the original is lost and the photo may be saved only once. Return notes for the
    user in one line. Raises RefusedOutput, CannotWrite.
    """
    check_in_place(photo)
    source = _source(photo, _file_of(photo, originals))
    if source is photo and is_same(photo.pixels, pixels):
        return Text("nothing changed: the file is as it was")
    replaced_a_result, evicted = False, 0

    def keep(pieces: Chunks) -> None:
        nonlocal replaced_a_result, evicted
        if originals is None:
            _file_of(photo, originals)
            return
        replaced_a_result, evicted = _keep_original(photo, originals, pieces, locks)

    with ExitStack() as locks:
        notes = [write(source, pixels, photo.path, force=True, before=keep)]
        if originals is not None:
            with suppress(OSError):  # photo and original are saved already
                originals.note_written(photo.path)
    if evicted:
        notes.append(
            Text.counted(
                evicted,
                "the store of originals is full: the oldest original was deleted",
                "the store of originals is full: the {n} oldest originals were deleted",
            )
        )
    if source is photo and replaced_a_result:
        notes.append(
            Text(
                "this photo was changed in place before, so its pixels are resampled twice; "
                "kogao-cli restore first, and they are once"
            )
        )
    return Text.joined("; ", notes)


def _keep_original(
    photo: Photo, originals: Originals, pieces: Chunks, locks: ExitStack
) -> tuple[bool, int]:
    """Lock the store and store the original of a photo. Raises CannotWrite.

    Return whether the store had an original, and the number of deleted originals.
    """
    try:
        locks.enter_context(originals.locked())
        _file_of(photo, originals)  # another program may have changed the photo meanwhile
        was_kept = originals.find(photo.path) is not None
        return was_kept, originals.keep(photo.path, pieces, _version(photo))
    except StoreFull:
        raise CannotWrite(
            "{folder} holds {limit:.0f} GB of originals and is full; kogao-cli originals "
            "lists them, kogao-cli forget PHOTO deletes one, and --anyway deletes the "
            "oldest",
            folder=originals.folder,
            limit=originals.limit_bytes / 1e9,
        ) from None
    except OSError as error:
        raise CannotWrite(
            "the original of {path} can't be kept in {folder} ({reason}); "
            "make room, or write to another file",
            path=photo.path,
            folder=originals.folder,
            reason=system_reason(error),
        ) from error


def _file_of(photo: Photo, originals: Originals | None) -> Path:
    """Return the file with the metadata and blocks of the pixels that were read.

    Result: the photo's file if unchanged or last written by Kogao, or the stored original if the
    original was read. Raises CannotWrite if another program changed the photo.
    """
    if photo.is_as_read:
        return photo.path
    with suppress(OSError):
        found = None if originals is None else originals.find(photo.path)
        if found is not None and found.version == _version(photo):
            is_original = photo.stamp == Stamp.of(found.file.stat())
            return found.file if is_original else photo.path
    raise CannotWrite(_changed(photo))


def _source(photo: Photo, file: Path) -> Photo:
    """Return the photo with `file` as the source of pixels, metadata and blocks."""
    if file != photo.path:
        return dataclasses.replace(photo, path=file)
    if photo.is_as_read:
        return photo
    try:
        there = read(file, max_megapixels=math.inf)
        return dataclasses.replace(there, companions=photo.companions)
    except UnreadablePhoto as error:
        raise CannotWrite(_changed(photo)) from error


def _changed(photo: Photo) -> Text:
    return Text(
        "{path} has been changed by another program since it was read; open it again",
        path=photo.path,
    )


def _version(photo: Photo) -> str:
    # Two programs that read one version must not overwrite each other's results.
    stamp = photo.stamp
    return "" if stamp is None else f"{stamp.size}-{stamp.changed_ns}-{os.getpid()}"
