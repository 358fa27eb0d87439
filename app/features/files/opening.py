"""Opening a photo, in a worker: the photo, its levels, and what was done to it before."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from kogao_core import assets, sidecar
from kogao_core.photo import Photo, read
from kogao_core.strict import BadFile

from ...ahead import Ahead
from ...document import State
from ...render.colour import pyramid_of
from ...render.pyramid import PicturePyramid
from .project_file import EarlierWork, beside, hash_of, is_project, photo_of, state_of


@dataclass(frozen=True, eq=False)
class Opened:
    """A photo that was read.

    Parameters
    ----------
    photo : Photo
        As it was read.
    pyramid : PicturePyramid
        What is rendered and painted from.
    state : State, optional
        What to go on with, px of the photo; None where it starts afresh.
    work : EarlierWork, optional
        Where the state comes from.
    note : str
        How the photo differs from the one that the work is about, or why that can't be used.
    """

    photo: Photo
    pyramid: PicturePyramid
    state: State | None = None
    work: EarlierWork | None = None
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
    work: EarlierWork | None = None,
    afresh: bool = False,
    ahead: Ahead | None = None,
) -> Opened:
    """Read a photo, with its levels and what to go on with.

    Parameters
    ----------
    path : Path
        The photo, or a project file, which leads to its photo.
    work : EarlierWork, optional
        What to go on with; what the project beside the photo holds when absent.
    afresh : bool
        Leave that project alone.
    ahead : Ahead, optional
        The photo at `path`, if it is being read already; of no use for a project.

    Raises
    ------
    UnreadablePhoto
        If the photo is damaged, missing or none.
    BadFile
        If the project file can't be read; `PhotoNotBeside` if its photo must be asked for.
    """
    if is_project(path):
        work, found = photo_of(path)
        if found is None:
            raise PhotoNotBeside(work, path)
        path, ahead = found, None
    photo = read(path) if ahead is None else ahead.photo.result()
    pyramid = pyramid_of(photo) if ahead is None else ahead.pyramid.result()
    try:
        work = work or (None if afresh else beside(photo))
        if work is None:
            return Opened(photo, pyramid)
        project, note = sidecar.match(work.project, photo.pixels, hash_of(photo))
    except BadFile as problem:
        return Opened(photo, pyramid, note=str(problem))
    return Opened(photo, pyramid, state_of(project), work, note)
