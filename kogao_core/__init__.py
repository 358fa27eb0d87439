"""Kogao: automatic small-face warping by fast B-spline approximation (Seo, Chen and Aoki, 2011).

What `__all__` names is promised: read a photo, find its faces, render, write. Each name is loaded
when it is first asked for, so the import itself costs nothing.

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

TYPE_CHECKING = False  # loading `typing` takes ten times as long as all else here
if TYPE_CHECKING:
    from typing import Any

    from kogao_core.base.assets import sample
    from kogao_core.base.strict import BadFile
    from kogao_core.faces.face import Face
    from kogao_core.faces.landmarks.sources import find, source, template_face
    from kogao_core.photo.errors import CannotWrite, UnreadablePhoto
    from kogao_core.photo.formats.companions import accompanied
    from kogao_core.photo.model import Photo
    from kogao_core.photo.reading import read
    from kogao_core.photo.writing import write
    from kogao_core.pipeline import Rendering, render
    from kogao_core.projects.evidence import Evidence
    from kogao_core.projects.evidence import load as load_evidence
    from kogao_core.projects.project import Project
    from kogao_core.projects.project import load as load_project
    from kogao_core.projects.sidecar import apply as apply_project
    from kogao_core.recipe.recipe import PAPER, Recipe
    from kogao_core.warp.brush import Brushwork
    from kogao_core.warp.field import Field, shown_at
    from kogao_core.warp.measures import FaceMeasures, measures
    from kogao_core.warp.protection import Protection

__version__ = "0.1.0"
__all__ = [
    "PAPER",
    "BadFile",
    "Brushwork",
    "CannotWrite",
    "Evidence",
    "Face",
    "FaceMeasures",
    "Field",
    "Photo",
    "Project",
    "Protection",
    "Recipe",
    "Rendering",
    "UnreadablePhoto",
    "accompanied",
    "apply_project",
    "find",
    "load_evidence",
    "load_project",
    "measures",
    "read",
    "render",
    "sample",
    "shown_at",
    "source",
    "template_face",
    "write",
]

# The same as above, for when it runs; a test compares the two.
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
    "warp.brush": {"Brushwork": "Brushwork"},
    "warp.field": {"Field": "Field", "shown_at": "shown_at"},
    "warp.measures": {"FaceMeasures": "FaceMeasures", "measures": "measures"},
    "warp.protection": {"Protection": "Protection"},
    "recipe.recipe": {"PAPER": "PAPER", "Recipe": "Recipe"},
    "projects.sidecar": {"apply_project": "apply"},
    "base.strict": {"BadFile": "BadFile"},
}


def __getattr__(name: str) -> Any:
    for module, names in _HOMES.items():
        if name in names:
            found = getattr(_import_module(f"{__name__}.{module}"), names[name])
            globals()[name] = found
            return found
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
