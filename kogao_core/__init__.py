"""Kogao: automatic small-face warping by fast B-spline approximation (Seo, Chen and Aoki, 2011).

`__all__` lists the public names: read a photo, find faces, render, write. A module is loaded with
the first use of its name.

Examples
--------
>>> import kogao_core as kogao
>>> photo = kogao.read(kogao.sample())
>>> faces = kogao.find(photo.pixels)
>>> rendering = kogao.render(photo.pixels, faces, kogao.Recipe(percent=6))
>>> note = kogao.write(photo, rendering.pixels, "small.png")
"""

from __future__ import annotations

from importlib import import_module as _import_module

TYPE_CHECKING = False  # importing `typing` would take most of the time of this import
if TYPE_CHECKING:
    from kogao_core.additions.brush import Brushwork as Brushwork
    from kogao_core.base.assets import sample as sample
    from kogao_core.base.json_reader import BadFile as BadFile
    from kogao_core.faces.face import Face as Face
    from kogao_core.faces.landmarks.sources import find as find
    from kogao_core.faces.landmarks.sources import source as source
    from kogao_core.faces.landmarks.sources import template_face as template_face
    from kogao_core.field.field import Field as Field
    from kogao_core.field.field import shown_at as shown_at
    from kogao_core.field.measures import FaceMeasures as FaceMeasures
    from kogao_core.field.measures import measures as measures
    from kogao_core.field.protection import Protection as Protection
    from kogao_core.photo.errors import CannotWrite as CannotWrite
    from kogao_core.photo.errors import UnreadablePhoto as UnreadablePhoto
    from kogao_core.photo.formats.companions import accompanied as accompanied
    from kogao_core.photo.model import Photo as Photo
    from kogao_core.photo.reading import read as read
    from kogao_core.photo.writing import write as write
    from kogao_core.pipeline import Rendering as Rendering
    from kogao_core.pipeline import render as render
    from kogao_core.projects import evidence, project, sidecar
    from kogao_core.projects.evidence import Evidence as Evidence
    from kogao_core.projects.project import Project as Project
    from kogao_core.recipe.recipe import PAPER as PAPER
    from kogao_core.recipe.recipe import Recipe as Recipe

    load_evidence, load_project, apply_project = evidence.load, project.load, sidecar.apply

__version__ = "1.0.0"
# Module of each public name, and the name in that module. The imports above are for type checkers;
# a test compares both.
_HOMES = {
    "base.assets": {"sample": "sample"},
    "faces.face": {"Face": "Face"},
    "faces.landmarks.sources": {
        "find": "find",
        "source": "source",
        "template_face": "template_face",
    },
    "photo.formats.companions": {"accompanied": "accompanied"},
    "photo.errors": {"CannotWrite": "CannotWrite", "UnreadablePhoto": "UnreadablePhoto"},
    "photo.model": {"Photo": "Photo"},
    "photo.reading": {"read": "read"},
    "photo.writing": {"write": "write"},
    "pipeline": {"Rendering": "Rendering", "render": "render"},
    "projects.evidence": {"Evidence": "Evidence", "load_evidence": "load"},
    "projects.project": {"Project": "Project", "load_project": "load"},
    "additions.brush": {"Brushwork": "Brushwork"},
    "field.field": {"Field": "Field", "shown_at": "shown_at"},
    "field.measures": {"FaceMeasures": "FaceMeasures", "measures": "measures"},
    "field.protection": {"Protection": "Protection"},
    "recipe.recipe": {"PAPER": "PAPER", "Recipe": "Recipe"},
    "projects.sidecar": {"apply_project": "apply"},
    "base.json_reader": {"BadFile": "BadFile"},
}
__all__ = sorted(name for names in _HOMES.values() for name in names)


if not TYPE_CHECKING:  # otherwise type checkers would accept every name

    def __getattr__(name: str) -> object:
        for module, names in _HOMES.items():
            if name in names:
                value = getattr(_import_module(f"{__name__}.{module}"), names[name])
                globals()[name] = value
                return value
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
