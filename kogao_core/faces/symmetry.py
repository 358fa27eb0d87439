"""Evens out the two sides of an outline: each goes half the way to the mirror image of the other.

The outline is compared with itself about its own axis: through the middle between its two ends,
along the line from the eyes to the mouth. About the line through eyes and mouth itself it would
mostly be the head's turn that differs (`docs/decisions/39`).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from kogao_core.base.geometry import Array, smoothstep
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across
from kogao_core.faces.zones import directions

# Up to the first a head counts as seen from the front, from the second on as turned; see `turn`.
_FRONTAL: Final = 0.1
_TURNED: Final = 0.25


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
    share = percent / 100.0 * _frontal(turn(face)) / 2.0
    if share == 0.0:
        return face.outline
    # Seen from between them the ends lie equally far to either side: they stay, and so the axis.
    origin = (face.outline[0] + face.outline[-1]) / 2.0
    degrees, radii = directions(face.outline, origin, across(face))
    order = np.argsort(degrees, kind="stable")
    others = np.interp(-degrees, degrees[order], radii[order])
    longer = share * (others - radii) / np.maximum(radii, 1e-12)
    return np.asarray(face.outline + longer[:, None] * (face.outline - origin))


def _frontal(turned: float) -> float:
    share = np.clip((turned - _FRONTAL) / (_TURNED - _FRONTAL), 0.0, 1.0)
    return 1.0 - float(smoothstep(share))
