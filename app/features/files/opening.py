"""Opening a photo in a worker: pixels, pyramid and saved edits."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path, PureWindowsPath

from kogao_core.base import assets
from kogao_core.base.json_reader import BadFile
from kogao_core.photo import Photo, read
from kogao_core.photo.model import Stamp
from kogao_core.projects import sidecar
from kogao_core.projects.edits import (
    SUFFIX,
    TOGETHER,
    Edits,
    Found,
    SavedEdits,
    own_place,
    sidecar_of,
)
from kogao_core.projects.project import Project, load
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
    other: Project | None = None  # the older of two versions of the edits
    foreign: Project | None = None  # edits of another picture that was at this path
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
    photo = read(path) if ahead is None else ahead.photo.result()
    pyramid = None if ahead is None else ahead.pyramid.result()
    if pyramid is None or pyramid.show is not screen_colours(photo).show:
        pyramid = pyramid_of(photo)  # read before the screen's profile was known
    storage.edits.note(photo)
    try:
        with TOGETHER:
            return _with_edits(photo, pyramid, storage, work, afresh)
    except BadFile as problem:
        return Opened(photo, pyramid, note=str(problem))


def _with_edits(
    photo: Photo,
    pyramid: PicturePyramid,
    storage: Storage,
    work: EarlierWork | None,
    afresh: bool,
) -> Opened:
    """Return a photo that was read, with its edits. Raises BadFile."""
    edits, path, other, foreign = storage.edits, photo.path, None, None
    places = [] if afresh else places_of(path, edits)
    if work is not None and work.file not in (None, *places):
        places = []  # a project that was chosen elsewhere replaces no edits unasked
    stamps = stamps_of(places)
    found = Found() if work or afresh else edits.find(path, photo)
    if found.edits is not None:
        work = earlier_work(found.edits, path)
        with suppress(BadFile):
            other = None if found.other is None else load(found.other.file)
    elif found.foreign is not None:
        foreign = load(found.foreign)
        if sidecar.is_resized(foreign, photo):
            work, foreign = EarlierWork(foreign, found.foreign), None
    if work is None:
        origin = storage.results.origin(path)
        return Opened(photo, pyramid, origin=origin, foreign=foreign, stamps=stamps)
    known = edits.name_in(work.project, photo)
    project, note = sidecar.match(work.project, photo.pixels, known)
    steps = None if found.edits is None else history.find(edits, found.edits, project)
    state = state_of(project)
    return Opened(photo, pyramid, state, work, steps, other=other, note=note, stamps=stamps)


def places_of(path: Path, edits: Edits) -> list[Path]:
    """Return the possible files for the edits of a photo; the user's folder is last."""
    return [sidecar_of(path), own_place(path, edits.folder)]


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
    return path.name.lower().endswith(SUFFIX)


def earlier_work(kept: SavedEdits, path: Path) -> EarlierWork:
    """Return saved edits of the photo at a path. Raises BadFile."""
    return EarlierWork(load(kept.file), kept.file, None if kept.photo == path else kept.photo)


def to_keep_beside(state: State, photo: Photo) -> Project:
    """Return the project to save for a photo: it contains the photo's name, but no folder."""
    return project_of(state, sidecar.original(photo))


def photo_of(file: Path) -> tuple[EarlierWork, Path]:
    """Read a project file and find the photo in the same folder, by name.

    A path inside the project is never followed. Raises BadFile.
    """
    if not file.is_file():
        raise BadFile("{path} is not an ordinary file", path=file)
    project = load(file)
    # Any system may have written the name: accept both kinds of slashes.
    names = (file.name[: -len(SUFFIX)], PureWindowsPath(project.original.path).name)
    photos = (file.with_name(name) for name in names if name)
    work, photo = EarlierWork(project, file), next((one for one in photos if one.is_file()), None)
    if photo is None:
        raise PhotoNotBeside(work, file)
    return work, photo
