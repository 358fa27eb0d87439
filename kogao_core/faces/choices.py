"""The landmark sources, declared once for the command line, the editor's menu and `source`.

A module of its own, so that help is printed without loading numpy.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Final

from kogao_core.base.language import Text

if TYPE_CHECKING:
    from kogao_core.faces.face import LandmarkSource


@dataclass(frozen=True, slots=True)
class Measured:
    """Measured accuracy and speed of a landmark source (docs/measurements.md)."""

    # Mean distance from labelled jaw points to the outline on studio portraits and in the wild, %
    # of the outer inter-ocular distance, on faces left out of training.
    studio_jaw: float
    wild_jaw: float
    typical_ms: float  # time for a portrait of about a megapixel with one face, on two cores


@dataclass(frozen=True, slots=True)
class Choice:
    """A landmark source of this program."""

    name: str  # value of ``--landmarks``
    title: str  # name in menus, without an article
    place: str  # module and class in `kogao_core.faces.landmarks`
    needs_networks: bool  # True: the source needs the networks fetched at build time
    measured: Measured | None = None  # None: not measured
    help: str = ""  # difference from the other sources in one sentence; may be empty

    def make(self) -> LandmarkSource:
        """Return the source; the first search loads the models."""
        module, _, kind = self.place.rpartition(".")
        source: LandmarkSource
        source = getattr(import_module(f"kogao_core.faces.landmarks.{module}"), kind)()
        return source


# The default is the first source with all files installed.
CHOICES: Final = (
    Choice("mesh", Text("mesh"), "mesh.MeshSource", True, Measured(0.9, 2.0, typical_ms=60.0)),
    Choice("aam", Text("AAM"), "aam.source.AamSource", False, Measured(1.7, 3.3, typical_ms=65.0)),
    Choice(
        "chin",
        Text("jaw under beards"),
        "mesh.ChinSource",
        True,
        help=Text("As the mesh, but where there is a beard, the outline is the chin under it"),
    ),
)
