"""Find the project file of a photo, and apply a project to a photo."""

from __future__ import annotations

import hashlib
import json
import os
import time
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Final, NamedTuple

from kogao_core.additions.brush import UNTOUCHED, Brushwork
from kogao_core.additions.limits import OutOfBounds, check_brushwork, check_faces, check_protection
from kogao_core.base import json_reader
from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Box, Image, Line, check_image, check_type
from kogao_core.base.installed import data_folder
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.base.wording import printable
from kogao_core.faces.face import Face
from kogao_core.field.protection import Protection
from kogao_core.projects.project import Original, Project, Sheet, load, sha256_of
from kogao_core.recipe.recipe import Recipe

SUFFIX: Final = ".kogao.json"
_RECORD: Final = ".place"  # suffix of a file that records where the edits of a photo are
_MOST_RECORD_BYTES: Final = 1 << 14
_SETTLED_NS: Final = 3_000_000_000  # more than the coarsest time stamps of file systems (2 s)


class SavedEdits(NamedTuple):
    """Edits on disk: the project file and the photo for which they were saved."""

    file: Path
    photo: Path


def sidecar_of(photo: str | os.PathLike[str]) -> Path:
    """Return the path of a photo's project: ``portrait.jpg.kogao.json`` in the same folder."""
    path = Path(photo)
    return path.with_name(path.name + SUFFIX)


def own_folder() -> Path:
    """Return the user's folder for projects that can't be saved next to their photos."""
    return data_folder() / "edits"


def own_place(photo: str | os.PathLike[str], folder: Path) -> Path:
    """Return the path of a photo's project in the user's folder."""
    known = hashlib.sha256(os.fsencode(os.path.realpath(photo))).hexdigest()
    return folder / f"{known[:32]}{SUFFIX}"


def kept(photo: str | os.PathLike[str], folder: Path | None = None) -> Path | None:
    """Return the newest project file of a photo, see `find`."""
    found = find(photo, folder)
    return None if found is None else found.file


def find(photo: str | os.PathLike[str], folder: Path | None = None) -> SavedEdits | None:
    """Return the newest edits of a photo, next to the photo or in the user's folder, if any.

    A photo without edits may have been renamed or moved: then return edits of a photo with the
    same SHA-256 that no longer exists under the name for which the edits were saved.
    """
    path = Path(photo)
    places = [sidecar_of(path), *([own_place(path, folder)] if folder else [])]
    there: dict[Path, int] = {}
    for place in places:
        with suppress(OSError):  # an unreadable folder contains no edits
            if place.is_file():
                there[place] = place.stat().st_mtime_ns
    if there:
        return SavedEdits(max(there, key=lambda place: there[place]), path)
    with suppress(OSError):
        return _of_same_content(path, folder)
    return None


def record(photo: Path, sha256: str, file: Path, folder: Path) -> None:
    """Record in the user's folder where the edits of a photo are. Raises OSError.

    `find` reads the record after the photo has been renamed or moved.
    """
    paths = {"photo": os.path.realpath(photo), "file": os.path.realpath(file)}
    atomic_write(
        json.dumps(paths).encode(), _record_of(folder, photo.stat().st_size, sha256), private=True
    )


def _record_of(folder: Path, size: int, sha256: str) -> Path:
    return folder / f"{size}-{sha256[:32]}{_RECORD}"


def _of_same_content(photo: Path, folder: Path | None) -> SavedEdits | None:
    """Return the newest edits of a photo with the same bytes under another name. Raises OSError."""
    found, beside = photo.stat(), photo.parent
    renamed = _without_photo(beside)
    # Hash the photo only if a record has the same file size.
    recorded = folder is not None and any(folder.glob(f"{found.st_size}-*{_RECORD}"))
    if not renamed and not recorded:
        return None
    digest = _digest(photo, found.st_size, found.st_mtime_ns)
    edits = []
    if folder is not None and recorded:
        with suppress(BadFile, OSError):
            edits.append(_read_record(_record_of(folder, found.st_size, digest)))
    if digest in renamed:
        edits.append(
            SavedEdits(renamed[digest], renamed[digest].with_name(_photo_name(renamed[digest])))
        )
    edits = [one for one in edits if one.file.is_file() and not one.photo.exists()]
    # The record comes first: it wins if two files have the same time.
    return max(edits, key=lambda one: one.file.stat().st_mtime_ns, default=None)


def _read_record(file: Path) -> SavedEdits:
    top = json_reader.parse(json_reader.read(file, _MOST_RECORD_BYTES), _MOST_RECORD_BYTES)
    return SavedEdits(*(Path(top.field(name).text(4096)) for name in ("file", "photo")))


def _photo_name(file: Path) -> str:
    return file.name[: -len(SUFFIX)]


def _without_photo(folder: Path) -> dict[str, Path]:
    """Return the sidecars in a folder whose photo is missing, by the photo's SHA-256."""
    changed_ns = folder.stat().st_mtime_ns
    # The next change of a recently changed folder may leave the folder's time as it is.
    settled = time.time_ns() - changed_ns > _SETTLED_NS
    return (_scan if settled else _scan.__wrapped__)(folder, changed_ns)


@lru_cache(maxsize=64)
def _scan(folder: Path, _: int) -> dict[str, Path]:
    found = {}
    # A photo renamed twice has two sidecars: the newer sidecar replaces the older one.
    for file in sorted(folder.glob(f"*{SUFFIX}"), key=os.path.getmtime):
        if not file.with_name(_photo_name(file)).exists():
            with suppress(BadFile):
                found[load(file).original.sha256] = file
    return found


@lru_cache(maxsize=4096)
def _digest(photo: Path, size: int, modified_ns: int) -> str:  # noqa: ARG001
    return sha256_of(photo)


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
        Hash of the photo's file, see `project.sha256_of`. With the hash, the note tells whether the
        file has changed.

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
    return at_hand, _note(project, sha256, width)


def sheet_of(project: Project) -> Sheet:
    """Return the sheet of the mode that makes the result."""
    if project.mode == "manual" and project.manual is not None:
        return project.manual
    return project.automatic


def original(path: Path, sha256: str, pixels: Image) -> Original:
    """Return the photo's entry for a project in the same folder: the printable file name."""
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
