"""The face reshaped directly: width, length and its parts, each signed, whatever the warp distance.

Where all of an outline goes, width and length by the same share are the paper's move (figure 6) by
that share: one scales it across, the other along the head, about the centre. Jaw, chin, cheeks and
sides move their zones (`zones`) towards the centre or away from it. The hairline isn't in the
outline; `surround` moves it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across
from kogao_core.faces.zones import weights
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import SHAPE


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """How far a face's parts come towards its centre, as shares of their distance; < 0 is away."""

    zones: Array  # (N,): each landmark, by its zones
    axes: Array  # (2, 2): what is across the head, and down
    aside: float  # all of it across the head
    down: float  # all of it along the head
    hairline: float  # the top of the forehead along the head

    @classmethod
    def of(cls, face: Face, recipe: Recipe) -> Shape | None:
        """Return what a recipe asks of a face; None for nothing."""
        if not any(getattr(recipe, name) for name in SHAPE):
            return None
        asked = (
            *(recipe.chin_length, recipe.jaw_width, recipe.cheeks_width),
            *(recipe.left_width, recipe.right_width),
        )
        zones = -np.asarray(asked) / 100.0 @ np.array(weights(face))
        right = across(face)
        shares = (-recipe.width / 100.0, -recipe.length / 100.0, -recipe.forehead_height / 100.0)
        return cls(zones, np.array([right, (-right[1], right[0])]), *shares)

    def scaled(self, away: Array, aside: Array | float = 0.0, down: Array | float = 0.0) -> Array:
        """Return how far points come towards the centre as all of the face does, (N, 2), px.

        `away` (N, 2): from the centre, px; `aside`, `down` (N,): more of it, as shares.
        """
        along = away @ self.axes.T
        return np.asarray(
            along
            * np.stack(np.broadcast_arrays(self.aside + aside, self.down + down), axis=-1)
            @ self.axes
        )

    def inwards(self, away: Array) -> Array:
        """Return how far the outline's landmarks come towards the centre, (N, 2), px."""
        return self.scaled(away) + self.zones[:, None] * away
