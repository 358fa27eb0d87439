"""Write a photo over its own file, as a file of the same kind; the original goes into a store."""

from __future__ import annotations

import dataclasses
import math
import os
from contextlib import suppress
from pathlib import Path
from typing import Final

from kogao_core.base.atomic import Pieces
from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.base.originals import Originals
from kogao_core.base.wording import system_reason
from kogao_core.photo import formats
from kogao_core.photo.errors import CannotWrite, RefusedOutput, UnreadablePhoto
from kogao_core.photo.formats import FORMATS
from kogao_core.photo.formats.colour import CONVERTED
from kogao_core.photo.metadata import kinds
from kogao_core.photo.model import Photo, Stamp, is_same
from kogao_core.photo.reading import read
from kogao_core.photo.writing import Sign, check_output, write

_PICTURES: Final = (kinds.LAYERS, kinds.CHANNELS, kinds.FURTHER)


def check_in_place(photo: Photo) -> None:
    """Check that a changed photo can go over its own file without making less of it.

    Raises RefusedOutput, CannotWrite.
    """
    path, form = photo.path, formats.BY_NAME[photo.format]
    if form.encode is None:
        raise RefusedOutput(
            Text(
                "{path} is a {format} photo, which can't be written in place; write "
                "the result as .jpg or .tif with -o",
                path=path,
                format=form.title,
            )
        )
    if FORMATS.get(path.suffix.lower()) != photo.format:
        raise RefusedOutput(
            Text(
                "{path} is a {format} photo by its content; name it {stem}{suffix}",
                path=path,
                format=form.title,
                stem=path.stem,
                suffix=form.suffixes[0],
            )
        )
    check_output(path, force=True)
    if not os.access(path, os.W_OK):
        raise CannotWrite(
            Text(
                "{path} may not be written; change its permissions, or write to another", path=path
            )
        )
    converted = [note for note in photo.notes if note.startswith(CONVERTED)]
    other = [*converted, *filter(None, [form.recoded(photo)])]
    if other:
        raise RefusedOutput(
            Text(
                "{path} wouldn't come back as it is, but {other}; write the result "
                "to another file with -o",
                path=path,
                other=other[0],
            )
        )
    more = [extra.name for extra in photo.extras if extra.kind in _PICTURES]
    if more and photo.format != "JPEG":
        raise RefusedOutput(
            Text(
                "{path} would lose what else it holds ({names}); write the result to "
                "another file with -o",
                path=path,
                names=", ".join(dict.fromkeys(more)),
            )
        )


def write_in_place(
    photo: Photo,
    pixels: Image,
    originals: Originals | None,
    sign: Sign | None = None,
) -> str:
    """Write new pixels over the photo's own file; see `write` for what stays as it was.

    A photo may be written several times: what is kept of its file comes from the original. Without
    a store no original is kept, and it may be written once. Result: what is worth knowing, in one
    line. Raises RefusedOutput, CannotWrite.
    """
    check_in_place(photo)
    source = _source(photo, _file_of(photo, originals))
    if source is photo and is_same(photo.pixels, pixels):
        return Text("nothing changed: the file is as it was")
    replaced_a_result = False

    def keep(pieces: Pieces) -> None:
        nonlocal replaced_a_result
        _file_of(photo, originals)
        if originals is None:
            return
        try:
            replaced_a_result = originals.keep(photo.path, pieces, _known_by(photo))
        except OSError as error:
            raise CannotWrite(
                Text(
                    "the original of {path} can't be kept in {folder} ({reason}); "
                    "make room, or write to another file",
                    path=photo.path,
                    folder=originals.folder,
                    reason=system_reason(error),
                )
            ) from error

    note = write(source, pixels, photo.path, force=True, before=keep, sign=sign)
    with suppress(OSError):  # the photo is written; its original lies there whole
        lost = 0 if originals is None else originals.settle(photo.path)
        if lost:
            gone = Text.counted(
                lost,
                "the store of originals is full: the oldest one that it held has gone for good",
                "the store of originals is full: the {n} oldest ones that it held have gone for "
                "good",
            )
            note = Text.joined("; ", [note, gone])
    if source is photo and replaced_a_result:
        again = Text(
            "this photo was changed in place before, so its pixels are resampled twice; "
            "kogao-cli restore first, and they are once"
        )
        return Text.joined("; ", [note, again])
    return note


def _file_of(photo: Photo, originals: Originals | None) -> Path:
    """Return the file that has the photo's metadata and blocks.

    That is its own, as it was read or as it was written last, or the original where that was read.
    """
    if photo.is_as_read:
        return photo.path
    with suppress(OSError):
        found = None if originals is None else originals.behind(photo.path)
        if found is not None:
            kept, known_by = found
            if photo.stamp == Stamp.of(kept.stat()):
                return kept
            if known_by == _known_by(photo):
                return photo.path
    raise CannotWrite(_changed(photo))


def _source(photo: Photo, file: Path) -> Photo:
    """Return the photo with a file of its metadata and blocks, and the pixels that lie there."""
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


def _known_by(photo: Photo) -> str:
    return "" if photo.stamp is None else f"{photo.stamp.size}-{photo.stamp.changed_ns}"
