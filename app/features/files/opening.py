"""Opening a photo in a worker: pixels, pyramid and saved edits."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path, PureWindowsPath

from kogao_core.base import assets
from kogao_core.base.json_reader import BadFile
from kogao_core.photo import Photo, read
from kogao_core.photo.model import Stamp
from kogao_core.projects import sidecar
from kogao_core.projects.project import Project, load, sha256_of
from kogao_core.projects.results import Provenance

from ...ahead import Ahead
from ...document import State, UndoSteps
from ...pyramid import PicturePyramid
from ...render.colour import pyramid_of, screen_colours
from ...storage import Storage
from . import history
from .history import project_of, state_of

Stamps = dict[Path, Stamp | None]


@dataclass(frozen=True, eq=False)
class Opened:
    """An opened photo with saved edits."""

    photo: Photo  # photo as read
    pyramid: PicturePyramid  # pyramid for rendering and painting
    state: State | None = None  # saved state, px of the photo; None without edits
    work: EarlierWork | None = None  # source of the state
    steps: UndoSteps | None = None  # undo steps that led to the state, if stored
    origin: Provenance | None = None  # provenance, for a result of this program
    # Difference between this photo and the edited photo, or the reason for ignoring the edits.
    note: str = ""
    # Stamps of the files for the photo's edits, when the edits were read; empty if ignored.
    stamps: Stamps = field(default_factory=dict)


class PhotoNotBeside(BadFile):
    """The photo of a project is missing; the user must select the photo."""

    def __init__(self, work: EarlierWork, file: Path) -> None:
        super().__init__(f"the photo of {file} isn't beside it; put it there")
        self.work, self.file = work, file


def is_sample(path: Path) -> bool:
    """Return whether a photo is the sample of the program."""
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
    """Read a photo with pyramid and saved edits. Raises UnreadablePhoto, BadFile."""
    if is_project(path):
        (work, path), ahead = photo_of(path), None
    places = [] if afresh else [sidecar.sidecar_of(path), sidecar.own_place(path, storage.edits)]
    photo = read(path) if ahead is None else ahead.photo.result()
    pyramid = None if ahead is None else ahead.pyramid.result()
    if pyramid is None or pyramid.show is not screen_colours(photo).show:
        pyramid = pyramid_of(photo)  # read before the screen's profile was known
    with history.TOGETHER:
        try:
            stamps = stamps_of(places)
            work = work or (None if afresh else kept_of(photo, storage.edits))
            if work is None:
                origin = storage.results.origin(path)
                return Opened(photo, pyramid, origin=origin, stamps=stamps)
            project, note = sidecar.match(work.project, photo.pixels, hash_of(photo))
        except BadFile as problem:
            return Opened(photo, pyramid, note=str(problem))
        state, size_px = state_of(project), (photo.width, photo.height)
        known_as = work.moved_from or photo.path
        steps = None if work.file is None else history.read(known_as, size_px, storage.edits, state)
    return Opened(photo, pyramid, state, work, steps, note=note, stamps=stamps)


def stamps_of(files: Iterable[Path]) -> Stamps:
    """Return the stamp of each file; None for a missing file."""
    return {file: stamp_of(file) for file in files}


def stamp_of(file: Path) -> Stamp | None:
    """Return the stamp of a file; None for a missing file."""
    try:
        return Stamp.of(file.stat())
    except OSError:
        return None


@dataclass(frozen=True, eq=False)
class EarlierWork:
    """Edits from before the photo was opened."""

    project: Project  # all of it
    # The project file; None for work from a recovery file.
    file: Path | None = None
    # The photo's former path, if the edits were found by the photo's content.
    moved_from: Path | None = None


def is_project(path: Path) -> bool:
    """Return whether a file name is that of a project."""
    return path.name.lower().endswith(sidecar.SUFFIX)


def kept_of(photo: Photo, store: Path) -> EarlierWork | None:
    """Return the saved edits of a photo, see `sidecar.find`. Raises BadFile."""
    kept = sidecar.find(photo.path, store)
    if kept is None:
        return None
    moved_from = None if kept.photo == photo.path else kept.photo
    return EarlierWork(load(kept.file), kept.file, moved_from)


def to_keep_beside(state: State, photo: Photo) -> Project:
    """Return the project to save for a photo: it contains the photo's name, but no folder."""
    return project_of(state, sidecar.original(photo.path, hash_of(photo), photo.pixels))


def hash_of(photo: Photo) -> str:
    """Return the SHA-256 of a photo's file; empty if the file has changed since."""
    try:
        digest = digest_of(photo)
        return digest if Stamp.of(photo.path.stat()) == photo.stamp else ""
    except OSError:
        return ""


def digest_of(photo: Photo) -> str:
    """Return the SHA-256 of a photo's file, cached per version of the file."""
    return _digest(photo.path, photo.stamp)


@lru_cache(maxsize=4)
def _digest(path: Path, stamp: Stamp | None) -> str:  # noqa: ARG001
    # Hashing a large photo is slow: hash each version of a file once.
    return sha256_of(path)


def photo_of(file: Path) -> tuple[EarlierWork, Path]:
    """Read a project file and find the photo in the same folder, by name.

    A path inside the project is never followed. Raises BadFile.
    """
    if not file.is_file():
        raise BadFile(f"{file} is not an ordinary file")
    project = load(file)
    # Any system may have written the name: accept both kinds of slashes.
    names = (file.name[: -len(sidecar.SUFFIX)], PureWindowsPath(project.original.path).name)
    photos = (file.with_name(name) for name in names if name)
    work, photo = EarlierWork(project, file), next((one for one in photos if one.is_file()), None)
    if photo is None:
        raise PhotoNotBeside(work, file)
    return work, photo
