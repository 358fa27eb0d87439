"""Which pictures a study shows of each subject: the grid of table 1 and the sizes of figure 11."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Final, Literal

from kogao_core.faces.naturalness import DISTANCES
from kogao_core.recipe.recipe import PAPER, Recipe
from kogao_core.recipe.settings import PAPER_CENTERS, Fit

Kind = Literal["table1", "figure11", "control", "catch", "satisfaction", "practice"]
# The choice the paper comes to in section 3.2; figure 11 varies the lattice at it.
BEST_PERCENT: Final = 4.0
BEST_CENTER: Final = 2
# The paper shows four sizes and prints none. These stand on both sides of 1, from which on nobody
# called a face unnatural; in `Recipe.lattice_unit`.
LATTICES: Final = (0.25, 0.5, 1.0, 2.0)


# Pictures of table 1 that are compared as one: centre and fit.
Group = tuple[int, Fit]


@dataclass(frozen=True, slots=True, order=True)
class Variant:
    """One picture of a subject."""

    # What it is for: the grid of table 1, the lattice sizes of figure 11, the photo as it is among
    # them, one cut in two that nobody who looks calls natural, the picture whose owner says how
    # satisfied they are, or one to practise with.
    kind: Kind
    percent: float  # warp distance, % of D; below 0 the face becomes larger
    center: int  # centre candidate 1 to 4
    lattice: float  # lattice spacing R
    fit: Fit = PAPER.fit

    @property
    def group(self) -> Group:
        """What it is compared by."""
        return self.center, self.fit

    @property
    def what(self) -> tuple[object, ...]:
        """What tells it from other pictures of its face, on the screen."""
        if self.kind == "catch" or self.percent == 0.0:
            return (self.kind == "catch",)
        return self.percent, self.center, self.lattice, self.fit

    @property
    def is_judged(self) -> bool:
        """Whether the study is about the answers to it."""
        return self.kind not in ("catch", "satisfaction", "practice")

    def recipe(self, base: Recipe) -> Recipe:
        """Return the recipe that makes the picture; the rest is as in `base`."""
        return dataclasses.replace(
            base, percent=self.percent, center=self.center, lattice=self.lattice, fit=self.fit
        )


def variants(
    base: Recipe = PAPER,
    lattices: tuple[float, ...] = LATTICES,
    *,
    percents: tuple[float, ...] = DISTANCES,
    centers: tuple[int, ...] = tuple(range(1, len(PAPER_CENTERS) + 1)),
    fits: tuple[Fit, ...] | None = None,
    control: bool = False,
    catch: bool = False,
    satisfaction: bool = False,
) -> tuple[Variant, ...]:
    """Return one subject's pictures: table 1's, figure 11's by R, and those asked for."""
    made = [
        Variant("table1", percent, center, base.lattice, fit)
        for fit in fits or (base.fit,)
        for center in centers
        for percent in percents
    ]
    best = Variant("figure11", BEST_PERCENT, BEST_CENTER, base.lattice, base.fit)
    made += [dataclasses.replace(best, lattice=size) for size in lattices]
    single: dict[Kind, bool] = {"control": control, "catch": catch}
    made += [
        dataclasses.replace(best, kind=kind, percent=0.0)
        for kind, wanted in single.items()
        if wanted
    ]
    if satisfaction:
        made.append(dataclasses.replace(best, kind="satisfaction"))
    return tuple(made)


def practice(count: int, base: Recipe = PAPER) -> tuple[Variant, ...]:
    """Return pictures to practise with, the strongest and the photo as it is in turn."""
    ends = [(percent, center) for center in (2, 1, 3, 4) for percent in (max(DISTANCES), 0.0)]
    return tuple(Variant("practice", *end, base.lattice, base.fit) for end in ends[:count])
