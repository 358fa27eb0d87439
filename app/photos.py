"""What workers do with photos: open them with their work, look for faces, save copies."""

from __future__ import annotations

import time
from pathlib import Path

from kogao_core import assets
from kogao_core.display import rgb8
from kogao_core.face import Face, LandmarkSource
from kogao_core.photo import Photo, read, write
from kogao_core.photo.disclosure import Disclosure, disclose, undisclosed
from kogao_core.pipeline import render
from kogao_core.sidecar import Applied
from kogao_core.strict import BadFile

from .colour import way_of
from .document import State
from .i18n import sentence
from .projects import Work, beside, matched
from .pyramid import Pyramid


def is_sample(path: Path) -> bool:
    """Tell whether a photo is the one that travels with the program."""
    try:
        return path == assets.sample()
    except assets.AssetMissing:
        return False


def opened(
    path: Path, work: Work | None, afresh: bool
) -> tuple[Photo, Pyramid, Work | BadFile | None]:
    """Read a photo, with its levels and what to go on with, or why that can't be used.

    Parameters
    ----------
    path : Path
        The photo.
    work : Work, optional
        What to go on with; what the project beside the photo holds when absent.
    afresh : bool
        Leave that project alone.

    Raises
    ------
    UnreadablePhoto
        If it is damaged, missing or none.
    """
    photo = read(path)
    pyramid = Pyramid(rgb8(photo.pixels), way_of(photo).show)
    try:
        if work is not None:
            return photo, pyramid, matched(work, photo)
        return photo, pyramid, None if afresh else beside(photo)
    except BadFile as problem:
        return photo, pyramid, problem


def found(source: LandmarkSource, photo: Photo) -> tuple[list[Face], float]:
    """Look for faces; return them and how long that took, s."""
    start = time.perf_counter()
    return source.find(photo.pixels), time.perf_counter() - start


def saved(photo: Photo, state: State, told: Disclosure, path: Path) -> str:
    """Write a copy and return what is worth knowing of it, in sentences."""
    done = Applied(state.active, state.recipe, state.protection)
    rendering = render(photo.pixels, done.faces, done.recipe, protection=done.protection)
    left_out = undisclosed(photo, rendering.pixels, told)
    copy, pixels = disclose(photo, rendering.pixels, told, what=done.what)
    # The dialog has asked before replacing a file.
    said = write(copy, pixels, path, force=True)
    return " ".join(sentence(note) for note in (said, left_out) if note)
