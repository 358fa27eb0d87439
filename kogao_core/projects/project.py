"""Project files: all edits of one photo, without pixels."""

from __future__ import annotations

import dataclasses
import json
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, get_args

from kogao_core import __version__
from kogao_core.additions.brush import UNTOUCHED, Brushwork
from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Affine, Line
from kogao_core.base.json_reader import BadFile, Node, parse, read
from kogao_core.faces.face import Face
from kogao_core.field.protection import NOTHING, Protection
from kogao_core.projects import json as project_json
from kogao_core.recipe.recipe import Recipe

VERSION: Final = 1
LOOK: Final = (1, 1)
"""First version of Kogao whose results look as those of this version."""
Mode = Literal["automatic", "manual"]
_FORMAT: Final = "kogao-project"
_MOST_BYTES: Final = 8 * 2**20
_LONGEST_SIDE_PX: Final = 2**20
_FIELDS: Final = (
    *("format", "version", "program", "photo", "unit_px"),
    *("mode", "automatic", "manual", "protection", "loose", "brushwork"),
)


@dataclass(frozen=True, eq=False)
class Sheet:
    """The faces and settings of one mode."""

    faces: tuple[Face, ...] = ()  # px of the upright photo
    off: frozenset[int] = frozenset()  # indices of the faces that are not changed
    # Settings of the photo, for all faces without settings of their own.
    recipe: Recipe = dataclasses.field(default_factory=Recipe)

    @property
    def active(self) -> list[Face]:
        """The faces to make smaller."""
        return [face for index, face in enumerate(self.faces) if index not in self.off]

    @property
    def inactive(self) -> list[Face]:
        """The faces that are not changed."""
        return [face for index, face in enumerate(self.faces) if index in self.off]

    def mapped(self, transform: Affine) -> Sheet:
        """Return the sheet for the photo resized by a similarity transform."""
        faces = tuple(face.mapped(transform) for face in self.faces)
        return Sheet(faces, self.off, self.recipe.at_scale(transform.scale))


@dataclass(frozen=True, slots=True)
class Original:
    """The photo of a project: path, SHA-256 and upright size, px."""

    path: str
    sha256: str
    width: int
    height: int


@dataclass(frozen=True, eq=False)
class Project:
    """The edits of one photo, as saved in a project file.

    Parameters
    ----------
    original : Original
        File name, hash and size of the photo.
    mode : {"automatic", "manual"}
        The sheet used for the result.
    automatic : Sheet
        Faces found by the program, with corrections.
    manual : Sheet, optional
        Faces marked by hand.
    protection : Protection
        Areas that must not move, px.
    loose : tuple of Line
        Straight lines that may bend, px.
    brushwork : Brushwork
        Push and restore strokes, px.
    program : str
        Version of Kogao that saved the project.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> from kogao_core.projects.project import Original, Sheet, save
    >>> sheet = Sheet((kogao.template_face((450, 480), 400),), recipe=kogao.Recipe(percent=6))
    >>> project = kogao.Project(Original("me.jpg", "0" * 64, 900, 900), "automatic", sheet)
    >>> save(project, "me.jpg.kogao.json")
    >>> kogao.load_project("me.jpg.kogao.json").automatic.recipe == sheet.recipe
    True
    """

    original: Original
    mode: Mode
    automatic: Sheet
    manual: Sheet | None = None
    protection: Protection = NOTHING
    loose: tuple[Line, ...] = ()
    brushwork: Brushwork = UNTOUCHED
    program: str = __version__

    @property
    def looks_different(self) -> bool:
        """Whether the result of an older version may look different from the result now."""
        numbers = tuple(map(int, re.findall(r"\d+", self.program)[:2]))
        return self.program != __version__ and numbers < LOOK

    def at_size(self, width: int, height: int) -> Project:
        """Return the project, with all coordinates scaled, for the photo at another resolution.

        Parameters
        ----------
        width, height : int
            Size of the upright photo, px.

        Raises
        ------
        BadFile
            If the photo has another aspect ratio.
        """
        old = self.original
        if (width, height) == (old.width, old.height):
            return self
        # Resizing rounds each side to whole px.
        if abs(width * old.height - height * old.width) > max(old.width, old.height):
            raise BadFile(
                "the project belongs to a photo of {width} x {height} px; a photo "
                "of {new_width} x {new_height} px has another shape",
                width=old.width,
                height=old.height,
                new_width=width,
                new_height=height,
            )
        resize = Affine.resize(width / old.width, height / old.height)
        return Project(
            dataclasses.replace(old, width=width, height=height),
            self.mode,
            self.automatic.mapped(resize),
            None if self.manual is None else self.manual.mapped(resize),
            self.protection.mapped(resize),
            tuple(project_json.as_line(resize(line)) for line in self.loose),
            self.brushwork.mapped(resize),
            self.program,
        )


