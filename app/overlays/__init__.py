"""Layers over the photo, from the lowest to the topmost."""

from __future__ import annotations

from ..scene import Scene
from .base import Overlay
from .inside import Displacement, Domains, Folds, LatticeLines
from .marks import Centre, Landmarks, Names, Placement, Targets


def stack(scene: Scene) -> list[Overlay]:
    """Return all overlays of a scene in the order in which they are drawn."""
    return [
        Domains("domains", scene),
        Folds("folds", scene),
        LatticeLines("lattice", scene),
        Displacement("displacement", scene),
        Centre("centre", scene),
        Targets("targets", scene),
        Landmarks("landmarks", scene),
        Placement("placement", scene),
        Names("names", scene),
    ]
