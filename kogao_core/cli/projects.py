"""Projects on the command line: replayed from a file, and kept beside a photo."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import click

from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.cli import common, ending, words
from kogao_core.faces.face import Face
from kogao_core.photo import Photo
from kogao_core.projects import project, sidecar
from kogao_core.projects.project import load, sha256_of
from kogao_core.projects.sidecar import Applied, apply, sidecar_of
from kogao_core.recipe.settings import SETTINGS

_FROM_PROJECT: Final = (
    *SETTINGS,
    *("which", "doubtful", "recipe_file", "landmarks"),
    *("lines", "width_px", "feather_px", "points", "points_map"),
)


def refuse_choices(context: click.Context) -> None:
    """Stop when choices are given beside a project, which holds all of them."""
    for parameter in context.command.params:
        if parameter.name in _FROM_PROJECT and words.is_given(parameter, context):
            raise ending.Stop(
                Text("--project holds every choice; leave out {option}", option=parameter.opts[0]),
                ending.USAGE,
            )


def applied(file: Path, photo: Photo, sha256: str) -> Applied:
    """Return what the project in a file makes of a photo, or stop."""
    with _usable(file):
        return apply(load(file), photo.pixels, sha256)


def check_free(photo: Path, sample: bool, force: bool) -> None:
    """Stop when no project may be written beside a photo."""
    if sample:
        raise ending.Stop(
            Text("the sample keeps no project; copy it to a folder first"), ending.USAGE
        )
    place = sidecar_of(photo)
    common.check_free(place, force)
    if place.parent.is_dir() and not os.access(place.parent, os.W_OK | os.X_OK):
        raise ending.Stop(
            Text(
                "the folder {folder} isn't writable, so no project can be kept "
                "beside the photo; leave out --save-project or copy the photo",
                folder=place.parent,
            ),
            ending.UNREADABLE,
        )


def save(
    photo: Photo, sha256: str, found: Sequence[Face], done: Applied, file: Path | None
) -> Path:
    """Write what was done beside the photo, or stop."""
    original = sidecar.original(photo.path, sha256, photo.pixels)
    if file is not None:
        with _usable(file):
            kept = project.load(file).at_size(photo.width, photo.height)
        kept = dataclasses.replace(kept, original=original)
    else:
        chosen = {id(face) for face in done.faces}
        off = frozenset(n for n, face in enumerate(found) if id(face) not in chosen)
        sheet = project.Sheet(tuple(found), off, done.recipe)
        kept = project.Project(original, "automatic", sheet, None, done.protection, done.loose)
    place = sidecar.sidecar_of(photo.path)
    with ending.writing(place):
        project.save(kept, place)
    return place


@contextmanager
def _usable(file: Path) -> Iterator[None]:
    try:
        yield
    except BadFile as error:
        raise ending.Stop(
            Text("the project {file} can't be used: {error}", file=file, error=error), ending.USAGE
        ) from error


def hash_of(path: Path) -> str:
    """Return the SHA-256 of a photo's file, or stop."""
    with ending.stopping(OSError, ending.UNREADABLE):
        return sha256_of(path)
