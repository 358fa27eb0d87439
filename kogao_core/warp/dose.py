"""How far a face comes towards its centre, asked and achieved, in % of D (figures 6 and 7b).

The percentage of a recipe places targets. What the field makes of them is another number: a fit
that approximates goes past some targets and stays short of others, neighbours' fields add up, and
guard, fade and protected places hold back.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.targets import Pairs
from kogao_core.warp.field import Field, shown_at


def asked_percent(pairs: Pairs) -> float:
    """Return `toward_center_percent` of the targets: the recipe's percentage, without drags.

    Parameters
    ----------
    pairs : Pairs
        Of one face.

    Returns
    -------
    float
        %.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> from kogao_core.warp.dose import asked_percent
    >>> from kogao_core.faces.targets import aim
    >>> face = kogao.template_face((240, 180), 200)
    >>> round(asked_percent(aim(face, kogao.Recipe(percent=6))), 6)
    6.0
    """
    return toward_center_percent(pairs, pairs.target_px)


def achieved_percent(field: Field, pairs: Sequence[Pairs]) -> tuple[float, ...]:
    """Return `toward_center_percent` of the places where the result shows the landmarks.

    Parameters
    ----------
    field : Field
        Of all faces.
    pairs : sequence of Pairs
        One for each face.

    Returns
    -------
    tuple of float
        %, one for each face.

    Examples
    --------
    >>> import numpy as np
    >>> import kogao_core as kogao
    >>> from kogao_core.warp.dose import achieved_percent
    >>> face = kogao.template_face((240, 180), 200)
    >>> photo = np.zeros((360, 480), np.uint8)
    >>> rendering = kogao.render(photo, [face], kogao.Recipe(percent=6))
    >>> [round(percent, 1) for percent in achieved_percent(rendering.field, rendering.pairs)]
    [6.0]
    """
    if not pairs:
        return ()
    sources = np.concatenate([p.source_px for p in pairs])
    targets = np.concatenate([p.target_px for p in pairs])
    ends = np.cumsum([len(p.source_px) for p in pairs])
    moved = np.split(shown_at(field, sources, targets), ends[:-1])
    return tuple(toward_center_percent(p, mine) for p, mine in zip(pairs, moved, strict=True))


def toward_center_percent(pairs: Pairs, moved_px: Array) -> float:
    """Return how far landmarks have come towards the centre: the mean over them, in % of D.

    For a landmark p with centre c, ``D = |c - p|`` and place p' it is ``(p' - p) . (c - p) / D^2``:
    positive inwards, negative outwards, 0 for what moves across.

    Parameters
    ----------
    pairs : Pairs
        The landmarks of the outline, 21 of a face, and their centre.
    moved_px : array of shape (N, 2)
        Where they are now.

    Returns
    -------
    float
        %.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> from kogao_core.warp.dose import toward_center_percent
    >>> from kogao_core.faces.targets import aim
    >>> face = kogao.template_face((240, 180), 200)
    >>> pairs = aim(face, kogao.Recipe())
    >>> halfway = (pairs.source_px + pairs.center_px) / 2
    >>> toward_center_percent(pairs, halfway)
    50.0
    """
    toward = pairs.center_px - pairs.source_px
    along = ((moved_px - pairs.source_px) * toward).sum(axis=1)
    squared = np.maximum(
        (toward**2).sum(axis=1), 1e-18
    )  # a landmark on the centre can't come closer
    return 100.0 * float((along / squared).mean())
