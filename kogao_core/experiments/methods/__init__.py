"""The warps of the paper's references and of today's practice, behind one protocol."""

from __future__ import annotations

from typing import Final

from kogao_core.experiments.methods.base import Method, Warp, WarpTask
from kogao_core.experiments.methods.bsplines import BSpline
from kogao_core.experiments.methods.liquify import Liquify
from kogao_core.experiments.methods.mesh import PiecewiseAffine
from kogao_core.experiments.methods.moving import MovingLeastSquares
from kogao_core.experiments.methods.scattered import Radial, ThinPlate
from kogao_core.language import Text
from kogao_core.settings import FITS

METHODS: Final[tuple[Method, ...]] = (
    *(BSpline(fit.name, Text("B-spline, {fit}", fit=fit.word), fit.reference) for fit in FITS),
    ThinPlate(),
    Radial(),
    PiecewiseAffine(),
    MovingLeastSquares(),
    Liquify(),
)

__all__ = ["METHODS", "Method", "Warp", "WarpTask"]
