"""A state of the document as a project file, and back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path, PureWindowsPath

from kogao_core import sidecar
from kogao_core.photo import Photo
from kogao_core.photo.model import Stamp
from kogao_core.project import Original, Project, load, sha256_of
from kogao_core.strict import BadFile

from ...document import State


@dataclass(frozen=True, eq=False)
class EarlierWork:
    """What was done to a photo before it was opened.

    Parameters
    ----------
    project : Project
        All of it.
    file : Path, optional
        The project file that it was saved to; None for what was kept aside and never saved.
    """

    project: Project
    file: Path | None = None


def is_project(path: Path) -> bool:
    """Tell by its name whether a file is a project."""
    return path.name.lower().endswith(sidecar.SUFFIX)


def beside(photo: Photo) -> EarlierWork | None:
    """Return what the project beside a photo holds.

    Raises
    ------
    BadFile
        If it can't be read.
    """
    file = sidecar.sidecar_of(photo.path)
    return EarlierWork(load(file), file) if file.is_file() else None


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
    """Return the SHA-256 of a photo's file, as it was found when it was first asked for.

    Raises
    ------
    OSError
        If the file can't be read.
    """
    return _digest(photo.path, photo.stamp)


@lru_cache(maxsize=4)
def _digest(path: Path, stamp: Stamp | None) -> str:  # noqa: ARG001
    # A large photo takes its time: each version of a file is hashed once.
    return sha256_of(path)


def photo_of(file: Path) -> tuple[EarlierWork, Path | None]:
    """Read a project file and find its photo beside it, by name; a path inside is never followed.

    Raises
    ------
    BadFile
        If it isn't a project.
    """
    if not file.is_file():
        raise BadFile(f"{file} is not an ordinary file")
    project = load(file)
    # The name may have been written by any system: both kinds of slashes end a folder.
    names = (file.name[: -len(sidecar.SUFFIX)], PureWindowsPath(project.original.path).name)
    photos = (file.with_name(name) for name in names if name)
    work = EarlierWork(project, file)
    return work, next((photo for photo in photos if photo.is_file()), None)


def project_of(state: State, photo: Photo, sha256: str) -> Project:
    """Return what a file is to hold of a state; points of a face not yet begun are left out."""
    visited = state.mode == "manual" or state.kept is not None
    return Project(
        Original(str(photo.path), sha256, photo.width, photo.height),
        state.mode,
        state.sheet("automatic"),
        state.sheet("manual") if visited else None,
        state.protection,
        state.loose,
    )


def state_of(project: Project) -> State:
    """Return the state that a file describes, px of its photo."""
    here, there = project.automatic, project.manual
    if project.mode == "manual" and there is not None:
        here, there = there, here
    mode = project.mode if there is not None else "automatic"
    return State(
        here.faces,
        here.off,
        here.recipe,
        protection=project.protection,
        loose=project.loose,
        mode=mode,
        kept=there,
    )
