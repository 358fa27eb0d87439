"""A state of the document as a project file, and back."""

from __future__ import annotations

from kogao_core.photo import Photo
from kogao_core.project import Original, Project

from .document import State


def project_of(state: State, photo: Photo, sha256: str) -> Project:
    """Return what a file is to hold of a state; points of a face not yet begun are left out."""
    visited = state.mode == "manual" or state.kept is not None
    return Project(
        Original(str(photo.path), sha256, photo.width, photo.height),
        state.mode,
        state.sheet("automatic"),
        state.sheet("manual") if visited else None,
        state.protection,
    )


def state_of(project: Project) -> State:
    """Return the state that a file describes, px of its photo."""
    here, there = project.automatic, project.manual
    if project.mode == "manual" and there is not None:
        here, there = there, here
    mode = project.mode if there is not None else "automatic"
    return State(
        here.faces, here.off, here.recipe, protection=project.protection, mode=mode, kept=there
    )
