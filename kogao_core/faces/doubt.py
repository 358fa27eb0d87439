"""Why a face that was found may be better left as it is: nobody is sure of it, or it is hidden."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal

import numpy as np

from kogao_core.base.geometry import Box
from kogao_core.faces.face import Face

Doubt = Literal["unsure", "cut", "hidden"]
# By the mesh: of 157 portraits one face scores less, of 24 faces in two groups two, both behind
# others.
SURE: Final = 0.75
# A landmark below this is more likely hidden than seen.
SEEN: Final = 0.5
# A tenth is an ear; a face with more outside its photo is cut.
MOST_OUTSIDE: Final = 0.1
# No portrait of the 157 hides more than 41 % of its landmarks; three faces in the groups hide 59 %.
MOST_HIDDEN: Final = 0.5


def doubt(face: Face, image: Box) -> Doubt | None:
    """Return what speaks against changing a face; None if nothing does."""
    if face.source == "manual":
        return None
    if face.score < SURE:
        return "unsure"
    if outside(face, image) > MOST_OUTSIDE:
        return "cut"
    if hidden(face) > MOST_HIDDEN:
        return "hidden"
    return None


def outside(face: Face, image: Box) -> float:
    """Return the share of a face's landmarks that lie outside the photo."""
    # Pixels reach half a px beyond their centres.
    low = np.array([image.left, image.top]) - 0.5
    high = np.array([image.right, image.bottom]) - 0.5
    points = face.points
    return float(((points < low) | (points > high)).any(axis=1).mean())


def hidden(face: Face) -> float:
    """Return the share of a face's landmarks that are more likely hidden than seen."""
    return 0.0 if face.confidence is None else float((face.confidence < SEEN).mean())


def doubtful(faces: Sequence[Face], image: Box) -> frozenset[int]:
    """Return the indices of the faces to leave as they are unless told otherwise.

    Result: those in `doubt`; empty for a photo of one face: it is what the photo was taken for.
    """
    if len(faces) < 2:
        return frozenset()
    return frozenset(i for i, face in enumerate(faces) if doubt(face, image) is not None)