def unit_px(width: int, height: int) -> int:
    """Return the unit of coordinates: the smallest power of two that is not below both sides.

    Dividing by a power of two is exact, so a saved project has exactly the same points.
    """
    return 1 << (max(width, height) - 1).bit_length()


def to_dict(project: Project) -> dict[str, Any]:
    """Convert a project to plain JSON values; positions and lengths are in `unit_px`."""
    original = project.original
    unit = unit_px(original.width, original.height)
    manual = project.manual
    return {
        "format": _FORMAT,
        "version": VERSION,
        "program": __version__,
        "photo": dataclasses.asdict(original),
        "unit_px": unit,
        "mode": project.mode,
        "automatic": _sheet_dict(project.automatic, unit),
        "manual": None if manual is None else _sheet_dict(manual, unit),
        "protection": project_json.protection_dict(project.protection, unit),
        "loose": project_json.lines_list(project.loose, unit),
        "brushwork": project_json.brushwork_list(project.brushwork, unit),
    }


def from_node(top: Node) -> Project:
    """Read a project written by `to_dict`. Raises BadFile."""
    if top.field("format").value != _FORMAT:
        raise BadFile("the file is no project of Kogao (PHOTO.kogao.json)")
    version = top.field("version").whole(1, 10**6)
    if version > VERSION:
        raise BadFile(
            "the file has version {version}, from a newer Kogao; this Kogao reads "
            "versions up to {newest}: update Kogao",
            version=version,
            newest=VERSION,
        )
    top.only(_FIELDS)
    photo = top.field("photo").only([field.name for field in dataclasses.fields(Original)])
    width, height = (photo.field(n).whole(1, _LONGEST_SIDE_PX) for n in ("width", "height"))
    original = Original(
        photo.field("path").text(4096), photo.field("sha256").text(64), width, height
    )
    unit = unit_px(width, height)
    top.field("unit_px").whole(unit, unit)
    manual = top.field("manual")
    mode: Mode = "manual" if top.field("mode").text(16, get_args(Mode)) == "manual" else "automatic"
    return Project(
        original,
        mode,
        _sheet(top.field("automatic"), unit),
        None if manual.value is None else _sheet(manual, unit),
        project_json.protection(top.field("protection"), unit, width, height),
        project_json.lines(top.field("loose"), unit),
        project_json.brushwork(top.field("brushwork"), unit),
        top.field("program").text(64) if top.field("program").value else __version__,
    )


def load(path: str | os.PathLike[str]) -> Project:
    """Read a project file.

    Parameters
    ----------
    path : path
        The file, such as ``portrait.jpg.kogao.json``.

    Returns
    -------
    Project
        Apply the project with `apply_project`. The photo is not opened.

    Raises
    ------
    BadFile
        If the file can't be read or isn't a project.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> try:
    ...     kogao.load_project("no-such.kogao.json")
    ... except kogao.BadFile as problem:
    ...     print(problem)
    no-such.kogao.json doesn't exist; check the name and the folder
    """
    if Path(path).exists() and not Path(path).is_file():
        raise BadFile("{path} is not an ordinary file", path=path)  # reading a pipe would block
    return from_node(parse(read(Path(path), _MOST_BYTES), _MOST_BYTES))


def save(project: Project, path: str | os.PathLike[str], *, private: bool = False) -> None:
    """Write a project file atomically. Only the owner can read a private file."""
    atomic_write(to_bytes(project), path, private=private)


def to_bytes(project: Project) -> bytes:
    """Return the content of a project file."""
    text = json.dumps(to_dict(project), ensure_ascii=False, allow_nan=False, indent=1)
    return text.encode("utf-8")


def _sheet_dict(sheet: Sheet, unit: int) -> dict[str, Any]:
    faces = [project_json.face_dict(face, unit) for face in sheet.faces]
    for index, face in enumerate(faces):
        face["on"] = index not in sheet.off
    return {"recipe": sheet.recipe.to_dict(), "faces": faces}


def _sheet(node: Node, unit: int) -> Sheet:
    node.only(("recipe", "faces"))
    nodes = node.field("faces").items(project_json.MOST_FACES)
    faces = project_json.faces(nodes, unit)
    off = frozenset(n for n, face in enumerate(nodes) if not face.field("on").flag())
    return Sheet(faces, off, project_json.recipe(node.field("recipe")))
