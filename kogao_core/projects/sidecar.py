"""Apply a project to a photo."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field

from kogao_core.additions.brush import UNTOUCHED, Brushwork
from kogao_core.additions.limits import OutOfBounds, check_brushwork, check_faces, check_protection
from kogao_core.base.geometry import Box, Image, Line, check_image, check_type
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.base.wording import printable
from kogao_core.faces.doubt import is_partial
from kogao_core.faces.face import Face
from kogao_core.field.protection import Protection
from kogao_core.photo.model import Photo
from kogao_core.projects.project import Original, Project, Sheet
from kogao_core.recipe.recipe import Recipe


@dataclass(frozen=True, eq=False)
class Applied:
    """A project applied to one photo: the arguments of `render`."""

    faces: list[Face]  # the faces to make smaller, px of the photo
    recipe: Recipe  # the photo's settings
    protection: Protection  # protected regions, px
    note: str = ""  # a note for the user about the match; empty for the identical file
    loose: tuple[Line, ...] = ()  # straight lines that are not kept straight, px
    # Additional faces of the photo, not changed, px.
    others: list[Face] = field(default_factory=list)
    brushwork: Brushwork = UNTOUCHED  # strokes of push and restore, px

    @property
    def what(self) -> Text:
        """Short summary of the edits, for an edit record."""
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
    """Return the edits of a project for a photo, scaled to the resolution of the photo.

    Parameters
    ----------
    project : Project
        The path stored in the project is not opened.
    pixels : array of shape (H, W) or (H, W, C)
        The photo, upright.
    sha256 : str, optional
        Hash of the picture, see `Photo.picture`. With the hash, the note tells whether the project
        was made from another picture.

    Returns
    -------
    Applied
        Arguments for `render`: faces, recipe, protection, brushwork; and a note for the user.

    Raises
    ------
    BadFile
        If the photo has another aspect ratio, or faces or protected areas are far outside.

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
    check_type(project, Project, "from kogao.load_project")
    check_image(pixels)
    at_hand, note = match(project, pixels, sha256)
    sheet = sheet_of(at_hand)
    return Applied(
        *(sheet.active, sheet.recipe, at_hand.protection, note, at_hand.loose, sheet.inactive),
        at_hand.brushwork,
    )


def match(project: Project, pixels: Image, sha256: str | None = None) -> tuple[Project, str]:
    """Scale a project to the size of a photo. Return the project and a note for the user.

    The note is empty for the identical file. Raises BadFile.
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
    note = _note(project, sha256, width)
    if project.looks_different:
        old = Text(
            "made with {version}: the result may look different now", version=project.program
        )
        note = Text.joined("; ", filter(None, (note, old)))
    return at_hand, note


def sheet_of(project: Project) -> Sheet:
    """Return the sheet of the mode that makes the result."""
    if project.mode == "manual" and project.manual is not None:
        return project.manual
    return project.automatic


def has_partial(project: Project) -> bool:
    """Return whether a face that makes the result is marked only in part."""
    return any(map(is_partial, sheet_of(project).active))


def original(photo: Photo) -> Original:
    """Return the photo's entry for a project in the same folder: the printable file name."""
    return Original(printable(photo.path.name), photo.picture, photo.width, photo.height)


def is_resized(project: Project, photo: Photo) -> bool:
    """Return whether a photo may be another resolution of the picture of a project."""
    made, size = project.original, (photo.width, photo.height)
    if size == (made.width, made.height):
        return False
    with suppress(BadFile):
        return bool(project.at_size(*size))
    return False


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
