"""Compare an open photo with its file: unchanged, renamed, replaced by another picture, or gone."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.model import Photo, Stamp
from kogao_core.photo.picture import sha256_of
from kogao_core.photo.reading import read

_LEVELS: Final = 3  # folders above a photo in which a renamed photo or folder is found


class Replaced(Exception):
    """The file holds another picture now, or can't be read."""


class Gone(Exception):
    """The file is missing: deleted, moved far away, or on a missing drive."""


def current(photo: Photo) -> Photo:
    """Return the photo with the path and the metadata of today; the same object if unchanged.

    The pixels are kept. Raises Gone, Replaced.
    """
    if photo.stamp is None or photo.is_as_read:
        return photo
    if not photo.path.is_file():
        return dataclasses.replace(photo, path=_found_again(photo))
    try:
        now = read(photo.path, max_megapixels=math.inf)
    except UnreadablePhoto as error:
        raise Replaced from error
    if now.picture != photo.picture:
        raise Replaced
    return dataclasses.replace(now, pixels=photo.pixels, companions=photo.companions)


def _found_again(photo: Photo) -> Path:
    """Return the path of a photo after it or a folder above it was renamed. Raises Gone."""
    for folder in itertools.islice(photo.path.parents, _LEVELS):
        _, *rest = photo.path.relative_to(folder).parts
        with suppress(OSError):
            for entry in folder.iterdir():
                if _is_file_of(entry.joinpath(*rest), photo):
                    return entry.joinpath(*rest)
    raise Gone


def _is_file_of(path: Path, photo: Photo) -> bool:
    with suppress(OSError):
        stamp = Stamp.of(path.stat())
        return stamp == photo.stamp and photo.stamp.file == stamp.file
    return False


def to_save(photo: Photo, path: Path, is_photo: Callable[[Path], bool]) -> Photo | None:
    """Return the photo to save a copy at `path` from, see `current`; None for an original.

    `is_photo`: whether an existing file is another photo that must stay. Raises Replaced.
    """
    with suppress(Gone):  # its pixels are in memory
        photo = current(photo)
    is_taken = path.is_file() and (_is_original(path, photo) or is_photo(path))
    return None if is_taken else photo


def _is_original(path: Path, photo: Photo) -> bool:
    """Return whether a path leads to the file that was read, under any name."""
    with suppress(OSError):
        if path.samefile(photo.path):
            return True
    # A photo that isn't at its path may have been moved to another drive.
    is_away = not photo.is_as_read
    return _is_file_of(path, photo) or (is_away and sha256_of(path) == photo.sha256)
