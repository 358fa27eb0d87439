"""Opening a photo, in a worker: with its levels, and what a project file says was done to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path, PureWindowsPath

from kogao_core.base import assets
from kogao_core.base.strict import BadFile
from kogao_core.photo import Photo, read
from kogao_core.photo.model import Stamp
from kogao_core.projects import sidecar
from kogao_core.projects.project import Project, load, sha256_of
from kogao_core.projects.results import Provenance

from ...ahead import Ahead
from ...document import State, UndoSteps
from ...render.colour import pyramid_of, screen_colours
from ...render.pictures import PicturePyramid
from ...storage import Storage
from . import history
from .history import project_of, state_of


@dataclass(frozen=True, eq=False)
class Opened:
    """A photo that was read."""

    photo: Photo  # as it was read
    pyramid: PicturePyramid  # what is rendered and painted from
    state: State | None = None  # what to go on with, px of the photo; None where it starts afresh
    work: EarlierWork | None = None  # where the state comes from
    steps: UndoSteps | None = None  # undo steps that led to the state, as far as they are kept
    origin: Provenance | None = None  # where it comes from, of a result of this program
    # How the photo differs from the one that the work is about, or why that can't be used.
    note: str = ""


class PhotoNotBeside(BadFile):
    """The photo of a project isn't where its name says; the user has to tell."""

    def __init__(self, work: EarlierWork, file: Path) -> None:
        super().__init__(f"the photo of {file} isn't beside it; put it there")
        self.work, self.file = work, file


def is_sample(path: Path) -> bool:
    """Tell whether a photo is the one that travels with the program."""
    try:
        return path == assets.sample()
    except assets.AssetMissing:
        return False


def open_photo(
    path: Path,
    storage: Storage,
    work: EarlierWork | None = None,
    afresh: bool = False,
    ahead: Ahead | None = None,
) -> Opened:
    """Read a photo, with its levels and what to go on with. Raises UnreadablePhoto, BadFile."""
    if is_project(path):
        (work, path), ahead = photo_of(path), None
    photo = read(path) if ahead is None else ahead.photo.result()
    pyramid = None if ahead is None else ahead.pyramid.result()
    if pyramid is None or pyramid.show is not screen_colours(photo).show:
        pyramid = pyramid_of(photo)  # what was read ahead knew no screen
    try:
        work = work or (None if afresh else kept_of(photo, storage.edits))
        if work is None:
            return Opened(photo, pyramid, origin=storage.results.origin(path))
        project, note = sidecar.match(work.project, photo.pixels, hash_of(photo))
    except BadFile as problem:
        return Opened(photo, pyramid, note=str(problem))
    state = state_of(project)
    steps = None if work.file is None else history.read(photo, storage.edits, state)
    return Opened(photo, pyramid, state, work, steps, note=note)


@dataclass(frozen=True, eq=False)
class EarlierWork:
    """What was done to a photo before it was opened."""

    project: Project  # all of it
    # The project file that it was saved to; None for what was kept aside and never saved.
    file: Path | None = None


def is_project(path: Path) -> bool:
    """Tell by its name whether a file is a project."""
    return path.name.lower().endswith(sidecar.SUFFIX)


def kept_of(photo: Photo, store: Path) -> EarlierWork | None:
    """Return what was kept of a photo, beside it or in the user's own folder. Raises BadFile."""
    file = sidecar.kept(photo.path, store)
    return None if file is None else EarlierWork(load(file), file)


def to_keep_beside(state: State, photo: Photo) -> Project:
    """Return what a file beside a photo is to hold: it names the photo, and no folder."""
    digest = hash_of(photo)
    named = sidecar.original(photo.path, digest, photo.pixels)
    return replace(project_of(state, photo, digest), original=named)


def hash_of(photo: Photo) -> str:
    """Return the SHA-256 of the file that a photo was read from; empty when it is another now."""
    try:
        digest = digest_of(photo)
        return digest if Stamp.of(photo.path.stat()) == photo.stamp else ""
    except OSError:
        return ""


def digest_of(photo: Photo) -> str:
    """Return the SHA-256 of a photo's file, as it was found when it was first asked for."""
    return _digest(photo.path, photo.stamp)


@lru_cache(maxsize=4)
def _digest(path: Path, stamp: Stamp | None) -> str:  # noqa: ARG001
    # A large photo takes its time: each version of a file is hashed once.
    return sha256_of(path)


def photo_of(file: Path) -> tuple[EarlierWork, Path]:
    """Read a project file and find its photo beside it, by name; a path inside is never followed.

    Raises BadFile.
    """
    if not file.is_file():
        raise BadFile(f"{file} is not an ordinary file")
    project = load(file)
    # The name may have been written by any system: both kinds of slashes end a folder.
    names = (file.name[: -len(sidecar.SUFFIX)], PureWindowsPath(project.original.path).name)
    photos = (file.with_name(name) for name in names if name)
    work, photo = EarlierWork(project, file), next((one for one in photos if one.is_file()), None)
    if photo is None:
        raise PhotoNotBeside(work, file)
    return work, photo
