"""The complete work on one photo for command line, batch and editor: hold, render and write."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from kogao_core.background.find import BackgroundFinder, held_of
from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import Text
from kogao_core.faces import identity
from kogao_core.faces.doubt import Chosen, choose
from kogao_core.faces.face import Face
from kogao_core.faces.names import People, identify
from kogao_core.photo import Photo, accompanied, write, write_in_place
from kogao_core.photo.disclosure.disclosing import NO_DISCLOSURE, Disclosure, disclose, undisclosed
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
    people: People = ()  # names with Amounts, %: warp only their faces; empty: any face
    landmarks: str | None = None  # name of the landmark source
    max_megapixels: float = 300.0  # refuse larger photos
    disclosure: Disclosure = NO_DISCLOSURE  # edit record and label of the result
    export: Export = AS_IT_IS  # size, quality and colours of the result

    def chosen(self, photo: Photo, faces: Sequence[Face]) -> Chosen:
        """Return the faces of a photo to warp, and the others. Raises ValueError, AllDoubted."""
        which, note = self.which, ""
        if self.people:
            faces, which, note = identify(self.people, photo, faces, self.recipe)
        found = choose(faces, which, Box.of(photo.pixels), doubtful=self.doubtful)
        note = Text.joined("; ", filter(None, (note, found.note)))
        return dataclasses.replace(found, note=note)


def to_file(path: Path, *, force: bool) -> Write:
    """Return a writer for `path`. The caller must create the folder."""
    return lambda photo, pixels, coding: write(photo, pixels, path, force=force, quality=coding)


def over_itself(originals: Originals | None) -> Write:
    """Return a writer that replaces the photo's file; `originals` first stores the original."""
    return lambda photo, pixels, _: write_in_place(photo, pixels, originals)


@dataclass(frozen=True, slots=True)
class Output:
    """Where a result goes, and how."""

    write: Write
    disclosure: Disclosure = NO_DISCLOSURE
    export: Export = AS_IT_IS

    def needs_rendering(self, photo: Photo) -> bool:
        """Return whether pixels of full size aren't enough for this output."""
        return self.export.reduces(photo) or self.takes_companions(photo)

    def takes_companions(self, photo: Photo) -> bool:
        """Return whether pictures inside the photo's file, such as a gain map, are warped too."""
        return self.export.coding is None and any(
            extra.data and extra.kind in JPEG.companions for extra in photo.extras
        )


@dataclass(frozen=True, eq=False)
class Retouched:
    """Result of `retouch`.

    `written`: note on the written file. `notes`: warnings, such as a missing focal length, an edit
    record that an unchanged photo does not get, or the form of an identity document.
    """

    written: str
    notes: tuple[str, ...]


def draw(
    photo: Photo,
    edits: Applied,
    finder: BackgroundFinder,
    export: Export = AS_IT_IS,
    threads: int | None = None,
) -> Rendering:
    """Render the edits of a photo in the size of `export`, and keep the background straight."""
    recipe = optics_of(photo).settled(edits.recipe)
    held = held_of(photo.pixels, dataclasses.replace(edits, recipe=recipe), finder)
    return render(
        photo.pixels, edits.faces, recipe, protection=edits.protection, held=held,
        brushwork=edits.brushwork, threads=threads, longest_px=export.longest_px,
    )  # fmt: skip


def retouch(photo: Photo, edits: Applied, drawn: Rendering | Image, output: Output) -> Retouched:
    """Disclose and write the result of a photo's edits.

    `drawn`: the result of `draw`, or its pixels unless `Output.needs_rendering`. Raises
    CannotWrite, RefusedOutput.
    """
    optics, export, disclosure = optics_of(photo), output.export, output.disclosure
    notes = [optics.note(edits.recipe)]
    edits = dataclasses.replace(edits, recipe=optics.settled(edits.recipe))
    pixels = drawn.pixels if isinstance(drawn, Rendering) else drawn
    if isinstance(drawn, Rendering) and export.reduces(photo):
        is_changed = any(lattice.phi.any() for lattice in drawn.field.lattices)
    else:
        is_changed = not is_same(photo.pixels, pixels)
    left_out = undisclosed(photo, pixels if is_changed else photo.pixels, disclosure)
    told, pixels = export.applied(photo, pixels)
    if is_changed:
        told, pixels = disclose(told, pixels, disclosure, what=edits.what)
    if isinstance(drawn, Rendering) and output.takes_companions(photo):
        told = accompanied(told, drawn.warped, film=disclosure.film)
    written = output.write(told, pixels, export.coding)
    notes += [left_out, identity.note(photo.pixels, edits.faces) if is_changed else ""]
    return Retouched(written, tuple(filter(None, notes)))
