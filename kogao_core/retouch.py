"""One way through the work, for command, batch and editor: hold, render, disclose, sign, write."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from kogao_core.background.find import BackgroundFinder, held_of
from kogao_core.base.geometry import Image
from kogao_core.base.originals import Originals
from kogao_core.photo import Photo, write, write_in_place
from kogao_core.photo.disclosure.disclosing import Disclosure, disclose, signing, undisclosed
from kogao_core.photo.optics import optics_of
from kogao_core.photo.writing import Sign
from kogao_core.pipeline import Rendering, render
from kogao_core.projects.sidecar import Applied

Write = Callable[[Photo, Image, Sign | None], str]
"""Writes a photo's new pixels and returns what is worth knowing of the file."""


def to_file(path: Path, *, force: bool) -> Write:
    """Return what writes a file; its folder is made by whoever calls."""
    return lambda photo, pixels, sign: write(photo, pixels, path, force=force, sign=sign)


def over_itself(originals: Originals | None) -> Write:
    """Return what writes over a photo's own file, which is kept in a store before, if any."""
    return lambda photo, pixels, sign: write_in_place(photo, pixels, originals, sign)


@dataclass(frozen=True, eq=False)
class Retouched:
    """What became of a photo: `written` is what is worth knowing of the file.

    `rendering` is None where the pixels were there already; `undisclosed` says what a result that
    equals the photo doesn't tell, `lens` why the lens' stretch stays that was to go.
    """

    rendering: Rendering | None
    written: str
    undisclosed: str
    lens: str


def retouch(
    photo: Photo,
    done: Applied,
    disclosure: Disclosure,
    to: Write,
    finder: BackgroundFinder,
    *,
    drawn: Image | None = None,
    look: Callable[[Rendering], object] = lambda _: None,
    threads: int | None = None,
) -> Retouched:
    """Do to a photo what is done to it: hold its background, render, disclose, sign and write.

    Raises CannotWrite, RefusedOutput.
    """
    rendering, optics = None, optics_of(photo)
    left = optics.note(done.recipe)
    done = dataclasses.replace(done, recipe=optics.settled(done.recipe))
    if drawn is None:
        held = held_of(photo.pixels, done, finder)
        rendering = render(
            photo.pixels, done.faces, done.recipe, protection=done.protection, held=held,
            threads=threads,
        )  # fmt: skip
        look(rendering)
        drawn = rendering.pixels
    left_out = undisclosed(photo, drawn, disclosure)
    told, pixels = disclose(photo, drawn, disclosure, what=done.what)
    written = to(told, pixels, signing(disclosure, done.what))
    return Retouched(rendering, written, left_out, left)
