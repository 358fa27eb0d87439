"""The pivot: the point about which a head shrinks, attracted by places that must stay.

A place q with the weight w(q), on a protected line or on the edge of a head in front, attracts the
pivot p::

    p' = p + sum w(q) (q - p) / (w0 + sum w(q)),    w(q) = length(q) / size * near(q)

near(q) falls smoothly from 1 at a landmark to 0 at `_ATTRACTED` sizes of the face away from all
landmarks. So p' minimises ``w0 |p' - p|^2 + sum w(q) |p' - q|^2``: least squares with a Tikhonov
term. `docs/figures/pivot.svg` draws a pivot, a stroke and the moved pivot (`docs/decisions/16`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Final

import numpy as np

from kogao_core.additions.contact import ahead, head_corners
from kogao_core.additions.lens import away_px
from kogao_core.base.geometry import smoothstep
from kogao_core.faces.face import Face
from kogao_core.faces.head import HeadFrame
from kogao_core.faces.targets import FacePairs
from kogao_core.field.protection import Stroke, Strokes, sampled

# Protected places up to this far from a landmark attract the pivot, in eyes-to-chin distances.
_ATTRACTED: Final = 0.5
# The pivot's own weight against a protected line as long as the eyes-to-chin distance.
_OWN_WEIGHT: Final = 0.25
_SAMPLES: Final = 20  # of such a line


def attract_pivots(
    pairs: Sequence[FacePairs], faces: Sequence[Face], strokes: Strokes, still: Sequence[Face] = ()
) -> tuple[FacePairs, ...]:
    """Move pivots towards protected places and heads in front nearby, and all targets alike.

    A head that shrinks about such a place moves little there and keeps its shape. Targets placed by
    hand stay.
    """
    if not pairs or not (strokes or still or len(pairs) > 1):
        return tuple(pairs)
    sizes, found = [HeadFrame.of(face).height_px for face in faces], []
    step_px, heads = min(sizes) / _SAMPLES, (*faces, *still)
    protected = sampled(strokes, step_px)
    rings = [Stroke(np.vstack([ring := head_corners(one), ring[:1]])) for one in heads]
    edges = [sampled([ring], step_px) for ring in rings]
    every = np.vstack([protected, *edges])
    # A protected place attracts all heads, a place on the edge of a head those behind it.
    owners = np.repeat(np.arange(len(heads)), [len(edge) for edge in edges])
    shares = np.vstack([np.ones((len(protected), len(heads))), ahead(heads)[owners]])
    for k, (pair, face, size) in enumerate(zip(pairs, faces, sizes, strict=True)):
        reach = every[:, 3:] + _ATTRACTED * size
        low, high = face.points.min(axis=0) - reach, face.points.max(axis=0) + reach
        inside = ((every[:, :2] > low) & (every[:, :2] < high)).all(axis=1)
        near = every[inside]
        near[:, 2] *= shares[inside, k]
        places, (lengths, radii) = near[:, :2], near[:, 2:].T
        away = (away_px(places, face.points) - radii) / (_ATTRACTED * size)
        weights = lengths / size * smoothstep(1.0 - away)
        shift = weights @ (places - pair.center_px) / (_OWN_WEIGHT + weights.sum())
        moved = pair.target_px + pair.head_share * shift
        if face.targets is not None:
            moved = np.where(np.isnan(face.targets), moved, pair.target_px)
        center = pair.center_px + (shift if pair.head_share else 0.0)
        found.append(dataclasses.replace(pair, target_px=moved, center_px=center))
    return tuple(found)
