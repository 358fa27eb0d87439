"""The warps of the paper's references and of today's practice, behind one interface."""

from __future__ import annotations

from typing import Final

from kogao_core.base.language import Text
from kogao_core.lab.methods.base import Method, Warp, WarpTask
from kogao_core.lab.methods.own import LIQUIFY, MOVING_LEAST_SQUARES, bspline
from kogao_core.lab.methods.scattered import PIECEWISE_AFFINE, RADIAL, THIN_PLATE
from kogao_core.recipe.settings import FITS

METHODS: Final[tuple[Method, ...]] = (
    *(bspline(fit.name, Text("B-spline, {fit}", fit=fit.word), fit.reference) for fit in FITS),
    THIN_PLATE,
    RADIAL,
    PIECEWISE_AFFINE,
    MOVING_LEAST_SQUARES,
    LIQUIFY,
)

__all__ = ["METHODS", "Method", "Warp", "WarpTask"]
