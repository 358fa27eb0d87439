"""Which pictures a study shows of each subject: the grid of table 1 and the sizes of figure 11."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Final, Literal

from kogao_core.faces.naturalness import DISTANCES
from kogao_core.recipe.recipe import PAPER, Recipe
from kogao_core.recipe.settings import PAPER_CENTERS

Kind = Literal["table1", "figure11", "control", "catch", "satisfaction"]
# The choice the paper comes to in section 3.2; figure 11 varies the lattice at it.
BEST_PERCENT: Final = 4.0
BEST_CENTER: Final = 2
# The paper shows four sizes and prints none. These stand on both sides of 1, from which on nobody
# called a face unnatural; in `Recipe.lattice_unit`.
LATTICES: Final = (0.25, 0.5, 1.0, 2.0)


@dataclass(frozen=True, slots=True, order=True)
class Variant:
    """One picture of a subject."""

    # What it is for: the grid of table 1, the lattice sizes of figure 11, the photo as it is among
    # them, one cut in two that nobody who looks calls natural, or the picture whose owner says how
    # satisfied they are.
    kind: Kind
    percent: float  # warp distance, % of D
    center: int  # centre candidate 1 to 4
    lattice: float  # lattice spacing R

    @property
    def what(self) -> tuple[float, int, float]:
        """What tells it from other pictures of its face, on the screen."""
        return self.percent, self.center, self.lattice

    @property
    def is_judged(self) -> bool:
        """Whether the study is about the answers to it."""
        return self.kind not in ("catch", "satisfaction")

    def recipe(self, base: Recipe) -> Recipe:
        """Return the recipe that makes the picture; the rest is as in `base`."""
        return dataclasses.replace(
            base, percent=self.percent, center=self.center, lattice=self.lattice
        )


def variants(
    base: Recipe = PAPER,
    lattices: tuple[float, ...] = LATTICES,
    *,
    control: bool = False,
    catch: bool = False,
    satisfaction: bool = False,
) -> tuple[Variant, ...]:
    """Return one subject's pictures: table 1's, figure 11's by R, and those asked for."""
    centers = range(1, len(PAPER_CENTERS) + 1)
    made = [Variant("table1", p, c, base.lattice) for c in centers for p in DISTANCES]
    made += [Variant("figure11", BEST_PERCENT, BEST_CENTER, size) for size in lattices]
    if control:
        made.append(Variant("control", 0.0, BEST_CENTER, base.lattice))
    if catch:
        made.append(Variant("catch", 0.0, BEST_CENTER, base.lattice))
    if satisfaction:
        made.append(Variant("satisfaction", BEST_PERCENT, BEST_CENTER, base.lattice))
    return tuple(made)
