"""Check detected faces: skip doubtful faces, and list landmarks for a check by eye."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final, Literal

import numpy as np

from kogao_core.base.geometry import Array, Box, degrees_of
from kogao_core.base.language import Text
from kogao_core.faces.face import Face, select
from kogao_core.faces.reshape import turns

Reason = Literal["unsure", "cut", "hidden", "on its head", "turned"]
# Least score of a face that has no similar face in the photo.
SURE: Final = 0.75
# A score from which a face supports similar faces fully; support begins at SURE.
_SUPPORTS: Final = 0.9
# Support raises the odds of a face at most by this factor.
_MOST_SUPPORT: Final = 4.0
_HALF_SUPPORT: Final = 4.0  # this many sure faces of the same size give half of the gain
# A landmark with a lower confidence is more likely hidden than visible.
SEEN: Final = 0.5
# Least mean confidence of outline, eyes and mouth. Misplaced faces of the shared groups have at
# most 0.44, visible faces at least 0.61.
LEAST_SEEN: Final = 0.55
# Largest share of landmarks outside the photo. A tenth is an ear; with more, the face is cut.
MOST_OUTSIDE: Final = 0.1
# The landmarks should be checked if the outline's mean confidence, without so many points at each
# end, which hair often covers, is below `SEEN`.
_ENDS: Final = 2
# Outer inter-ocular distance over that from eyes to mouth: 0.57 and 0.64 in the two profiles of the
# photographs at hand, at least 0.92 in 855 other faces, 1.4 in most.
LEAST_ACROSS: Final = 0.8
# Rolls, degrees: least roll of an upside-down face, and largest roll of an upright face.
ON_ITS_HEAD: Final = 120.0
UPRIGHT: Final = 60.0
# Largest angle without a landmark of an outline set by hand, seen from the middle of the face, and
# the angle at which the outline would start and end: so it begins and ends above 60 degrees.
_GAP: Final = np.radians(90.0)
_END: Final = np.radians(150.0)


@dataclass(frozen=True, slots=True)
class Verdict:
    """Quality check of a detected face: a reason to skip the face, or landmarks to review."""

    # Why the face is skipped by default; None: the face is processed.
    reason: Reason | None = None
    # Rows of `Face.points` that may be wrong; empty if the face is skipped.
    look_at: tuple[int, ...] = ()
    why: str = ""  # explanation as part of a sentence; empty if there is nothing to check

    def told(self, number: int) -> str:
        """Return a message on the face with this number, counted from 1; may be empty."""
        if self.reason is not None:
            return Text("face {number} is left alone: {why}", number=number, why=self.why)
        return Text("face {number}: {why}", number=number, why=self.why) if self.why else ""

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form for `kogao-cli detect --json`."""
        doubt = None if self.reason is None else {"reason": self.reason, "why": self.why}
        return {"doubt": doubt, "look_at": list(self.look_at)}


def verdicts(faces: Sequence[Face], image: Box) -> list[Verdict]:
    """Check each face of a photo.

    Result: in the order of the faces. A face placed by hand is never skipped.
    """
    upright = any(abs(_roll(face)) < UPRIGHT for face in faces)
    both = zip(faces, _least_scores(faces).tolist(), strict=True)
    return [_verdict(face, image, least_score, upright) for face, least_score in both]


def doubtful(faces: Sequence[Face], image: Box) -> frozenset[int]:
    """Return the indices of the faces that are skipped by default, see `verdicts`."""
    judged = enumerate(verdicts(faces, image))
    return frozenset(index for index, verdict in judged if verdict.reason is not None)


def outside(face: Face, image: Box) -> float:
    """Return the share of a face's landmarks outside the photo, 0 to 1."""
    # Pixels reach half a px beyond their centres.
    low = np.array([image.left, image.top]) - 0.5
    high = np.array([image.right, image.bottom]) - 0.5
    points = face.points
    return float(((points < low) | (points > high)).any(axis=1).mean())


def uncertain(face: Face) -> tuple[int, ...]:
    """Return the rows of `Face.points` that are more likely hidden than visible."""
    if face.confidence is None:
        return ()
    return tuple(np.flatnonzero(face.confidence < SEEN).tolist())


def is_partial(face: Face) -> bool:
    """Return whether the outline of a face set by hand is marked only in part."""
    angles = np.sort(np.clip(turns(face, face.outline), -_END, _END))
    gaps = np.diff([-_END, *angles.tolist(), _END])
    return face.source == "manual" and bool(gaps.max() > _GAP)


class AllDoubted(Exception):
    """All requested faces are doubtful; the message gives the reasons."""


