"""Measure a face before and after a warp, and the achieved warp distance in % of D.

The warp distance (figures 6 and 7b) is the mean move of the landmarks towards the centre, in % of
their distance D. The achieved distance can differ from the requested distance: an approximating
fit misses targets, fields of neighbours add up, and limits, fade and protection reduce moves.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array, check_type
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import across
from kogao_core.faces.targets import FacePairs
from kogao_core.field.field import Field, shown_at
from kogao_core.field.protection import NOTHING
from kogao_core.recipe.recipe import LOSSLESS_PX

# A landmark that makes less than this share of its move counts as reduced by protection.
NEARLY_WHOLE: Final = 0.95


@dataclass(frozen=True, slots=True)
class FaceMeasures:
    """Lengths of one face, px of its picture.

    Parameters
    ----------
    width_px : float
        Largest width of the outline, across the face's midline.
    jaw_px : float
        Width of the outline at the height of the mouth's corners.
    area_px2 : float
        Area inside the outline, closed by the line between its ends.
    interocular_px : float
        Distance between the outer corners of the eyes.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> round(kogao.measures(kogao.template_face((240, 180), 200)).jaw_to_eyes, 2)
    1.4
    """

    width_px: float
    jaw_px: float
    area_px2: float
    interocular_px: float

    @property
    def jaw_to_eyes(self) -> float:
        """Jaw width divided by the distance between the outer corners of the eyes."""
        return self.jaw_px / self.interocular_px


def measures(face: Face) -> FaceMeasures:
    """Measure a face.

    Parameters
    ----------
    face : Face
        Landmarks in px.

    Returns
    -------
    FaceMeasures
        Widths, area and the distance of the eyes, px.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> face = kogao.template_face((240, 180), 200)
    >>> round(kogao.measures(face).interocular_px, 1)
    125.6
    """
    check_type(face, Face, "from kogao.find")
    right = across(face)
    down = np.array([-right[1], right[0]])
    x, y = (face.outline - face.middle) @ right, (face.outline - face.middle) @ down
    level = float(((face.mouth - face.middle) @ down).mean())
    turned = np.roll(face.outline, -1, axis=0)
    area = (face.outline[:, 0] * turned[:, 1] - turned[:, 0] * face.outline[:, 1]).sum() / 2.0
    return FaceMeasures(
        float(np.ptp(x)), _width_at(x, y, level), abs(float(area)), face.interocular_px
    )


def _width_at(x: Array, y: Array, level: float) -> float:
    """Return the width of an outline at height `level`; the whole width without two crossings."""
    below = y >= level
    crossings = np.flatnonzero(below[1:] != below[:-1])
    if len(crossings) < 2:
        return float(np.ptp(x))
    ends = crossings[[0, -1]]
    share = (level - y[ends]) / (y[ends + 1] - y[ends])
    at = x[ends] + share * (x[ends + 1] - x[ends])
    return float(abs(at[1] - at[0]))


def moved(face: Face, field: Field, pairs: FacePairs) -> Face:
    """Return the face with every point at its position in the result."""
    return Face(
        shown_at(field, face.outline, pairs.target_px),
        shown_at(field, face.eyes),
        shown_at(field, face.mouth),
        forehead=None if face.forehead is None else shown_at(field, face.forehead),
        source=face.source,
    )


def asked_percent(pairs: FacePairs) -> float:
    """Return the requested warp distance of the targets, % of D. Dragged targets change it."""
    return toward_center_percent(pairs, pairs.target_px)


def achieved_percent(field: Field, pairs: Sequence[FacePairs]) -> tuple[float, ...]:
    """Return the achieved warp distance of each face, % of D."""
    shown = (shown_at(field, pair.source_px, pair.target_px) for pair in pairs)
    return tuple(toward_center_percent(*each) for each in zip(pairs, shown, strict=True))


def protected_shares(field: Field, pairs: Sequence[FacePairs]) -> tuple[tuple[float, ...], ...]:
    """Return the share of its move that protection leaves each landmark of each face, 0 to 1."""
    unprotected, found = dataclasses.replace(field, protection=NOTHING), []
    for pair in pairs if field.protection.strokes else ():
        before, after = (
            np.hypot(*(shown_at(one, pair.source_px, pair.target_px) - pair.source_px).T)
            for one in (unprotected, field)
        )
        share = np.clip(after / np.maximum(before, 1e-12), 0.0, 1.0)
        found.append(tuple(np.where(before > LOSSLESS_PX, share, 1.0).tolist()))
    return tuple(found)


def reduced(shares: Sequence[Sequence[float]]) -> list[float]:
    """Return the `protected_shares` of all landmarks that count as reduced."""
    return [share for each in shares for share in each if share < NEARLY_WHOLE]


def toward_center_percent(pairs: FacePairs, moved_px: Array) -> float:
    """Return the mean move of landmarks towards the centre, % of D.

    For a landmark p with centre c, ``D = |c - p|`` and new position p', the move is
    ``(p' - p) . (c - p) / D^2``: positive inwards, negative outwards, 0 for a move across.
    """
    toward = pairs.center_px - pairs.start_px
    along = ((moved_px - pairs.start_px) * toward).sum(axis=1)
    # A landmark on the centre can't come closer.
    squared = np.maximum((toward**2).sum(axis=1), 1e-18)
    if pairs.head_share:
        # The pivot may lie beside a landmark, where the quotient says nothing.
        return 100.0 * float(along.sum() / squared.sum())
    return 100.0 * float((along / squared).mean())
