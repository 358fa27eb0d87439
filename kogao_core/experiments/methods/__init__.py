"""The warps of the paper's references and of today's practice, behind one protocol."""

from __future__ import annotations

from typing import Final

from kogao_core.experiments.methods.base import Method, Warp, WarpTask
from kogao_core.experiments.methods.bsplines import BSpline
from kogao_core.experiments.methods.liquify import Liquify
from kogao_core.experiments.methods.mesh import PiecewiseAffine
from kogao_core.experiments.methods.moving import MovingLeastSquares
from kogao_core.experiments.methods.scattered import Radial, ThinPlate

METHODS: Final[tuple[Method, ...]] = (
    BSpline("approximation", "B-spline approximation", "the paper; [7], [9]", "approximation"),
    BSpline("exact", "B-spline, exact", "this program", "exact"),
    BSpline("multilevel", "B-spline, multilevel", "[8], [10], [12]", "multilevel"),
    ThinPlate(),
    Radial(),
    PiecewiseAffine(),
    MovingLeastSquares(),
    Liquify(),
)

__all__ = ["METHODS", "Method", "Warp", "WarpTask"]
