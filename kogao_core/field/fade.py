"""The fade of section 4.2 without its step: short displacements fade to zero, smoothly."""

from __future__ import annotations

from kogao_core.base.geometry import Box
from kogao_core.field.field import Field
from kogao_core.paper.domain import LOSSLESS_PX, Domain, reduce
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import DomainName


def fade_of(recipe: Recipe) -> float:
    """Return the displacement below which the field fades to zero, px; 0 for no fade.

    A threshold up to `LOSSLESS_PX` needs no fade: it leaves no visible seam.
    """
    lossless = recipe.domain != "threshold" or recipe.threshold_px <= LOSSLESS_PX
    return 0.0 if lossless else recipe.threshold_px


def threshold_of(recipe: Recipe, field: Field) -> float:
    """Return the threshold T in use, px: `LOSSLESS_PX` if the guard refused the recipe's fade."""
    return LOSSLESS_PX if fade_of(recipe) > field.fade_px else recipe.threshold_px


def domain_of(field: Field, image: Box, name: DomainName) -> Domain:
    """Return the domain of a field: of the threshold, the cells that its fade leaves moving."""
    return reduce(field.lattices, image, name, max(LOSSLESS_PX, field.fade_px))
