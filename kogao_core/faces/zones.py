"""Zones of the outline: how far cheeks, jaw, chin and either side go, beside what the rest does.

A zone is a smooth weight of the direction in which a landmark lies, seen from between the eyes and
the mouth: cheeks, jaw and chin add up to 1 everywhere, and so do left and right.

The two sides can be evened out: each goes half the way to the mirror image of the other, about the
outline's own axis, through the middle between its two ends along the line from the eyes to the
mouth. About that line itself it would mostly be the head's turn that differs
(`docs/decisions/39`).

A `Shape` moves the same zones directly, each signed, whatever the warp distance, and the whole
face's width and length: where all of an outline goes, these by the same share are the paper's move
(figure 6) by that share; one scales it across, the other along the head, about the centre. The
hairline isn't in the outline; `surround` moves it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, smoothstep
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across
from kogao_core.recipe.recipe import SHAPE, Recipe

# Directions in which a zone stands alone, in degrees from the chin: four landmarks lie between two
# of them. On the mean face the chin passes into the jaw below the corners of the mouth, half way,
# and the outline ends at 116.
_JAW: Final = 45.0
_CHEEKS: Final = 90.0
# Left and right are mixed this far to either side of the chin.
_MIXED: Final = 45.0
# Up to the first a head counts as seen from the front, from the second on as turned; see `turn`.
_FRONTAL: Final = 0.1
_TURNED: Final = 0.25


def directions(outline: Array, origin: npt.ArrayLike, across_px: Array) -> tuple[Array, Array]:
    """Return where the points of an outline lie, seen from a place inside the face.

    `origin` (2,) px; `across_px` (2,). Result: (N,): degrees from the direction of the chin, -180
    to 180; those on the left are negative; (N,): distances, px.
    """
    away = outline - np.asarray(origin)
    down = np.array([-across_px[1], across_px[0]])
    right, below = away @ across_px, away @ down
    return np.degrees(np.arctan2(right, below)), np.hypot(right, below)


def gains(face: Face, recipe: Recipe) -> Array:
    """Return how far each landmark goes beside the warp distance.

    Result (N,): 0 to 4; 1 to the bit where every zone is at 100 %.
    """
    chin, jaw, cheeks, left, right = weights(face)
    zones = (
        chin * _excess(recipe.chin) + jaw * _excess(recipe.jaw) + cheeks * _excess(recipe.cheeks)
    )
    sides = left * _excess(recipe.left) + right * _excess(recipe.right)
    return np.asarray((1.0 + zones) * (1.0 + sides))


def weights(face: Face) -> tuple[Array, Array, Array, Array, Array]:
    """Return how far each landmark belongs to a zone: chin, jaw, cheeks; left, right; (N,) each."""
    degrees, _ = directions(face.outline, face.middle, across(face))
    beyond_chin = _cosine_step(np.abs(degrees), 0.0, _JAW)
    cheeks = _cosine_step(np.abs(degrees), _JAW, _CHEEKS)
    right = _cosine_step(degrees, -_MIXED, _MIXED)
    return 1.0 - beyond_chin, beyond_chin - cheeks, cheeks, 1.0 - right, right


def turn(face: Face) -> float:
    """Return how far a head is turned: how far its eyes and mouth are from the outline's middle.

    Result: 0 where the line through eyes and mouth halves the outline's width at the eyes, 1 where
    it goes through one of its ends.
    """
    left, right = (face.outline[[0, -1]] - face.eye_center) @ across(face)
    return float(abs(left + right) / max(1e-12, abs(right - left)))


def evened(face: Face, percent: float) -> Array:
    """Return the outline with its two sides evened out.

    Landmarks move straight to or from the middle between the outline's ends. The more the head is
    turned, the less they move: the sides of a turned face aren't each other's mirror image. Result
    (N, 2) px.
    """
    aside = smoothstep(np.asarray((turn(face) - _FRONTAL) / (_TURNED - _FRONTAL)))
    share = percent / 100.0 * (1.0 - float(aside)) / 2.0
    if share == 0.0:
        return face.outline
    # Seen from between them the ends lie equally far to either side: they stay, and so the axis.
    origin = (face.outline[0] + face.outline[-1]) / 2.0
    degrees, radii = directions(face.outline, origin, across(face))
    order = np.argsort(degrees, kind="stable")
    others = np.interp(-degrees, degrees[order], radii[order])
    longer = share * (others - radii) / np.maximum(radii, 1e-12)
    return np.asarray(face.outline + longer[:, None] * (face.outline - origin))


def _excess(percent: float) -> float:
    # Gains are 1 and what is more or less, so that those of 100 % are 1 exactly.
    return percent / 100.0 - 1.0


def _cosine_step(values: Array, low: float, high: float) -> Array:
    """Return 0 up to `low`, 1 from `high` on, and half a cosine wave between."""
    share = np.clip((values - low) / (high - low), 0.0, 1.0)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * share))


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
