"""The project file beside a photo, and a project applied to a photo at hand."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from kogao_core.base.geometry import Box, Image, Line
from kogao_core.base.installed import data_folder
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.base.wording import printable
from kogao_core.faces.face import Face
from kogao_core.projects.project import Original, Project, Sheet
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.brush import UNTOUCHED, Brushwork
from kogao_core.warp.limits import OutOfBounds, check_brushwork, check_faces, check_protection
from kogao_core.warp.protection import Protection

SUFFIX: Final = ".kogao.json"


def sidecar_of(photo: str | os.PathLike[str]) -> Path:
    """Return where the project of a photo lies: ``portrait.jpg.kogao.json`` beside it."""
    path = Path(photo)
    return path.with_name(path.name + SUFFIX)


def own_folder() -> Path:
    """Return the user's own folder of projects that don't lie beside their photos."""
    return data_folder() / "edits"


def own_place(photo: str | os.PathLike[str], folder: Path) -> Path:
    """Return where the project of a photo lies in a folder of the user's own."""
    known = hashlib.sha256(os.fsencode(os.path.realpath(photo))).hexdigest()
    return folder / f"{known[:32]}{SUFFIX}"


def kept(photo: str | os.PathLike[str], folder: Path | None = None) -> Path | None:
    """Return the newest project of a photo, beside it or in the user's own folder, if any."""
    places = [sidecar_of(photo), *([own_place(photo, folder)] if folder else [])]
    there: dict[Path, int] = {}
    for place in places:
        with suppress(OSError):  # a folder that can't be asked holds none
            if place.is_file():
                there[place] = place.stat().st_mtime_ns
    return max(there, key=lambda place: there[place], default=None)


@dataclass(frozen=True, eq=False)
class Applied:
    """What a project makes of one photo: the arguments of `render`."""

    faces: list[Face]  # those to make smaller, px of the photo
    recipe: Recipe  # the photo's choices
    protection: Protection  # places that must not move, px
    note: str = ""  # what the user should know of the match; empty for the very photo
    loose: tuple[Line, ...] = ()  # straight lines that aren't held, px
    # More faces of the photo, which are left alone, px.
    others: list[Face] = field(default_factory=list)
    brushwork: Brushwork = UNTOUCHED  # strokes of push and restore, px

    @property
    def what(self) -> Text:
        """A few words on what is done, for an edit record."""
        faces = Text.counted(
            len(self.faces),
            "{n} face made smaller: {amount}",
            "{n} faces made smaller: {amount}",
            amount=self.recipe.amount,
        )
        if not (strokes := len(self.brushwork.strokes)):
            return faces
        drawn = Text.counted(strokes, "{n} stroke of a brush", "{n} strokes of a brush")
        return Text.joined("; ", (faces, drawn))


def apply(project: Project, pixels: Image, sha256: str | None = None) -> Applied:
    """Return what a project makes of a photo: its own, or the same one at another resolution.

    Parameters
    ----------
    project : Project
        Its path is never opened: the photo at hand is the one to work on.
    pixels : array of shape (H, W) or (H, W, C)
        The photo, upright.
    sha256 : str, optional
        Hash of the photo's file, see `project.sha256_of`; without it, no note says whether this is
        the very file.

    Returns
    -------
    Applied
        What to hand to `render`.

    Raises
    ------
    BadFile
        If the photo has another shape than the project's, or faces or protected places lie far
        outside; one sentence.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> from kogao_core.projects.project import Original, Sheet
    >>> photo = kogao.read(kogao.sample())
    >>> sheet = Sheet((kogao.template_face((450, 480), 400),), recipe=kogao.Recipe(percent=6))
    >>> original = Original("large.jpg", "0" * 64, 1800, 1800)
    >>> done = kogao.apply_project(kogao.Project(original, "automatic", sheet), photo.pixels)
    >>> done.note
    'the project was made at 1800 x 1800 px and has been scaled to this photo'
    >>> rendering = kogao.render(photo.pixels, done.faces, done.recipe, protection=done.protection)
    """
    at_hand, note = match(project, pixels, sha256)
    sheet = sheet_of(at_hand)
    return Applied(
        *(sheet.active, sheet.recipe, at_hand.protection, note, at_hand.loose, sheet.inactive),
        at_hand.brushwork,
    )


def match(project: Project, pixels: Image, sha256: str | None = None) -> tuple[Project, str]:
    """Return a project in px of a photo, and what the user should know of the match.

    Result: the note is empty for the very photo. Raises BadFile.
    """
    height, width = pixels.shape[:2]
    at_hand = project.at_size(width, height)
    image = Box.of(pixels)
    try:
        for sheet in filter(None, (at_hand.automatic, at_hand.manual)):
            check_faces(sheet.faces, image)
        check_protection(at_hand.protection, image)
        check_brushwork(at_hand.brushwork, image)
    except OutOfBounds as error:
        raise BadFile(str(error)) from None
    return at_hand, _note(project, sha256, width)


def sheet_of(project: Project) -> Sheet:
    """Return the sheet of the mode that makes the result."""
    if project.mode == "manual" and project.manual is not None:
        return project.manual
    return project.automatic


def original(path: Path, sha256: str, pixels: Image) -> Original:
    """Return how a project beside a photo names it: by its file name alone, in plain letters."""
    name = printable(path.name)
    height, width = pixels.shape[:2]
    return Original(name, sha256, width, height)


def _note(project: Project, sha256: str | None, width: int) -> str:
    made = project.original
    if sha256 == made.sha256 or (sha256 is None and made.width == width):
        return ""
    if made.width == width:
        return Text("the project was made from another file of the same size; check the result")
    return Text(
        "the project was made at {width} x {height} px and has been scaled to this photo",
        width=made.width,
        height=made.height,
    )
