"""Delete what Kogao keeps about a photo in the user's data folder."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from kogao_core.base.installed import data_folder
from kogao_core.base.json_reader import BadFile
from kogao_core.photo.originals import Originals
from kogao_core.projects import project
from kogao_core.projects.edits import FOLDER, Edits
from kogao_core.projects.results import Results


@dataclass(frozen=True, slots=True)
class Forgotten:
    """Counts of what was deleted."""

    originals: int
    edits: int  # files: the project and its undo steps, and what a crash left
    results: int  # lines of the list


def forget(photo: Path, data: Path | None = None) -> Forgotten:
    """Delete the originals, edits and listed results of a photo; files beside the photo stay.

    Raises OSError.
    """
    data = data or data_folder()
    results = Results(data).forget(photo)
    originals = Originals(data / "originals").forget(photo)
    edits = Edits(data / FOLDER).forget(photo)
    recovered = _recovered(photo, data / "recovery")
    for file in recovered:
        file.unlink()
    return Forgotten(originals, len(edits) + len(recovered), results)


def _recovered(photo: Path, folder: Path) -> list[Path]:
    """Return the recovery files about a photo."""
    found = []
    for file in folder.glob("*.json"):
        try:
            about = project.load(file).original.path
        except BadFile:  # the strip's list of photos, or a damaged file
            continue
        if os.path.realpath(about) == os.path.realpath(photo):
            found.append(file)
    return found
