"""Shape a face: make parts of the outline slimmer or shorter, and even out the two sides.

A zone of the outline is a smooth weight of the landmark's direction from the middle between eyes
and mouth: cheeks, jaw and chin, left and right. Cheeks end at the eye line.

To even out the sides, each side moves half the way to the mirror image of the other side. The
mirror axis runs through the middle between the outline's two ends, parallel to the line from the
eyes to the mouth. With that line as the axis, the difference would mostly be the head's turn
(`docs/decisions/39`).

A `Shape` moves zones towards the centre or away from it, and scales the whole face across the head
and along it. The outline does not include the hairline; `surround` moves the hairline.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, smoothstep
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across
from kogao_core.recipe.recipe import Recipe

# Direction of the middle of the jaw, in degrees from the chin; the chin ends here and the cheeks
# begin. Larger values make the chin wider.
_JAW: Final = 45.0
# From this direction on, in degrees from the chin, the jaw does not count. Larger: a wider jaw.
_CHEEKS: Final = 90.0
# The cheeks count fully from this height below the eye line, in distances from the eyes to the
# mouth, and not at all above the eye line. Larger values: temples move less.
_BELOW_EYES: Final = 0.7
# Left and right pass into each other within this angle of the chin, in degrees.
_MIXED: Final = 45.0
# A head counts as seen from the front below this `turn`, and its sides are evened out in full.
_FRONTAL: Final = 0.1
# Above this `turn` a head counts as turned, and its sides stay as they are.
_TURNED: Final = 0.25


def directions(outline: Array, origin: npt.ArrayLike, across_px: Array) -> tuple[Array, Array]:
    """Return direction and distance of an outline's points, seen from a point inside the face.

    `origin` (2,) px; `across_px` (2,). Result: (N,): degrees from the direction of the chin, -180
    to 180, negative on the left; (N,): distances, px.
    """
    away = outline - np.asarray(origin)
    down = np.array([-across_px[1], across_px[0]])
    right, below = away @ across_px, away @ down
    return np.degrees(np.arctan2(right, below)), np.hypot(right, below)


def weights(face: Face) -> tuple[Array, Array, Array, Array, Array]:
    """Return each landmark's weight in the zones chin, jaw, cheeks, left and right; (N,) each."""
    right = across(face)
    degrees, _ = directions(face.outline, face.middle, right)
    beyond_chin = _cosine_step(np.abs(degrees), 0.0, _JAW)
    beyond_jaw = _cosine_step(np.abs(degrees), _JAW, _CHEEKS)
    below = (face.outline - face.eye_center) @ np.array([-right[1], right[0]])
    height = float(np.linalg.norm(face.mouth_center - face.eye_center))
    cheeks = beyond_jaw * smoothstep(below / max(1e-12, _BELOW_EYES * height))
    on_right = _cosine_step(degrees, -_MIXED, _MIXED)
    return 1.0 - beyond_chin, beyond_chin - beyond_jaw, cheeks, 1.0 - on_right, on_right


def turn(face: Face) -> float:
    """Return how far a head is turned, from the offset of eyes and mouth to the outline's middle.

    Result: 0 where the line through eyes and mouth halves the outline's width at the eyes, 1 where
    it goes through one of its ends.
    """
    left, right = (face.outline[[0, -1]] - face.eye_center) @ across(face)
    return float(abs(left + right) / max(1e-12, abs(right - left)))


def evened(face: Face, percent: float) -> Array:
    """Return the outline with its two sides evened out.

    Landmarks move straight to or from the middle between the outline's ends. The more the head is
    turned, the less the landmarks move: the sides of a turned face aren't mirror images. Result
    (N, 2) px.
    """
    aside = smoothstep(np.asarray((turn(face) - _FRONTAL) / (_TURNED - _FRONTAL)))
    share = percent / 100.0 * (1.0 - float(aside)) / 2.0
    if share == 0.0:
        return face.outline
    # From this origin both ends have equal distances, so ends and axis keep their positions.
    origin = (face.outline[0] + face.outline[-1]) / 2.0
    degrees, radii = directions(face.outline, origin, across(face))
    order = np.argsort(degrees, kind="stable")
    others = np.interp(-degrees, degrees[order], radii[order])
    longer = share * (others - radii) / np.maximum(radii, 1e-12)
    return np.asarray(face.outline + longer[:, None] * (face.outline - origin))


def _cosine_step(values: Array, low: float, high: float) -> Array:
    """Return 0 up to `low`, 1 from `high` on, and half a cosine wave between."""
    share = np.clip((values - low) / (high - low), 0.0, 1.0)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * share))


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """Moves of a face's parts towards the centre, as shares of their distance; < 0 is away."""

    zones: Array  # (N,): share of each landmark, from its zones
    axes: Array  # (2, 2): unit vectors across the head, and down
    aside: float  # share for the whole face across the head
    down: float  # share for the whole face along the head
    hairline: float  # share for the top of the forehead along the head

    @classmethod
    def of(cls, face: Face, recipe: Recipe) -> Shape | None:
        """Return the shape in a recipe; None if all shape settings are 0."""
        if recipe.whole_face:
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
        """Return moves towards the centre for points scaled with the whole face, (N, 2), px.

        `away` (N, 2): position relative to the centre, px; `aside`, `down` (N,): extra shares.
        """
        along = away @ self.axes.T
        return np.asarray(
            along
            * np.stack(np.broadcast_arrays(self.aside + aside, self.down + down), axis=-1)
            @ self.axes
        )

    def inwards(self, away: Array) -> Array:
        """Return the moves of the outline's landmarks towards the centre, (N, 2), px."""
        return self.scaled(away) + self.zones[:, None] * away
