"""Menu of landmark sources."""

from __future__ import annotations

from functools import partial
from itertools import chain, repeat
from typing import Final

from kogao_core.faces.face import LandmarkSource
from kogao_core.faces.landmarks import CHOICES, Measured, networks_are_here, source

from ..actions import Item
from ..i18n import tr, translated
from .faces import Faces
from .feature import Context, Feature

_KEYS: Final = ("F5", "F6", "F7", "Shift+F7")  # keys of the landmark sources


class LandmarkSources(Feature):
    """Actions of the Experiments menu that select the landmark source of `Faces`."""

    def __init__(self, context: Context, faces: Faces, first: LandmarkSource) -> None:
        super().__init__(context)
        self._faces = faces
        choice = next((choice for choice in CHOICES if choice.name == first.name), None)
        # Name of the source; None: the default.
        self.wanted = None if choice is None else choice.name
        if choice is not None and not choice.needs_networks and not networks_are_here():
            faces.found.connect(self._tell_of_fallback)
        for one, key in zip(CHOICES, chain(_KEYS, repeat("")), strict=False):
            text = tr("Landmarks by the {title}", title=translated(one.title))
            tip = _figures(one.measured) if one.measured else translated(one.help)
            command = Item(f"landmarks-{one.name}", text, key, tip)
            self.bind(command, partial(self.use, one.name), checked=False)
        names = [f"landmarks-{one.name}" for one in CHOICES]
        self.one_of(*names)
        self.actions.get(f"landmarks-{first.name}", self.actions[names[0]]).setChecked(True)

    def use(self, name: str) -> None:
        """Search for faces again with the landmark source of this name."""
        self.wanted = name
        self._faces.use(source(name))

    def _tell_of_fallback(self) -> None:
        self._faces.found.disconnect(self._tell_of_fallback)
        self.say(
            tr(
                "The networks are missing, so landmarks come from the AAM, which is less "
                "exact. kogao-cli doctor says how to get them."
            )
        )


def _figures(measured: Measured) -> str:
    return tr(
        "Outline within {studio:g} % of the eyes' distance on studio portraits, "
        "{wild:g} % elsewhere; about {ms:.0f} ms",
        studio=measured.studio_jaw,
        wild=measured.wild_jaw,
        ms=measured.typical_ms,
    )
