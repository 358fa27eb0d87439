"""The overlays that can be switched on and off, in the order of panel and menu."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from typing import Final

from ..handles import Kind
from .background import BentLines, People
from .lattice import Displacement, DomainRegions, Folds, LatticeLines
from .maps import HeatMap, JacobianMap
from .marks import Centre, Landmarks, Targets
from .overlay import Overlay
from .protection import Protected

LISTED: Final[tuple[type[Overlay], ...]] = (
    *(Landmarks, Targets, Centre),
    *(Displacement, LatticeLines, DomainRegions, Folds),
    *(HeatMap, JacobianMap),
    *(BentLines, People, Protected),
)


def kinds(visible: AbstractSet[str]) -> set[Kind]:
    """Return the kinds of handles that the visible overlays show."""
    return {kind for one in LISTED if one.name in visible for kind in one.handles}
