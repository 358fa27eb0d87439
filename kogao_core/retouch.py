"""The complete work on one photo for command line, batch and editor: hold, render and write."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from kogao_core.background.find import BackgroundFinder, held_of
from kogao_core.base.geometry import Image
from kogao_core.faces import identity
from kogao_core.photo import Photo, accompanied, write, write_in_place
from kogao_core.photo.disclosure.disclosing import (
    NO_DISCLOSURE,
    Disclosure,
    disclose,
    undisclosed,
)
from kogao_core.photo.export import AS_IT_IS, Export
from kogao_core.photo.formats.jpeg import JPEG
from kogao_core.photo.model import is_same
from kogao_core.photo.optics import optics_of
from kogao_core.photo.originals import Originals
from kogao_core.pipeline import Rendering, render
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.recipe import Recipe

Write = Callable[[Photo, Image, int | None], str]
"""A function that writes a photo's new pixels, with the coding of an export or None.

It returns a note on the file.
"""


@dataclass(frozen=True, slots=True)
class RetouchJob:
    """What to do with each photo, for command line, batch and editor."""

    recipe: Recipe = field(default_factory=Recipe)
    which: str = "all"  # faces to warp: all, largest, or numbers
    doubtful: bool = False  # also warp doubtful faces
    landmarks: str | None = None  # name of the landmark source
    max_megapixels: float = 300.0  # refuse larger photos
    disclosure: Disclosure = NO_DISCLOSURE  # edit record and label of the result
    export: Export = AS_IT_IS  # size, quality and colours of the result


def to_file(path: Path, *, force: bool) -> Write:
    """Return a writer for `path`. The caller must create the folder."""
    return lambda photo, pixels, coding: write(photo, pixels, path, force=force, quality=coding)


def over_itself(originals: Originals | None) -> Write:
    """Return a writer that replaces the photo's file; `originals` first stores the original."""
    return lambda photo, pixels, _: write_in_place(photo, pixels, originals)


@dataclass(frozen=True, eq=False)
class Retouched:
    """Result of `retouch`. `rendering` is None if the caller passed the pixels.

    `written`: note on the written file. `notes`: warnings, such as a missing focal length, an edit
    record that an unchanged photo does not get, or the form of an identity document.
    """

    rendering: Rendering | None
    written: str
    notes: tuple[str, ...]


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
    export: Export = AS_IT_IS,
) -> Retouched:
    """Apply edits to a photo: keep the background straight, render, disclose and write.

    `drawn` is an existing result of full size; `look` receives a new rendering. `to` writes the
    file with the coding of `export`.

    Raises CannotWrite, RefusedOutput.
    """
    optics, rendering, is_changed = optics_of(photo), None, False
    left = optics.note(done.recipe)
    done = dataclasses.replace(done, recipe=optics.settled(done.recipe))
    goes_along = export.coding is None and any(
        extra.data and extra.kind in JPEG.companions for extra in photo.extras
    )
    if drawn is None or export.reduces(photo) or goes_along:
        held = held_of(photo.pixels, done, finder)
        rendering = render(
            photo.pixels, done.faces, done.recipe, protection=done.protection, held=held,
            brushwork=done.brushwork, threads=threads, longest_px=export.longest_px,
        )  # fmt: skip
        look(rendering)
        drawn = rendering.pixels
        is_changed = any(lattice.phi.any() for lattice in rendering.field.lattices)
    if not export.reduces(photo):
        is_changed = not is_same(photo.pixels, drawn)
    left_out = undisclosed(photo, drawn if is_changed else photo.pixels, disclosure)
    told, pixels = export.applied(photo, drawn)
    if is_changed:
        told, pixels = disclose(told, pixels, disclosure, what=done.what)
    if rendering is not None and goes_along:
        told = accompanied(told, rendering.warped, film=disclosure.film)
    written = to(told, pixels, export.coding)
    form = identity.note(photo.pixels, done.faces) if is_changed else ""
    return Retouched(rendering, written, tuple(filter(None, (left, left_out, form))))
