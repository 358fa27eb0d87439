"""Layers over the photo, from the lowest to the topmost."""

from __future__ import annotations

from ..scene import Scene
from .base import Overlay
from .comparison import Divider
from .draft import Draft
from .inside import Displacement, Domains, Folds, LatticeLines
from .maps import HeatMap, JacobianMap
from .marks import Centre, Landmarks, Names, Placement, Targets
from .numbers import FaceNumbers
from .pixels import PixelGrid
from .protection import BrushRing, Protected
from .straight import StraightLines


def stack(scene: Scene) -> list[Overlay]:
    """Return all overlays of a scene in the order in which they are drawn."""
    return [
        PixelGrid("pixels", scene),
        HeatMap("heat", scene),
        JacobianMap("jacobian", scene),
        Domains("domains", scene),
        Folds("folds", scene),
        Protected("protection", scene),
        LatticeLines("lattice", scene),
        StraightLines("straight", scene),
        Displacement("displacement", scene),
        Centre("centre", scene),
        Targets("targets", scene),
        Landmarks("landmarks", scene),
        FaceNumbers("numbers", scene),
        Draft("draft", scene),
        Placement("placement", scene),
        Names("names", scene),
        Divider("divider", scene),
        BrushRing("brush", scene),
    ]
