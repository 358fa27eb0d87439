"""Which faces are better left alone, and which points of the others better looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final, Literal

import numpy as np

from kogao_core.base.geometry import Box, degrees_of
from kogao_core.base.language import Text
from kogao_core.faces.face import Face, select

Reason = Literal["unsure", "cut", "hidden", "on its head", "turned"]
# By the mesh: of 157 portraits one face scores less, of 24 faces in two groups two, both behind
# others.
SURE: Final = 0.75
# A landmark below this is more likely hidden than seen.
SEEN: Final = 0.5
# A tenth is an ear; a face with more outside its photo is cut.
MOST_OUTSIDE: Final = 0.1
# No portrait of the 157 hides more than 41 % of its landmarks; three faces in the groups hide 59 %.
MOST_HIDDEN: Final = 0.5
# A face with more uncertain landmarks than this may well be wrong somewhere.
MOST_UNCERTAIN: Final = 0.3
# Outer inter-ocular distance over that from eyes to mouth: 0.57 and 0.64 in the two profiles of the
# photographs at hand, at least 0.92 in 855 other faces, 1.4 in most.
LEAST_ACROSS: Final = 0.8
# Rolls, degrees: of a face on its head, and of one that is upright beside it.
ON_ITS_HEAD: Final = 120.0
UPRIGHT: Final = 60.0


@dataclass(frozen=True, slots=True)
class Verdict:
    """What is thought of a face that was found."""

    # What speaks against changing it: it is left alone unless told otherwise.
    reason: Reason | None = None
    # Rows of `Face.points` that may be wrong, of a face that isn't left alone.
    look_at: tuple[int, ...] = ()
    why: str = ""  # either as part of a sentence; empty where there is nothing to say

    def told(self, number: int) -> str:
        """Return what there is to know of the face of a number, counted from 1; may be empty."""
        if self.reason is not None:
            return Text("face {number} is left alone: {why}", number=number, why=self.why)
        return Text("face {number}: {why}", number=number, why=self.why) if self.look_at else ""

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form that `kogao-cli detect --json` gives."""
        doubt = None if self.reason is None else {"reason": self.reason, "why": self.why}
        return {"doubt": doubt, "look_at": list(self.look_at)}


def verdicts(faces: Sequence[Face], image: Box) -> list[Verdict]:
    """Return what is thought of each face of a photo.

    Result: nothing speaks against a face placed by hand.
    """
    company = any(abs(_roll(face)) < UPRIGHT for face in faces)
    return [_verdict(face, image, company) for face in faces]


def doubtful(faces: Sequence[Face], image: Box) -> frozenset[int]:
    """Return the indices of the faces that are left alone unless told otherwise, see `verdicts`."""
    judged = enumerate(verdicts(faces, image))
    return frozenset(index for index, verdict in judged if verdict.reason is not None)


def outside(face: Face, image: Box) -> float:
    """Return the share of a face's landmarks that lie outside the photo."""
    # Pixels reach half a px beyond their centres.
    low = np.array([image.left, image.top]) - 0.5
    high = np.array([image.right, image.bottom]) - 0.5
    points = face.points
    return float(((points < low) | (points > high)).any(axis=1).mean())


def uncertain(face: Face) -> tuple[int, ...]:
    """Return the rows of `Face.points` that are more likely hidden than seen."""
    if face.confidence is None:
        return ()
    return tuple(np.flatnonzero(face.confidence < SEEN).tolist())


class AllDoubted(Exception):
    """Every face that was asked for is better left alone; its message is a sentence of why."""


@dataclass(frozen=True, slots=True)
class Chosen:
    """What is done with the faces of a photo."""

    # Those to make smaller, and those left alone.
    faces: list[Face]
    others: list[Face]
    # Which of those asked for are left alone and why, and whose points are better looked at; empty
    # where there is none.
    note: str


def choose(faces: Sequence[Face], which: str, image: Box, *, doubtful: bool = False) -> Chosen:
    """Pick the faces of a photo to make smaller: those asked for, but for doubtful ones.

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
    return Chosen(taken, others, Text.joined("; ", notes))


def _verdict(face: Face, image: Box, company: bool) -> Verdict:
    if face.source == "manual":
        return Verdict()
    rows = uncertain(face)
    share = len(rows) / len(face.points)
    down_px = float(np.linalg.norm(face.mouth_center - face.eye_center))
    unsure = Text(
        "it is {n:.0f} % sure that this is a face, less than {least:.0f} %",
        n=100.0 * face.score,
        least=100.0 * SURE,
    )
    on_its_head = Text("it would stand on its head, and others are upright")
    turned = Text("it is turned so far that one side of it is out of sight")
    cut = Text("part of it lies outside the photo")
    hidden = Text("{n:.0f} % of its landmarks are more likely hidden than seen", n=100.0 * share)
    against: tuple[tuple[Reason, bool, Text], ...] = (
        ("unsure", face.score < SURE, unsure),
        ("on its head", company and abs(_roll(face)) > ON_ITS_HEAD, on_its_head),
        ("turned", face.interocular_px < LEAST_ACROSS * down_px, turned),
        ("cut", outside(face, image) > MOST_OUTSIDE, cut),
        ("hidden", share > MOST_HIDDEN, hidden),
    )
    for reason, speaks, why in against:
        if speaks:
            return Verdict(reason, why=why)
    return Verdict(look_at=rows, why=_points(face, rows)) if share > MOST_UNCERTAIN else Verdict()


def _points(face: Face, rows: Sequence[int]) -> Text:
    """Return which points may be wrong, each part's counted from 1, in one line."""
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