@dataclass(frozen=True, slots=True)
class Chosen:
    """Faces of a photo, selected by `choose`."""

    # Faces to make smaller, and all other faces.
    faces: list[Face]
    others: list[Face]
    # Skipped faces with reasons, and landmarks to check; empty if there are none.
    note: str
    every: list[Face]  # all faces, in the order of the photo


def choose(faces: Sequence[Face], which: str, image: Box, *, doubtful: bool = False) -> Chosen:
    """Select the requested faces of a photo; skip doubtful faces unless `doubtful` is True.

    Raises AllDoubted.
    """
    asked, taken, notes = select(faces, which), [], []
    for number, (face, verdict) in enumerate(zip(faces, verdicts(faces, image), strict=True), 1):
        if not any(face is one for one in asked):
            continue
        if verdict.reason is None or doubtful:
            taken.append(face)
        if verdict.reason is None or not doubtful:
            notes.append(verdict.told(number))
    if not taken:
        raise AllDoubted(Text.joined("; ", notes))
    others = [face for face in faces if all(face is not one for one in taken)]
    return Chosen(taken, others, Text.joined("; ", notes), list(faces))


def _least_scores(faces: Sequence[Face]) -> Array:
    """Return the least score of each face, shape (N,): lower with sure faces of similar size.

    Faces in groups have similar sizes, so a sure face makes another of that size more likely.
    """
    sizes = np.log2([face.anchor.spacing_px for face in faces])
    scores = np.array([face.score for face in faces])
    supports = np.clip((scores - SURE) / (_SUPPORTS - SURE), 0.0, 1.0)
    alike = np.exp(-0.5 * np.subtract.outer(sizes, sizes) ** 2)
    np.fill_diagonal(alike, 0.0)
    support = alike @ supports
    gain = 1.0 + (_MOST_SUPPORT - 1.0) * support / (support + _HALF_SUPPORT)
    odds = SURE / (1.0 - SURE) / gain
    return np.asarray(odds / (1.0 + odds))


def _seen(face: Face) -> float:
    """Return the mean confidence of outline, eyes and mouth, each part counted once."""
    if face.confidence is None:
        return 1.0
    parts = np.split(face.confidence, [len(face.outline), len(face.outline) + len(face.eyes)])
    return float(np.mean([part.mean() for part in parts]))


def _verdict(face: Face, image: Box, least_score: float, others_upright: bool) -> Verdict:
    if face.source == "manual":
        why = Text("its outline is marked only in part") if is_partial(face) else ""
        return Verdict(why=why)
    rows, seen = uncertain(face), _seen(face)
    down_px = float(np.linalg.norm(face.mouth_center - face.eye_center))
    unsure = Text(
        "it is {n:.0f} % sure that this is a face, less than {least:.0f} %",
        n=100.0 * face.score,
        least=100.0 * least_score,
    )
    on_its_head = Text("it would stand on its head, and others are upright")
    turned = Text("it is turned so far that one side of it is out of sight")
    cut = Text("part of it lies outside the photo")
    hidden = Text(
        "its outline, eyes and mouth are {n:.0f} % certain on average, less than {least:.0f} %",
        n=100.0 * seen,
        least=100.0 * LEAST_SEEN,
    )
    against: tuple[tuple[Reason, bool, Text], ...] = (
        ("unsure", face.score < least_score, unsure),
        ("on its head", others_upright and abs(_roll(face)) > ON_ITS_HEAD, on_its_head),
        ("turned", face.interocular_px < LEAST_ACROSS * down_px, turned),
        ("cut", outside(face, image) > MOST_OUTSIDE, cut),
        ("hidden", seen < LEAST_SEEN, hidden),
    )
    for reason, speaks, why in against:
        if speaks:
            return Verdict(reason, why=why)
    between = slice(_ENDS, len(face.outline) - _ENDS)
    sure = face.confidence is None or face.confidence[between].mean() >= SEEN
    return Verdict() if sure else Verdict(look_at=rows, why=_points(face, rows))


def _points(face: Face, rows: Sequence[int]) -> Text:
    """Return the possibly wrong landmarks as one line of text, counted from 1 in each part."""
    ends = np.cumsum([0, len(face.outline), len(face.eyes), len(face.mouth)]).tolist()
    outline, eyes, mouth = (
        " ".join(str(row - first + 1) for row in rows if first <= row < last)
        for first, last in pairwise(ends)
    )
    named = [
        Text("outline {points}", points=outline) if outline else "",
        Text("eyes {points}", points=eyes) if eyes else "",
        Text("mouth {points}", points=mouth) if mouth else "",
    ]
    return Text(
        "look at these points, they may be wrong: {points}", points=Text.joined(", ", named)
    )


def _roll(face: Face) -> float:
    return degrees_of(face.eyes[3] - face.eyes[0])
